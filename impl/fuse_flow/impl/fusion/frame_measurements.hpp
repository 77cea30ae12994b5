#pragma once

#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/impl/fusion/cell_points.hpp>
#include <fuse_flow/impl/fusion/frame_depths.hpp>
#include <fuse_flow/impl/fusion/point_row.hpp>
#include <fuse_flow/impl/fusion/view_agreement.hpp>
#include <fuse_flow/impl/fusion/weight_rows.hpp>

#include <algorithm>
#include <vector>

namespace fuse_flow {
namespace detail {

/** \brief For the per-pixel maths. */
inline Box cropBox(const FuseFlowParameters& parameters) {
  if (!parameters.crop_box) return {};
  const Eigen::Vector3f &low = parameters.crop_box->min(), &high = parameters.crop_box->max();
  return {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}};
}

/** \brief Whether measurements need others around them. */
inline bool asksForSupport(const FuseFlowParameters& parameters) {
  return parameters.use_measurement_confidence && parameters.min_support > 0;
}

/** \brief Whether measurements need other views that measure the same. */
inline bool asksForAgreement(const FuseFlowParameters& parameters) { return parameters.agreement.min_views > 0; }

/** \brief FuseFlowParameters::half_weight_noise, or 0 where all measurements weigh the same. */
inline float halfWeightNoise(const FuseFlowParameters& parameters) {
  return parameters.use_measurement_confidence ? parameters.half_weight_noise : 0.0f;
}

/** \brief FuseFlowParameters::max_noise, or 0 where every measurement counts. */
inline float maxNoise(const FuseFlowParameters& parameters) {
  return parameters.use_measurement_confidence ? parameters.max_noise : 0.0f;
}

/** \brief C that eq. 9 asks for. */
inline float gateThreshold(const FuseFlowParameters& parameters) {
  return parameters.use_measurement_confidence ? parameters.confidence.threshold : 0.0f;
}

/** \brief Whether C of eq. 3 is what the views say, instead of what is measured in their depth. */
inline bool takesGivenConfidence(const FuseFlowParameters& parameters) {
  return parameters.use_measurement_confidence && parameters.confidence.form == ConfidenceForm::Given;
}

/** \brief Throws where ConfidenceForm::Given has nothing to take. */
inline void checkGivenConfidence(const FuseFlowParameters& parameters, const RigFrame& frame) {
  if (!takesGivenConfidence(parameters)) return;
  for (std::size_t i = 0; i < frame.views.size(); ++i)
    if (!frame.views[i].missing() && !frame.views[i].confidence)
      throwBadArgument(Owner{"fuse_flow::FuseFlow: camera '", frame.cameras[i].name, "'"},
                       " gives no confidence, which ConfidenceForm::Given takes for C; set DepthView::confidence");
}

/** \brief Throws where a rig has too few cameras for any measurement to pass. */
inline void checkAgreement(const FuseFlowParameters& parameters, const RigFrame& frame) {
  const auto others = frame.cameras.empty() ? std::size_t{0} : frame.cameras.size() - 1;
  if (static_cast<std::size_t>(parameters.agreement.min_views) <= others) return;
  throwBadArgument("fuse_flow::FuseFlow: agreement.min_views is ", parameters.agreement.min_views,
                   ", but beside each camera the rig has ", others,
                   " other(s), so that every measurement would be dropped; must be at most that");
}

}  // namespace detail

namespace host {

/** \brief From depth to weighted points in coarse cells, row by row: confidence (eq. 3), gate (eq. 9), agreement of other views, back-projection (eq. 8), partition
 *  (section 5 (1)), with the memory that it keeps. */
class FrameMeasurements {
 public:
  /** \brief How many pixels of a stretch have a measurement, and become points. */
  struct Counts {
    std::size_t measured{0};
    std::size_t gated{0};
  };

  /** \brief Begins a frame, which must stay alive. \param points what they weigh is written here */
  void start(const RigFrame& frame, const RigGeometry& rig, const FuseFlowParameters& parameters,
             const FrameDepths& depths, FramePoints& points, int threads) {
    frame_ = &frame;
    rig_ = &rig;
    parameters_ = &parameters;
    depths_ = &depths;
    points_ = &points;
    crop_box_ = detail::cropBox(parameters);
    if (rows_.size() < static_cast<std::size_t>(threads)) {
      rows_.resize(static_cast<std::size_t>(threads));
      weight_rows_.resize(static_cast<std::size_t>(threads));
    }
    std::size_t width = 0;
    for (const DepthMap& depth : depths.measured()) width = std::max(width, static_cast<std::size_t>(depth.width()));
    for (PointRow& row : rows_) row.reserve(width);
    for (WeightRows& rows : weight_rows_) rows.reserve(width);
  }

  const Box& cropBox() const { return crop_box_; }

  /** \brief The points of some rows of a view, and the coarse cells that they fall into. */
  Counts measure(const FrameTasks::Stretch& stretch, std::size_t thread, RunBuilder& cells) {
    Counts counts;  // on this thread's stack: neighbours in an array would fight for one cache line
    if (detail::asksForSupport(*parameters_)) {
      measureWithSupport(stretch, thread, cells, counts);
      return counts;
    }
    for (int v = stretch.begin_row; v < stretch.end_row; ++v) {
      const Row row{stretch.view, v, weightsOf(stretch.view, v)};
      confidence(row);
      counts.measured += gate(row);
      agreement(row);
      counts.gated += backProject(row, rows_[thread]);
      partition(row, rows_[thread], cells);
    }
    return counts;
  }

  /** \brief Points whose weights are known already, of n pixels of a row from pixel u on, and the coarse cells that they fall into. */
  void takeUp(std::uint32_t view, int v, int u, int n, std::size_t thread, RunBuilder& cells) {
    const std::uint32_t first = firstOf(view, v) + static_cast<std::uint32_t>(u);
    PointRow& row = rows_[thread];
    row.reserve(static_cast<std::size_t>(n));
    row.place((*rig_)[view], u, v, crop_box_, parameters_->aggregation.cell_size, depths_->refined(view).row(v) + u, n,
              points_->weights() + first);
    row.addTo(cells, first);
  }

 private:
  /** \brief One row of a view's pixels: first C of eq. 3, then what passes the gate weighs. */
  struct Row {
    std::uint32_t view;
    int v;
    float* weights;
  };

  /** \brief The same where a measurement needs neighbours that continue its surface: three rows are weighed, and then the middle one is
   *  looked at. The rows beside the stretch are weighed twice, here and there. */
  void measureWithSupport(const FrameTasks::Stretch& stretch, std::size_t thread, RunBuilder& cells, Counts& counts) {
    const std::uint32_t i = stretch.view;
    const int height = depths_->measured(i).height();
    const SlopeScale slope = slopeScale(parameters_->confidence, 1.0f / (*rig_)[i].intrinsics.fx, depths_->noise(i));
    WeightRows& around = weight_rows_[thread];
    around.start(depths_->measured(i).width());
    for (int v = stretch.begin_row - 1; v <= stretch.end_row; ++v) {
      if (v < 0 || v >= height) {
        around.clear(v);
      } else {
        const Row next{i, v, around.row(v)};
        confidence(next);
        const std::size_t measured = gate(next);
        agreement(next);
        if (v >= stretch.begin_row && v < stretch.end_row) counts.measured += measured;
      }
      if (v <= stretch.begin_row) continue;
      const Row row{i, v - 1, weightsOf(i, v - 1)};
      around.keepSupported(slope, depths_->noise(i).scale, parameters_->min_support, depths_->refined(i), v - 1,
                           row.weights);
      counts.gated += backProject(row, rows_[thread]);
      partition(row, rows_[thread], cells);
    }
  }

  /** \brief Eq. 3: C of each measurement. */
  void confidence(const Row& row) const {
    const DepthMap& depth = depths_->measured(row.view);
    if (detail::takesGivenConfidence(*parameters_)) {
      const float* given = frame_->views[row.view].confidence.row(row.v);
      for (int u = 0; u < depth.width(); ++u) row.weights[u] = givenConfidence(given[u]);
    } else if (parameters_->use_measurement_confidence) {
      confidenceRow(parameters_->confidence, depth, 1.0f / (*rig_)[row.view].intrinsics.fx, depths_->noise(row.view),
                    row.v, row.weights);
    } else {
      std::fill(row.weights, row.weights + depth.width(), 1.0f);
    }
  }

  /** \brief Eq. 9: what is too doubtful, or too noisy, weighs nothing. \returns how many measurements there are */
  std::size_t gate(const Row& row) const {
    const ImageView<float>& given = frame_->views[row.view].confidence;
    const MeasurementGate gate = measurementGate(detail::gateThreshold(*parameters_),
                                                 given ? 0.0f : parameters_->gate_noise, detail::maxNoise(*parameters_),
                                                 detail::halfWeightNoise(*parameters_), depths_->noise(row.view));
    const int width = depths_->measured(row.view).width();
    const std::size_t measured = PointRow::weigh(gate, depths_->refined(row.view).row(row.v), width, row.weights);
    if (!given) return measured;
    // Where it is C itself, it has been multiplied in.
    const bool is_weight = !detail::takesGivenConfidence(*parameters_);
    for (int u = 0; u < width; ++u) {
      const float weight = givenWeight(given.row(row.v)[u], parameters_->min_confidence);
      row.weights[u] *= is_weight ? weight : (weight > 0 ? 1.0f : 0.0f);
    }
    return measured;
  }

  /** \brief What too few other views measure, too, weighs nothing. */
  void agreement(const Row& row) const {
    if (!detail::asksForAgreement(*parameters_)) return;
    keepAgreed(parameters_->agreement, *rig_, depths_->refined(), frame_->views, row.view, row.v, row.weights);
  }

  /** \brief Eq. 8: where the measurements lie in the world. \returns how many become points */
  std::size_t backProject(const Row& row, PointRow& points) const {
    return points.place((*rig_)[row.view], 0, row.v, crop_box_, parameters_->aggregation.cell_size,
                        depths_->refined(row.view).row(row.v), depths_->measured(row.view).width(), row.weights);
  }

  /** \brief Section 5 (1): into which coarse cell each point falls. */
  void partition(const Row& row, PointRow& points, RunBuilder& cells) const {
    if (parameters_->use_spatial_hash) points.addTo(cells, firstOf(row.view, row.v));
  }

  std::uint32_t firstOf(std::uint32_t i, int v) const {
    return depths_->offsets()[i] +
           static_cast<std::uint32_t>(v) * static_cast<std::uint32_t>(depths_->measured(i).width());
  }
  float* weightsOf(std::uint32_t i, int v) const { return points_->weights() + firstOf(i, v); }

  const RigFrame* frame_{nullptr};
  const RigGeometry* rig_{nullptr};
  const FuseFlowParameters* parameters_{nullptr};
  const FrameDepths* depths_{nullptr};
  FramePoints* points_{nullptr};
  Box crop_box_;
  std::vector<PointRow> rows_;  ///< thread by thread
  std::vector<WeightRows> weight_rows_;
};

}  // namespace host
}  // namespace fuse_flow
