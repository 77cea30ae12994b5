#pragma once

#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/impl/sensors/depth_surface.hpp>
#include <fuse_flow/math/multipath.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Patches number by number, for vector code. */
class PatchColumns {
 public:
  static constexpr std::size_t kLanes = kIndirectLanes;

  /** \brief Room for whole vectors; what is not set() sends nothing, and counts as far away. */
  void resize(std::size_t count) {
    count = (count + kLanes - 1) / kLanes * kLanes;
    for (std::vector<float>* column : {&x_, &y_, &nx_, &ny_, &nz_, &power_, &distance_}) column->assign(count, 0.0f);
    z_.assign(count, -1e3f);
    area_.assign(count, 1e-6f);
  }
  void set(std::size_t k, const SurfacePatch& patch) {
    x_[k] = patch.p.x;
    y_[k] = patch.p.y;
    z_[k] = patch.p.z;
    nx_[k] = patch.n.x;
    ny_[k] = patch.n.y;
    nz_[k] = patch.n.z;
    power_[k] = patch.power;
    area_[k] = patch.area;
    distance_[k] = patch.distance;
  }
  std::size_t size() const { return x_.size(); }

  /** \brief Where the columns are: what a loop holds by value. */
  struct View {
    const float* __restrict x;
    const float* __restrict y;
    const float* __restrict z;
    const float* __restrict nx;
    const float* __restrict ny;
    const float* __restrict nz;
    const float* __restrict power;
    const float* __restrict area;
    const float* __restrict distance;

    IndirectLight light(const IndirectReceiver& receiver, std::size_t k) const {
      return receiver.from({x[k], y[k], z[k]}, {nx[k], ny[k], nz[k]}, power[k], area[k], distance[k]);
    }
    bool far(const Vec3& p, std::size_t k) const { return farFrom({x[k], y[k], z[k]}, area[k], p); }
  };
  View view() const {
    return {x_.data(),  y_.data(),     z_.data(),    nx_.data(),      ny_.data(),
            nz_.data(), power_.data(), area_.data(), distance_.data()};
  }

 private:
  std::vector<float> x_, y_, z_, nx_, ny_, nz_, power_, area_, distance_;
};

/** \brief Takes from a view's depth what multipath interference has added (math/multipath.h). Once warm it allocates nothing. */
class MultipathCorrection {
 public:
  static bool wantedBy(const ViewModel& view) { return view.multipath.modulation_frequency > 0; }

  /** \param depth of the view, metres; is corrected  */
  void correct(const ViewGeometry& view, DepthMap& depth) {
    tiles_across_ = (depth.width() + kTilePixels - 1) / kTilePixels;
    tiles_down_ = (depth.height() + kTilePixels - 1) / kTilePixels;
    findPatches(view, depth);
    findLate(multipathPeriod(view.multipath.modulation_frequency));
    for (int v = 0; v < depth.height(); ++v) correctRow(view, v, depth.width(), depth.row(v));
  }

 private:
  int across() const { return kPatchesAcrossTile * tiles_across_; }
  int down() const { return kPatchesAcrossTile * tiles_down_; }

  void findPatches(const ViewGeometry& view, const DepthMap& depth) {
    const std::size_t tiles = static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(tiles_down_);
    patches_.resize(tiles * kTilePatches);
    patch_columns_.resize(patches_.size());
    tile_columns_.resize(tiles);
    near_.resize(tile_columns_.size());
    for (std::size_t tile = 0; tile < tiles; ++tile) {
      const int u = static_cast<int>(tile) % tiles_across_ * kTilePixels;
      const int v = static_cast<int>(tile) / tiles_across_ * kTilePixels;
      SurfacePatch* patches = patches_.data() + tile * kTilePatches;
      for (int k = 0; k < kTilePatches; ++k) {
        patches[k] =
            makeSurfacePatch(DepthSurface{depth, view}, view.intrinsics, u + k % kPatchesAcrossTile * kPatchPixels,
                             v + k / kPatchesAcrossTile * kPatchPixels, view.multipath.reflectance);
        patch_columns_.set(tile * kTilePatches + static_cast<std::size_t>(k), patches[k]);
      }
      tile_columns_.set(tile, mergeSurfacePatches(patches));
    }
  }

  void findLate(float period) {
    late_.assign(static_cast<std::size_t>(across()) * static_cast<std::size_t>(down()), LatePatch{});
    for (std::size_t k = 0; k < patches_.size(); ++k) {
      const SurfacePatch& patch = patches_[k];
      if (!(patch.power > 0)) continue;
      const auto tile = static_cast<int>(k / kTilePatches), place = static_cast<int>(k % kTilePatches);
      const int a = tile % tiles_across_ * kPatchesAcrossTile + place % kPatchesAcrossTile;
      const int b = tile / tiles_across_ * kPatchesAcrossTile + place / kPatchesAcrossTile;
      late_[static_cast<std::size_t>(b * across() + a)] = {
          patch, multipathBias(sum(IndirectReceiver(patch, period)), period, patch)};
    }
  }

  /** \brief The lanes of sumIndirectOfLane() at once, in vector code, and their sum. */
  IndirectLight sum(const IndirectReceiver& receiver) {
    constexpr std::size_t kLanes = PatchColumns::kLanes;
    IndirectLight lanes[kLanes];
    const PatchColumns::View all_tiles = tile_columns_.view(), all_patches = patch_columns_.view();
    float* const of_near = near_.data();
    const std::size_t count = near_.size();
    inWideVectors([&, of_near, count] {
      const IndirectReceiver x = receiver;  // copies: the compiler then knows that nothing overwrites them
      const PatchColumns::View tiles = all_tiles, patches = all_patches;
      float* __restrict near = of_near;
      float real[kLanes] = {}, imaginary[kLanes] = {};
      for (std::size_t first = 0; first < count; first += kLanes)
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
          const std::size_t k = first + lane;
          const float far = tiles.far(x.p, k) ? 1.0f : 0.0f;
          const IndirectLight light = tiles.light(x, k);
          real[lane] += far * light.in_phase;
          imaginary[lane] += far * light.behind;
          near[k] = 1 - far;
        }
      for (std::size_t tile = 0; tile < count; ++tile) {
        if (near[tile] == 0) continue;
        for (std::size_t first = tile * kTilePatches; first < (tile + 1) * kTilePatches; first += kLanes)
          for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const IndirectLight light = patches.light(x, first + lane);
            real[lane] += light.in_phase;
            imaginary[lane] += light.behind;
          }
      }
      for (std::size_t lane = 0; lane < kLanes; ++lane) lanes[lane] = {real[lane], imaginary[lane]};
    });
    return sumLanes(lanes);
  }

  void correctRow(const ViewGeometry& view, int v, int width, float* z) const {
    const PatchPlace rows(v, down());
    const int columns = across();
    const LatePatch* above = late_.data() + static_cast<std::ptrdiff_t>(rows.first) * across();
    const LatePatch* below = above + across();
    view.withRays(0, v, [&](const auto& rays_of_row) {
      inWideVectors([=] {
        const auto rays = rays_of_row;
        float* __restrict corrected = z;
        for (int u = 0; u < width;) {
          const int first = PatchPlace(u, columns).first;
          const int end = first == columns - 2 ? width : std::min(width, kPatchPixels * (first + 1) + kPatchPixels / 2);
          const LatePatch p00 = above[first], p10 = above[first + 1], p01 = below[first], p11 = below[first + 1];
          for (; u < end; ++u) {
            const auto k = static_cast<std::size_t>(u);
            corrected[u] = withoutMultipath(p00, p10, p01, p11, PatchPlace::shareOfNext(u, first), rows.share,
                                            {rays.x(k), rays.y(k)}, corrected[u]);
          }
        }
      });
    });
  }

  int tiles_across_{0}, tiles_down_{0};
  std::vector<SurfacePatch> patches_;  ///< tile by tile
  PatchColumns patch_columns_, tile_columns_;
  std::vector<float> near_;      ///< 1 for the tiles whose patches count one by one, else 0
  std::vector<LatePatch> late_;  ///< row by row
};

}  // namespace host
}  // namespace fuse_flow
