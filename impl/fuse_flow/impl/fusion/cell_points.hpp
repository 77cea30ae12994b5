#pragma once

#include <fuse_flow/impl/fusion/cell_normals.hpp>
#include <fuse_flow/impl/fusion/coarse_grid.hpp>
#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/impl/sensors/depth_surface.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/math/cell.h>
#include <fuse_flow/math/representatives.h>
#include <fuse_flow/rig_frame.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief A coarse cell that is being split. */
struct CellSplit {
  Vec3 corner;
  int level;
  float to_child;  ///< childrenPerMetre()
};

/** \brief Some of the points of a coarse cell, from its corner, each with its child: arrays, which vector code fills. */
struct CellPoints {
  static constexpr std::size_t kLanes = 8;  ///< points are placed so many at a time: beyond the last there may be scrap
  static constexpr std::size_t kCapacity = 256;  ///< 5 KiB: stays in L1

  /** \brief Consecutive points of one camera. */
  struct Piece {
    std::uint32_t first;  ///< number of the first
    std::uint32_t count;
    std::uint32_t camera;
  };

  std::size_t pieces{0};
  std::size_t points{0};
  Piece piece[kCapacity];
  float x[kCapacity + kLanes], y[kCapacity + kLanes], z[kCapacity + kLanes];  ///< metres
  float C[kCapacity + kLanes];
  std::uint32_t position[kCapacity + kLanes];  ///< childPosition()

  /** \brief Where the next points go, of which so many are new. */
  std::size_t add(const Piece& more) {
    const std::size_t begin = points;
    piece[pieces++] = more;
    points += more.count;
    return begin;
  }
};

/** \brief Points in an array, as the filters have them. */
class PointArray {
 public:
  PointArray(const std::vector<WeightedPoint>& points, const std::vector<std::uint32_t>& cameras)
      : points_(&points), cameras_(&cameras) {}

  /** \brief Sends for the points of a run. The views are FramePoints'. */
  void prefetch(const CoarseGrid::Stretch& run, std::uint32_t&) const {
#if defined(__GNUC__)
    for (std::uint32_t ahead = 0; ahead < run.count; ahead += 4)
      __builtin_prefetch(points_->data() + run.begin + ahead);
#endif
  }

  /** \brief Where the surface faces is not known. */
  static constexpr bool kHasNormals = false;
  void addNormal(std::uint32_t, std::uint32_t, CellNormals&) const {}

  /** \brief Adds points of one run. \returns how many: no more than count */
  std::uint32_t read(const CellSplit& cell, std::uint32_t first, std::uint32_t count, std::uint32_t&,
                     CellPoints& out) const {
    const std::size_t begin = out.add({first, count, (*cameras_)[first]});
    for (std::size_t k = 0; k < count; ++k) {
      const WeightedPoint& point = (*points_)[first + k];
      const Vec3 relative = point.p - cell.corner;
      out.x[begin + k] = relative.x;
      out.y[begin + k] = relative.y;
      out.z[begin + k] = relative.z;
      out.C[begin + k] = point.C;
      out.position[begin + k] = childPosition(relative, cell.level, cell.to_child);
    }
    return count;
  }

 private:
  const std::vector<WeightedPoint>* points_;
  const std::vector<std::uint32_t>* cameras_;
};

/** \brief The points of a frame, numbered camera by camera, pixel by pixel. Only what they weigh is kept: where they are (eq. 8) takes
 *  less time to compute anew from the depth than to write and to read. */
class FramePoints {
 public:
  /** \brief Begins a frame. \param offsets number of each view's first point, and of all  \param depths D^r of each view
   *  \param noise of each view, which may be measured later  \param smoothing that makes D^r */
  void assign(const RigFrame& frame, const RigGeometry& rig, const std::vector<DepthMap>& depths,
              const std::vector<std::uint32_t>& offsets, const std::vector<ViewNoise>& noise,
              const SmoothingParameters& smoothing) {
    frame_ = &frame;
    rig_ = &rig;
    depths_ = &depths;
    offsets_ = &offsets;
    noise_ = &noise;
    smoothing_ = &smoothing;
    weights_.resize(offsets.back() + CellPoints::kLanes);
    view_of_block_.resize(blockOf(offsets.back()) + 1);
    std::uint32_t view = 0;
    for (std::uint32_t block = 0; block < view_of_block_.size(); ++block) {
      while (view + 2 < offsets.size() && offsets[view + 1] <= block << kBlockBits) ++view;
      view_of_block_[block] = view;
    }
  }

  std::uint32_t size() const { return offsets_->back(); }
  /** \brief C of eq. 9, to be filled in; 0: gated, or no measurement. */
  float* weights() { return weights_.data(); }
  const float* weights() const { return weights_.data(); }
  float C(std::uint32_t index) const { return weights_[index]; }
  /** \brief Eq. 8. */
  Vec3 position(std::uint32_t index) const {
    const Pixel pixel = locate(index);
    const ViewGeometry& view = (*rig_)[pixel.view];
    return view.T_world_camera * pointOnRay(view.ray(pixel.u, pixel.v), (*depths_)[pixel.view].row(pixel.v)[pixel.u]);
  }

  static constexpr bool kHasNormals = true;
  /** \brief Of the surface at a point that a view measured. */
  void addNormal(std::uint32_t index, std::uint32_t view, CellNormals& normals) const {
    const Pixel pixel = locate(index, view);
    normals.add((*rig_)[view], (*depths_)[view], pixel.u, pixel.v, normalSpacingOf(view));
  }
  /** \brief The same of a single one; see surfaceDirection(). */
  Vec3 normal(std::uint32_t index, std::uint32_t view) const {
    const Pixel pixel = locate(index, view);
    return surfaceDirection((*rig_)[view], DepthSurface{(*depths_)[view], (*rig_)[view]}, pixel.u, pixel.v,
                            normalSpacingOf(view));
  }

  /** \brief Where a point was measured. */
  struct Pixel {
    std::uint32_t view;
    int u, v;
  };
  Pixel locate(std::uint32_t index) const { return locate(index, viewOf(index)); }
  /** \brief The view that measured a point. Looked up, not searched for: the branches of a search would be anyone's guess. */
  std::uint32_t viewOf(std::uint32_t index) const {
    std::uint32_t view = view_of_block_[blockOf(index)];
    while ((*offsets_)[view + 1] <= index) ++view;
    return view;
  }

  /** \brief Sends for what there is of a run's points: what read() reads, and the colours of those that come to stand for a cell.
   *  \param view of the run before, or of any; becomes that of this one */
  void prefetch(const CoarseGrid::Stretch& run, std::uint32_t& view) const {
#if defined(__GNUC__)
    constexpr std::uint32_t line = 64;
    follow(run.begin, view);
    const Pixel pixel = locate(run.begin, view);
    const float* depth = (*depths_)[view].row(pixel.v) + pixel.u;
    constexpr std::uint32_t step = line / sizeof(float);
    for (std::uint32_t ahead = 0; ahead < run.count + step - 1; ahead += step) {
      __builtin_prefetch(weights_.data() + run.begin + ahead);
      __builtin_prefetch(depth + ahead);
    }
    const ImageView<Rgb8>& color = frame_->views[view].color;
    if (!color || (*rig_)[view].own_color_camera) return;
    const auto* first = reinterpret_cast<const char*>(color.row(pixel.v) + pixel.u);
    for (std::uint32_t ahead = 0; ahead < run.count * sizeof(Rgb8) + line - 1; ahead += line)
      __builtin_prefetch(first + ahead);
#endif
  }

  /** \brief Adds points of one run, which may go on in the next row of the image. \param view as for prefetch()
   *  \returns how many: no more than count */
  std::uint32_t read(const CellSplit& cell, std::uint32_t first, std::uint32_t count, std::uint32_t& view,
                     CellPoints& out) const {
    follow(first, view);
    const Pixel pixel = locate(first, view);
    const ViewGeometry& geometry = (*rig_)[view];
    const DepthMap& map = (*depths_)[view];
    count = std::min(count, static_cast<std::uint32_t>(map.width() - pixel.u));
    const std::size_t begin = out.add({first, count, view});
    const float* depth = map.row(pixel.v) + pixel.u;
    geometry.withRays(pixel.u, pixel.v, [&](const auto& ray) {
      placeAll(count, ray, geometry.T_world_camera, cell, depth, weights_.data() + first, out.x + begin, out.y + begin,
               out.z + begin, out.C + begin, out.position + begin);
    });
    return count;
  }

 private:
  template <typename RayOf>
  static void placeAll(std::size_t n, RayOf ray, RigidTransform T_world_camera, CellSplit cell,
                       const float* __restrict depth, const float* __restrict weight, float* __restrict x,
                       float* __restrict y, float* __restrict z, float* __restrict C,
                       std::uint32_t* __restrict position) {
    for (std::size_t begin = 0; begin < n; begin += CellPoints::kLanes)
      for (std::size_t k = begin; k < begin + CellPoints::kLanes; ++k) {
        const Vec3 p = T_world_camera * pointOnRay({ray.x(k), ray.y(k)}, depth[k]);
        const Vec3 relative = p - cell.corner;
        x[k] = relative.x;
        y[k] = relative.y;
        z[k] = relative.z;
        C[k] = weight[k];
        position[k] = childPosition(relative, cell.level, cell.to_child);
      }
  }

  int normalSpacingOf(std::uint32_t view) const { return normalSpacing(*smoothing_, (*noise_)[view].level()); }

  /** \brief Of a point whose view is known. */
  Pixel locate(std::uint32_t index, std::uint32_t view) const {
    const std::uint32_t local = index - (*offsets_)[view];
    const auto width = static_cast<std::uint32_t>((*depths_)[view].width());
    return {view, static_cast<int>(local % width), static_cast<int>(local / width)};
  }

  /** \brief The view of a point, from that of one before: nearly always the same. */
  void follow(std::uint32_t index, std::uint32_t& view) const {
    if (index < (*offsets_)[view]) view = 0;
    while ((*offsets_)[view + 1] <= index) ++view;
  }

  static constexpr int kBlockBits = 12;
  static std::uint32_t blockOf(std::uint32_t index) { return index >> kBlockBits; }

  const RigFrame* frame_{nullptr};
  const RigGeometry* rig_{nullptr};
  const std::vector<DepthMap>* depths_{nullptr};
  const std::vector<std::uint32_t>* offsets_{nullptr};
  const std::vector<ViewNoise>* noise_{nullptr};
  const SmoothingParameters* smoothing_{nullptr};
  std::vector<float> weights_;
  std::vector<std::uint32_t> view_of_block_;  ///< of the first point of each block
};

}  // namespace host
}  // namespace fuse_flow
