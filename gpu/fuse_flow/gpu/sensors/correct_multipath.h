#pragma once

#include <fuse_flow/gpu/sensors/frame_views.h>
#include <fuse_flow/math/multipath.h>

namespace fuse_flow {
namespace gpu {

static_assert(kTilePixels == kChunk && kTilePixels == kTileHeight, "a tile of pixels is a tile of patches");

/** \brief Where a patch is: patches are numbered tile by tile. */
struct PatchAddress {
  std::uint32_t view;
  std::uint32_t first_tile, tile_count;  ///< of the view
  int u, v;                              ///< its first pixel
};

FUSE_FLOW_HD PatchAddress patchAddress(const TileGrid& tiles, std::uint32_t patch) {
  const std::uint32_t tile = patch / kTilePatches, view = tiles.viewOf(tile), first = tiles.offsets[view];
  const std::uint32_t across = tiles.pixels.views[view].pitch / kChunk;
  const std::uint32_t row = (tile - first) / across;
  const int place = static_cast<int>(patch % kTilePatches);
  return {view, first, tiles.offsets[view + 1] - first,
          static_cast<int>(tile - first - row * across) * kTilePixels + place % kPatchesAcrossTile * kPatchPixels,
          static_cast<int>(row) * kTilePixels + place / kPatchesAcrossTile * kPatchPixels};
}

/** \brief Whether a view's depth is to be corrected. */
FUSE_FLOW_HD bool hasMultipath(const DeviceView& view) { return view.model.multipath.modulation_frequency > 0; }

/** \brief The surface that each block of pixels sees. */
struct MakePatches {
  TileGrid tiles;
  const float* z;
  SurfacePatch* patches;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const PatchAddress a = patchAddress(tiles, k);
    const DeviceView& view = tiles.pixels.views[a.view];
    if (!hasMultipath(view)) return;
    patches[k] =
        makeSurfacePatch(DepthMapOfView{&view, z}, view.model.intrinsics, a.u, a.v, view.model.multipath.reflectance);
  }
};

/** \brief The patches of each tile as one. */
struct MergePatches {
  TileGrid tiles;
  const SurfacePatch* patches;
  SurfacePatch* merged;

  FUSE_FLOW_HD void operator()(std::uint32_t tile) const {
    if (hasMultipath(tiles.pixels.views[tiles.viewOf(tile)]))
      merged[tile] = mergeSurfacePatches(patches + static_cast<std::size_t>(tile) * kTilePatches);
  }
};

/** \brief A lane of the light that comes to each patch: kIndirectLanes threads a patch, since there are few patches. */
struct SumIndirectLight {
  TileGrid tiles;
  const SurfacePatch* patches;
  const SurfacePatch* merged;
  IndirectLight* lanes;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const PatchAddress a = patchAddress(tiles, k / kIndirectLanes);
    const DeviceView& view = tiles.pixels.views[a.view];
    if (!hasMultipath(view)) return;
    const SurfacePatch patch = patches[k / kIndirectLanes];
    if (!(patch.power > 0)) return;
    const float period = multipathPeriod(view.model.multipath.modulation_frequency);
    lanes[k] = sumIndirectOfLane(IndirectReceiver(patch, period), merged + a.first_tile,
                                 patches + static_cast<std::size_t>(a.first_tile) * kTilePatches, a.tile_count,
                                 k % kIndirectLanes);
  }
};

/** \brief By how much each patch is late. */
struct FindLate {
  TileGrid tiles;
  const SurfacePatch* patches;
  const IndirectLight* lanes;
  LatePatch* late;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const DeviceView& view = tiles.pixels.views[tiles.viewOf(k / kTilePatches)];
    if (!hasMultipath(view)) return;
    const SurfacePatch patch = patches[k];
    late[k] = LatePatch{};
    if (!(patch.power > 0)) return;  // such a patch has no lanes
    const IndirectLight light = sumLanes(lanes + static_cast<std::size_t>(k) * kIndirectLanes);
    const float period = multipathPeriod(view.model.multipath.modulation_frequency);
    late[k] = LatePatch(patch, multipathBias(light, period, patch));
  }
};

/** \brief Takes the multipath bias from each pixel's depth. */
struct CorrectMultipath {
  TileGrid tiles;
  const LatePatch* late;
  float* z;
  float* q;  // 1/z as well, unless null

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = tiles.pixels.addressOf(index);
    const DeviceView& view = tiles.pixels.views[a.view];
    if (!view.present) return;
    float value = z[index];
    if (hasMultipath(view) && value > 0) {
      value = corrected(view, tiles.offsets[a.view], a, value);
      z[index] = value;
    }
    if (q != nullptr) q[index] = value > 0 ? 1.0f / value : 0.0f;
  }

 private:
  FUSE_FLOW_HD float corrected(const DeviceView& view, std::uint32_t first_tile, const PixelAddress& a,
                               float value) const {
    const int tiles_across = static_cast<int>(view.pitch / kChunk);
    const int tiles_down = (view.model.intrinsics.height + kTilePixels - 1) / kTilePixels;
    const PatchPlace column(a.u, tiles_across * kPatchesAcrossTile), row(a.v, tiles_down * kPatchesAcrossTile);
    const auto at = [&](int x, int y) -> const LatePatch& {
      const int tile = y / kPatchesAcrossTile * tiles_across + x / kPatchesAcrossTile;
      const int place = y % kPatchesAcrossTile * kPatchesAcrossTile + x % kPatchesAcrossTile;
      return late[(static_cast<std::size_t>(first_tile) + static_cast<std::size_t>(tile)) * kTilePatches +
                  static_cast<std::size_t>(place)];
    };
    return withoutMultipath(at(column.first, row.first), at(column.first + 1, row.first),
                            at(column.first, row.first + 1), at(column.first + 1, row.first + 1), column.share,
                            row.share, view.ray(a.u, a.v), value);
  }
};

/** \brief host::MultipathCorrection's counterpart, of all views of a frame. */
class MultipathCorrection {
 public:
  /** \param z depth of all pixels, metres; is corrected  \param q is given 1/z as well, unless null */
  void correct(Execution& run, const FrameViews& views, float* z, float* q) {
    const TileGrid tiles = views.tiles();
    const std::size_t patches = static_cast<std::size_t>(tiles.count) * kTilePatches;
    patches_.resize(patches);
    late_.resize(patches);
    lanes_.resize(patches * kIndirectLanes);
    merged_.resize(tiles.count);
    run.forEach(patches, MakePatches{tiles, z, patches_.data()});
    run.forEach(tiles.count, MergePatches{tiles, patches_.data(), merged_.data()});
    run.forEach(patches * kIndirectLanes, SumIndirectLight{tiles, patches_.data(), merged_.data(), lanes_.data()});
    run.forEach(patches, FindLate{tiles, patches_.data(), lanes_.data(), late_.data()});
    run.forEach(views.pixels(), CorrectMultipath{tiles, late_.data(), z, q});
  }

  std::size_t bytes() const { return patches_.bytes() + merged_.bytes() + lanes_.bytes() + late_.bytes(); }

 private:
  DeviceBuffer<SurfacePatch> patches_, merged_;
  DeviceBuffer<IndirectLight> lanes_;
  DeviceBuffer<LatePatch> late_;
};

}  // namespace gpu
}  // namespace fuse_flow
