#include "viewer/parameter_sliders.h"

#include "viewer/slider_look.h"

#include <algorithm>

namespace fuse_flow::viewing {
namespace {

constexpr double kSliderLength = 200, kSliderDistance = 76;  // pixels

}  // namespace

const std::vector<SliderParameter>& sliderParameters() {
  static const std::vector<SliderParameter> parameters{
      {"tau", 0, 1, 1, [](FuseFlowParameters& p) -> float& { return p.confidence.threshold; }},
      {"sigma, mm", 1, 100, 0.001, [](FuseFlowParameters& p) -> float& { return p.consistency.sigma; }},
      {"cell size, mm", 8, 256, 0.001, [](FuseFlowParameters& p) -> float& { return p.aggregation.cell_size; }},
      {"smallest cell, mm", 2, 64, 0.001, [](FuseFlowParameters& p) -> float& { return p.aggregation.min_cell_size; }},
      {"smallest weight", 0, 0.5, 1, [](FuseFlowParameters& p) -> float& { return p.aggregation.min_weight; }}};
  return parameters;
}

ParameterSliders::ParameterSliders(Window& window, OnChange on_change)
    : window_(window), on_change_(std::move(on_change)) {
  for (const SliderParameter& parameter : sliderParameters()) {
    representations_.push_back(makeSlider(parameter.title, parameter.low, parameter.high));
    widgets_.push_back(vtkSmartPointer<vtkSliderWidget>::New());
    widgets_.back()->SetInteractor(window.interactor());
    widgets_.back()->SetCurrentRenderer(window.overlay());
    widgets_.back()->SetRepresentation(representations_.back());
    widgets_.back()->SetAnimationModeToJump();
    widgets_.back()->KeyPressActivationOff();  // i is ours
    widgets_.back()->AddObserver(vtkCommand::InteractionEvent, this, &ParameterSliders::moved);
  }
  arrange();
}

ParameterSliders::~ParameterSliders() { setVisible(false); }

void ParameterSliders::moved(vtkObject* widget, unsigned long, void*) {
  const auto at = std::find(widgets_.begin(), widgets_.end(), widget);
  const auto k = static_cast<std::size_t>(at - widgets_.begin());
  const SliderParameter& parameter = sliderParameters()[k];
  on_change_(parameter, static_cast<float>(parameter.scale * representations_[k]->GetValue()));
}

void ParameterSliders::setVisible(bool visible) {
  visible_ = visible;
  for (const auto& widget : widgets_) {
    if (visible) widget->SetCurrentRenderer(window_.overlay());  // else it takes the one under the cursor
    widget->SetEnabled(visible);
  }
}

void ParameterSliders::setValues(const FuseFlowParameters& parameters) {
  FuseFlowParameters copy = parameters;
  for (std::size_t k = 0; k < representations_.size(); ++k) {
    const SliderParameter& parameter = sliderParameters()[k];
    representations_[k]->SetValue(static_cast<double>(parameter.member(copy)) / parameter.scale);
  }
}

void ParameterSliders::arrange() {
  const double height = window_.height(), right = window_.width() - kSliderMargin;
  const double left = std::max(kSliderMargin, right - kSliderLength);
  const double count = static_cast<double>(representations_.size());
  const double distance = std::min(kSliderDistance, (height - kSliderMargin) / count);
  for (std::size_t k = 0; k < representations_.size(); ++k) {
    const double y = height - distance * (static_cast<double>(k) + 0.6);
    placeSlider(representations_[k], window_, left, right, y);
  }
}

}  // namespace fuse_flow::viewing
