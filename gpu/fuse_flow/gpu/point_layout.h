#pragma once

#include <fuse_flow/math/representatives.h>
#include <fuse_flow/point_traits.h>

#include <cstring>

namespace fuse_flow {
namespace gpu {

/** \brief How a point type lies in memory: PCL's points have constructors that device code cannot call, so the device reads and
 *  writes their words; what it makes it writes over those of a default point. The functions are those of
 *  point_traits.h. */
template <typename PointT>
struct PointLayout {
  static_assert(sizeof(PointT) % 16 == 0 && alignof(PointT) <= 16, "a PCL point is made of 16-byte quarters");
  static constexpr int kWords = static_cast<int>(sizeof(PointT) / 4);
  static constexpr bool has_color = point::has_color<PointT>;
  static constexpr bool shows_color = point::shows_color<PointT>;
  static constexpr bool has_camera_mask = point::has_camera_mask<PointT>;
  static constexpr bool has_view_count = point::has_view_count<PointT>;
  static constexpr bool has_normal = point::has_normal<PointT>;
  static constexpr bool has_confidence = point::has_confidence<PointT>;

  struct alignas(16) Words {
    std::uint32_t word[kWords];
  };

  Words blank;

  PointLayout() {
    const PointT point{};
    std::memcpy(&blank, static_cast<const void*>(&point), sizeof(blank));
  }

  /** \brief As the CPU's pipeline writes a point. \param cameras PointCameras::mask() */
  FUSE_FLOW_HD Words words(const FusedPoint& fused, std::uint64_t cameras, const Vec3& color, float intensity) const {
    Words w = blank;
    setPosition(w, fused.p);
    setConfidence(w, fused.weight);
    setViewCount(w, fused.views);
    setCameraMask(w, cameras);
    setColor(w, color);
    setIntensity(w, intensity);
    return w;
  }

  FUSE_FLOW_HD static Vec3 position(const Words& w) {
    return {get<pcl::fields::x, float>(w), get<pcl::fields::y, float>(w), get<pcl::fields::z, float>(w)};
  }
  FUSE_FLOW_HD static void setPosition(Words& w, const Vec3& p) {
    set<pcl::fields::x>(w, p.x);
    set<pcl::fields::y>(w, p.y);
    set<pcl::fields::z>(w, p.z);
  }

  /** \brief 1 where PointT has no confidence. */
  FUSE_FLOW_HD static float confidence(const Words& w) {
    if constexpr (has_confidence) {
      return get<pcl::fields::confidence, float>(w);
    } else {
      (void)w;
      return 1.0f;
    }
  }
  FUSE_FLOW_HD static void setConfidence(Words& w, float confidence) {
    if constexpr (has_confidence) set<pcl::fields::confidence>(w, confidence);
  }

  FUSE_FLOW_HD static void setIntensity(Words& w, float intensity) {
    if constexpr (point::has_intensity<PointT>) set<pcl::fields::intensity>(w, intensity);
  }
  /** \brief 0 where PointT has none. */
  FUSE_FLOW_HD static float intensity(const Words& w) {
    if constexpr (point::has_intensity<PointT>) {
      return get<pcl::fields::intensity, float>(w);
    } else {
      (void)w;
      return 0.0f;
    }
  }

  FUSE_FLOW_HD static void setViewCount(Words& w, std::uint32_t views) {
    if constexpr (point::has_view_count<PointT>) set<pcl::fields::view_count>(w, views);
  }

  FUSE_FLOW_HD static void setCameraMask(Words& w, std::uint64_t mask) {
    if constexpr (has_camera_mask) {
      set<pcl::fields::camera_mask>(w, static_cast<std::uint32_t>(mask));
      set<pcl::fields::camera_mask, 1>(w, static_cast<std::uint32_t>(mask >> 32));
    }
  }

  FUSE_FLOW_HD static Vec3 color(const Words& w) {
    std::uint32_t rgba = 0;
    if constexpr (has_color) rgba = get<point::ColorField<PointT>, std::uint32_t>(w);
    return {static_cast<float>(rgba >> 16 & 255u), static_cast<float>(rgba >> 8 & 255u),
            static_cast<float>(rgba & 255u)};
  }
  FUSE_FLOW_HD static void setColor(Words& w, const Vec3& color) {
    const std::uint32_t rgba = 0xff000000u | channel(color.x) << 16 | channel(color.y) << 8 | channel(color.z);
    if constexpr (has_color) set<point::ColorField<PointT>>(w, rgba);
  }

  FUSE_FLOW_HD static Vec3 normal(const Words& w) {
    if constexpr (has_normal)
      return {get<pcl::fields::normal_x, float>(w), get<pcl::fields::normal_y, float>(w),
              get<pcl::fields::normal_z, float>(w)};
    return {};
  }
  FUSE_FLOW_HD static void setNormal(Words& w, const Vec3& normal) {
    if constexpr (has_normal) {
      set<pcl::fields::normal_x>(w, normal.x);
      set<pcl::fields::normal_y>(w, normal.y);
      set<pcl::fields::normal_z>(w, normal.z);
    }
  }

 private:
  FUSE_FLOW_HD static std::uint32_t channel(float value) { return static_cast<std::uint32_t>(value + 0.5f); }

  template <typename Field, int kWord = 0, typename Value>
  FUSE_FLOW_HD static void set(Words& w, const Value& value) {
    static_assert(sizeof(Value) == 4 && pcl::traits::offset<PointT, Field>::value % 4 == 0, "fields are of words");
    std::memcpy(&w.word[pcl::traits::offset<PointT, Field>::value / 4 + kWord], &value, 4);
  }

  template <typename Field, typename Value>
  FUSE_FLOW_HD static Value get(const Words& w) {
    static_assert(sizeof(Value) == 4 && pcl::traits::offset<PointT, Field>::value % 4 == 0, "fields are of words");
    Value value;
    std::memcpy(&value, &w.word[pcl::traits::offset<PointT, Field>::value / 4], 4);
    return value;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
