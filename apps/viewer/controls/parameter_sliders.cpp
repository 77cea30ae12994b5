#include "viewer/controls/parameter_sliders.h"

#include "viewer/controls/slider_look.h"

#include <vtkTextProperty.h>

#include <algorithm>
#include <cstdio>

namespace fuse_flow::viewing {
namespace {

constexpr double kSliderLength = 200, kSliderDistance = 48, kCaption = 15;  // pixels

}  // namespace

const std::vector<SliderParameter>& sliderParameters() {
  static const std::vector<SliderParameter> parameters{
      {"tau", 0, 1, 1, [](FuseFlowParameters& p) -> float& { return p.confidence.threshold; }},
      {"sigma, mm", 1, 100, 0.001, [](FuseFlowParameters& p) -> float& { return p.consistency.sigma; }},
      {"cell size, mm", 8, 256, 0.001, [](FuseFlowParameters& p) -> float& { return p.aggregation.cell_size; }},
      {"smallest cell, mm", 2, 64, 0.001, [](FuseFlowParameters& p) -> float& { return p.aggregation.min_cell_size; }},
      {"smallest weight", 0, 0.05, 1, [](FuseFlowParameters& p) -> float& { return p.aggregation.min_weight; }}};
  return parameters;
}

void setParameter(const SliderParameter& parameter, float value, FuseFlowParameters& parameters) {
  AggregationParameters& cells = parameters.aggregation;
  const float size = cells.cell_size;
  parameter.member(parameters) = value;
  if (cells.min_cell_size <= cells.cell_size) return;
  const bool size_moved = cells.cell_size < size;
  (size_moved ? cells.min_cell_size : cells.cell_size) = value;
}

ParameterSliders::ParameterSliders(Window& window, OnChange on_change)
    : window_(window), on_change_(std::move(on_change)) {
  for (const SliderParameter& parameter : sliderParameters()) {
    representations_.push_back(makeSlider(parameter.low, parameter.high));
    representations_.back()->ShowSliderLabelOff();
    captions_.push_back(vtkSmartPointer<vtkTextActor>::New());
    vtkTextProperty* text = captions_.back()->GetTextProperty();
    text->ShallowCopy(representations_.back()->GetLabelProperty());
    text->SetFontSize(kCaption - 2);
    text->SetJustificationToLeft();
    text->SetVerticalJustificationToBottom();
    captions_.back()->PickableOff();
    captions_.back()->VisibilityOff();
    window.overlay()->AddActor2D(captions_.back());
    widgets_.push_back(vtkSmartPointer<vtkSliderWidget>::New());
    widgets_.back()->SetInteractor(window.interactor());
    widgets_.back()->SetCurrentRenderer(window.overlay());
    widgets_.back()->SetRepresentation(representations_.back());
    widgets_.back()->SetAnimationModeToJump();
    widgets_.back()->KeyPressActivationOff();  // i is ours
    widgets_.back()->AddObserver(vtkCommand::InteractionEvent, this, &ParameterSliders::moved);
  }
}

ParameterSliders::~ParameterSliders() { setVisible(false); }

void ParameterSliders::moved(vtkObject* widget, unsigned long, void*) {
  const auto at = std::find(widgets_.begin(), widgets_.end(), widget);
  const auto k = static_cast<std::size_t>(at - widgets_.begin());
  const SliderParameter& parameter = sliderParameters()[k];
  on_change_(parameter, static_cast<float>(parameter.scale * representations_[k]->GetValue()));
}

void ParameterSliders::setVisible(bool visible) {
  if (visible == visible_) return;
  visible_ = visible;
  for (const auto& caption : captions_) caption->SetVisibility(visible);
  for (const auto& widget : widgets_) {
    if (visible) widget->SetCurrentRenderer(window_.overlay());  // else it takes the one under the cursor
    widget->SetEnabled(visible);
  }
}

void ParameterSliders::setValues(const FuseFlowParameters& parameters) {
  FuseFlowParameters copy = parameters;
  for (std::size_t k = 0; k < representations_.size(); ++k) {
    const SliderParameter& parameter = sliderParameters()[k];
    const double value = static_cast<double>(parameter.member(copy)) / parameter.scale;
    representations_[k]->SetValue(value);
    char caption[64];
    std::snprintf(caption, sizeof(caption), "%s: %.3g", parameter.title.c_str(), value);
    captions_[k]->SetInput(caption);
  }
}

double ParameterSliders::takenWidth() const { return kSliderLength + 1.5 * kSliderMargin; }

void ParameterSliders::arrange(double y) {
  const double top = window_.height() - kSliderMargin / 3, right = window_.width() - kSliderMargin;
  const double left = std::max(kSliderMargin, right - kSliderLength);
  const double distance = std::min(kSliderDistance, (top - y) / static_cast<double>(representations_.size()));
  for (std::size_t k = 0; k < representations_.size(); ++k) {
    const double caption = top - distance * static_cast<double>(k) - kCaption;
    captions_[k]->SetPosition(left, caption);
    placeSlider(representations_[k], window_, left, right, caption - kSliderHalf - 3);
  }
}

}  // namespace fuse_flow::viewing
