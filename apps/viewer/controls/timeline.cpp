#include "viewer/controls/timeline.h"

#include "viewer/controls/slider_look.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::viewing {
namespace {

constexpr double kTimelineLength = 220;  // pixels

}  // namespace

Timeline::Timeline(Window& window, OnSeek on_seek)
    : window_(window),
      on_seek_(std::move(on_seek)),
      slider_(makeSlider(1, 2)),
      widget_(vtkSmartPointer<vtkSliderWidget>::New()) {
  slider_->SetLabelFormat("frame %.0f");
  widget_->SetInteractor(window.interactor());
  widget_->SetRepresentation(slider_);
  widget_->SetAnimationModeToJump();
  widget_->KeyPressActivationOff();
  widget_->AddObserver(vtkCommand::InteractionEvent, this, &Timeline::moved);
}

Timeline::~Timeline() { widget_->Off(); }

void Timeline::moved(vtkObject*, unsigned long, void*) {
  on_seek_(static_cast<std::size_t>(std::lround(slider_->GetValue())) - 1);
}

void Timeline::setFrame(std::size_t frame, std::optional<std::size_t> frames) {
  useful_ = frames && *frames > 1;
  if (useful_) slider_->SetMaximumValue(static_cast<double>(*frames));
  slider_->SetValue(static_cast<double>(frame + 1));
  update();
}

void Timeline::setVisible(bool visible) {
  visible_ = visible;
  update();
}

void Timeline::update() {
  if ((widget_->GetEnabled() != 0) == (visible_ && useful_)) return;
  widget_->SetCurrentRenderer(window_.overlay());  // else it takes the one under the cursor
  widget_->SetEnabled(visible_ && useful_);
}

void Timeline::arrange(double y) {
  const double right = window_.width() - kSliderMargin;
  placeSlider(slider_, window_, std::max(kSliderMargin, right - kTimelineLength), right, y);
}

}  // namespace fuse_flow::viewing
