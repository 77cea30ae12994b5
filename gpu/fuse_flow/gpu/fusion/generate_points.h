#pragma once

#include <fuse_flow/gpu/fusion/cell_table.h>
#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/box.h>
#include <fuse_flow/math/representatives.h>

namespace fuse_flow {
namespace gpu {

/** \brief How many measurements pass the gate, and the first point that is too far out. */
struct PointCounts {
  std::uint32_t gated;
  std::uint32_t too_far;
};

/** \brief Eq. 3, and what a measurement weighs by eq. 9 before its neighbours have their say. */
struct WeighMeasurement {
  PixelGrid grid;
  /** \brief As measured, for the confidence; and D^r of eq. 8. */
  const float* raw_z;
  const float* z;
  ConfidenceParameters confidence;
  /** \brief See FuseFlowParameters. */
  float half_weight_noise;
  float gate_noise;
  float max_noise;
  float min_confidence;
  bool use_confidence;

  FUSE_FLOW_HD float measurementConfidence(const DeviceView& view, int u, int v, std::uint32_t index) const {
    float C = 1.0f;
    if (use_confidence && confidence.form == ConfidenceForm::Given) {
      C = givenConfidence(view.confidence.row(v)[u]);
    } else if (use_confidence) {
      DepthPatch patch;
      readPatch({&view, raw_z}, u, v, index, 1, patch.z);
      C = confidence.form == ConfidenceForm::Published ? confidencePublished(confidence, patch)
                                                       : confidenceSlopeCompensated(confidence, patch, view.slope);
    }
    return C;
  }

  /** \brief Of a pixel with a measurement; 0: gated. */
  FUSE_FLOW_HD float weight(const DeviceView& view, int u, int v, std::uint32_t index) const {
    const MeasurementGate gate =
        measurementGate(use_confidence ? confidence.threshold : 0.0f, view.confidence ? 0.0f : gate_noise, max_noise,
                        half_weight_noise, view.noise);
    const float own = gate.weight(measurementConfidence(view, u, v, index), z[index]);
    if (!view.confidence) return own;
    const float given = givenWeight(view.confidence.row(v)[u], min_confidence);
    // Where it is C itself, it has been multiplied in.
    const bool is_weight = !use_confidence || confidence.form != ConfidenceForm::Given;
    return own * (is_weight ? given : (given > 0 ? 1.0f : 0.0f));
  }
};

/** \brief The weights of all pixels, for their neighbours. */
struct WeighMeasurements {
  WeighMeasurement measurement;
  float* weights;

  FUSE_FLOW_HD void weigh(const PixelAddress& a, std::uint32_t index) const {
    const DeviceView& view = measurement.grid.views[a.view];
    const bool there = a.u < view.model.intrinsics.width && measurement.z[index] > 0;
    weights[index] = there ? measurement.weight(view, a.u, a.v, index) : 0.0f;
  }
  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = measurement.grid.addressOf(index);
    if (measurement.grid.views[a.view].present) weigh(a, index);
  }
};

/** \brief Where points are put: into their coarse cells. */
struct CoarseCells {
  CellTableView table;

  FUSE_FLOW_HD std::uint64_t keyOf(const CellIndex& cell, std::uint32_t) const { return cellKey(cell); }
  /** \brief count points of one view, of which the first has number index. */
  FUSE_FLOW_HD void addPoints(std::uint32_t slot, std::uint32_t, std::uint32_t index, std::uint32_t count) const {
    table.addPoints(slot, index, count);
  }
};

/** \brief Eq. 3, 8, 9 and the place of every pixel. As a step of forEach() it works on one chunk of pixels; the CUDA
 *  kernel, one warp a chunk, gives the same. \tparam Places CoarseCells, or what else a table can count points by */
template <typename Places>
struct GeneratePoints {
  PixelGrid grid;
  WeighMeasurement measurement;
  /** \brief Of WeighMeasurements and KeepAgreed; null: neither was asked for. */
  const float* weights;
  int min_support;
  bool use_cells;
  float inverse_cell_size;
  Box crop_box;
  Places places;

  WeightedPoint* points;
  /** \brief Slot of each point's place in the table; kNone: no point. */
  std::uint32_t* slots;
  /** \brief Measurements of each view. */
  std::uint32_t* measured_of_view;
  PointCounts* counts;

  /** \brief Of a pixel with a measurement; 0: it becomes no point. */
  FUSE_FLOW_HD float weight(const DeviceView& view, int u, int v, std::uint32_t index) const {
    if (weights == nullptr) return measurement.weight(view, u, v, index);
    const float own = weights[index];
    if (!(own > 0)) return 0;
    DepthPatch around, depth;
    readPatch({&view, weights}, u, v, index, 1, around.z);
    readPatch({&view, measurement.z}, u, v, index, 1, depth.z);
    const int support = surfaceSupport(view.slope, view.noise.scale, depth, around);
    return support >= min_support ? own : 0.0f;
  }

  /** \brief Pixel u of a row; C = 0: no measurement or gated. */
  FUSE_FLOW_HD WeightedPoint measure(const DeviceView& view, int u, int v, bool& measured) const {
    measured = false;
    if (u >= view.model.intrinsics.width) return {};
    const std::uint32_t index = view.indexOf(u, v);
    const float depth = measurement.z[index];
    if (!(depth > 0)) return {};
    measured = true;
    const float own = weight(view, u, v, index);
    if (!(own > 0)) return {};
    const Vec3 p = view.model.T_world_camera * pointOnRay(view.ray(u, v), depth);  // eq. 8
    if (!crop_box.contains(p)) return {};
    return {p, own};
  }

  /** \brief Key of a point's place; kEmpty for none, and for a point too far out, whose number is reported. */
  FUSE_FLOW_HD std::uint64_t keyOf(const WeightedPoint& point, std::uint32_t view, std::uint32_t index) const {
    if (!(point.C > 0)) return CellTableView::kEmpty;
    const Vec3 cells = inverse_cell_size * point.p;
    if (fitsCellKey(cells)) return places.keyOf(cellIndex(cells), view);
    atomicMinTo(&counts->too_far, index);
    return CellTableView::kEmpty;
  }

  FUSE_FLOW_HD void operator()(std::uint32_t chunk) const {
    const std::uint32_t begin = chunk * kChunk;
    const PixelAddress a = grid.addressOf(begin);
    if (!grid.views[a.view].present) return;
    std::uint32_t measured_points = 0, gated_points = 0;
    std::uint64_t run_key = CellTableView::kEmpty;
    std::uint32_t run_begin = begin, run_slot = CellTableView::kNone;
    for (std::uint32_t index = begin; index < begin + kChunk; ++index) {
      bool measured = false;
      const WeightedPoint point = measure(grid.views[a.view], a.u + static_cast<int>(index - begin), a.v, measured);
      points[index] = point;
      measured_points += measured ? 1 : 0;
      gated_points += point.C > 0 ? 1 : 0;
      if (!use_cells) continue;
      const std::uint64_t key = keyOf(point, a.view, index);
      if (key != run_key) {
        if (run_key != CellTableView::kEmpty) places.addPoints(run_slot, a.view, run_begin, index - run_begin);
        run_key = key;
        run_begin = index;
        run_slot = key != CellTableView::kEmpty ? places.table.findOrAdd(key) : CellTableView::kNone;
      }
      slots[index] = run_slot;
    }
    if (run_key != CellTableView::kEmpty) places.addPoints(run_slot, a.view, run_begin, begin + kChunk - run_begin);
    if (measured_points > 0) atomicAddTo(measured_of_view + a.view, measured_points);
    if (gated_points > 0) atomicAddTo(&counts->gated, gated_points);
  }
};

}  // namespace gpu
}  // namespace fuse_flow
