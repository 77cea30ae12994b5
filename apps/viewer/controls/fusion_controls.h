#pragma once

#include "viewer/fusing/fusion_job.h"

#include <functional>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief The three components of the paper's ablation. */
enum class Component { MeasurementConfidence, DistanceConsistency, SpatialHash };
bool uses(const FuseFlowParameters& parameters, Component component);

/** \brief In place of a method: clouds that come fused. */
constexpr const char* kStreamed = "streamed";

/** \brief What is fused how, as the keys and sliders change it. */
class FusionControls {
 public:
  /** \brief \param method of the left view, as io::makeMethod() names it  \param options where it starts */
  FusionControls(const std::string& method, const io::MethodOptions& options);

  /** \brief For the left view. */
  FusionSettingPtr fused() const { return fused_; }
  /** \brief For the right view; null: no comparison. */
  FusionSettingPtr comparison() const { return comparison_; }
  const FuseFlowParameters& parameters() const { return options_.parameters; }

  /** \brief Switches a component off or on. */
  void toggle(Component component);
  /** \brief Applies a change to the parameters of the left view; the other one keeps what it has, but for the crop box. */
  void change(const std::function<void(FuseFlowParameters&)>& apply);
  /** \brief Back to where it started, but for the crop box. */
  void reset();

  /** \brief What the left view can be compared with: "none", "concatenate", …, "published", "kept". */
  static const std::vector<std::string>& comparisonNames();
  void compareWith(const std::string& name);
  const std::string& comparedWith() const { return compared_with_; }
  /** \brief The next name, "none" after the last. */
  void compareWithNext();
  /** \brief Compares the left view with its current setting, which is kept when the left view changes. */
  void keep();

 private:
  void update();
  void updateComparison();

  std::string method_;
  io::MethodOptions options_;
  io::MethodOptions initial_;
  io::MethodOptions kept_;
  std::string compared_with_{"none"};
  FusionSettingPtr fused_;
  FusionSettingPtr comparison_;
};

}  // namespace fuse_flow::viewing
