#pragma once

#include <fuse_flow/math/representatives.h>
#include <fuse_flow/point_traits.h>

#include <cstring>

namespace fuse_flow {
namespace gpu {

/** \brief How a point type lies in memory: PCL's points have constructors that device code cannot call, so the device writes
 *  their words, over those of a default point. */
template <typename PointT>
struct PointLayout {
  static_assert(sizeof(PointT) % 16 == 0 && alignof(PointT) <= 16, "a PCL point is made of 16-byte quarters");
  static constexpr int kWords = static_cast<int>(sizeof(PointT) / 4);
  static constexpr bool has_color = point::has_color<PointT>;
  static constexpr bool has_normal = point::has_normal<PointT>;

  struct alignas(16) Words {
    std::uint32_t word[kWords];
  };

  Words blank;

  PointLayout() {
    const PointT point{};
    std::memcpy(&blank, static_cast<const void*>(&point), sizeof(blank));
  }

  /** \brief As the CPU's pipeline writes a point. */
  FUSE_FLOW_HD Words words(const FusedPoint& fused, const Vec3& color, const Vec3& normal) const {
    Words w = blank;
    set<pcl::fields::x>(w, fused.p.x);
    set<pcl::fields::y>(w, fused.p.y);
    set<pcl::fields::z>(w, fused.p.z);
    if constexpr (point::has<PointT, pcl::fields::confidence>) {
      set<pcl::fields::confidence>(w, fused.weight);
    } else if constexpr (point::has<PointT, pcl::fields::intensity>) {
      set<pcl::fields::intensity>(w, fused.weight);
    }
    if constexpr (point::has<PointT, pcl::fields::view_count>)
      set<pcl::fields::view_count>(w, static_cast<std::uint32_t>(fused.views));
    if constexpr (has_color) {
      const std::uint32_t rgba = 0xff000000u | channel(color.x) << 16 | channel(color.y) << 8 | channel(color.z);
      if constexpr (point::has<PointT, pcl::fields::rgba>) {
        set<pcl::fields::rgba>(w, rgba);
      } else {
        set<pcl::fields::rgb>(w, rgba);
      }
    }
    if constexpr (has_normal) {
      set<pcl::fields::normal_x>(w, normal.x);
      set<pcl::fields::normal_y>(w, normal.y);
      set<pcl::fields::normal_z>(w, normal.z);
    }
    return w;
  }

 private:
  FUSE_FLOW_HD static std::uint32_t channel(float value) { return static_cast<std::uint32_t>(value + 0.5f); }

  template <typename Field, typename Value>
  FUSE_FLOW_HD static void set(Words& w, const Value& value) {
    static_assert(sizeof(Value) == 4 && pcl::traits::offset<PointT, Field>::value % 4 == 0, "fields are of words");
    std::memcpy(&w.word[pcl::traits::offset<PointT, Field>::value / 4], &value, 4);
  }
};

}  // namespace gpu
}  // namespace fuse_flow
