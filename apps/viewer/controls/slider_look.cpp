#include "viewer/controls/slider_look.h"

#include <vtkProperty2D.h>
#include <vtkTextProperty.h>

namespace fuse_flow::viewing {
namespace {

constexpr double kText = 15;  // pixels

}  // namespace

vtkSmartPointer<vtkSliderRepresentation2D> makeSlider(double low, double high) {
  const auto slider = vtkSmartPointer<vtkSliderRepresentation2D>::New();
  slider->SetMinimumValue(low);
  slider->SetMaximumValue(high);
  slider->GetPoint1Coordinate()->SetCoordinateSystemToDisplay();
  slider->GetPoint2Coordinate()->SetCoordinateSystemToDisplay();
  slider->GetSliderProperty()->SetColor(1, 0.75, 0.2);
  slider->GetSelectedProperty()->SetColor(1, 0.9, 0.6);
  slider->GetTubeProperty()->SetColor(0.5, 0.5, 0.5);
  vtkTextProperty* text = slider->GetLabelProperty();
  text->BoldOff();
  text->ShadowOff();
  text->SetColor(1, 1, 1);
  text->SetBackgroundColor(0, 0, 0);
  text->SetBackgroundOpacity(0.55);
  return slider;
}

void placeSlider(vtkSliderRepresentation2D* slider, Window& window, double left, double right, double y) {
  const double width = window.width(), height = window.height();
  slider->SetSliderLength(16 / width);  // VTK takes shares of the window
  slider->SetSliderWidth(2 * kSliderHalf / height);
  slider->SetTubeWidth(5 / height);
  slider->SetEndCapLength(6 / width);
  slider->SetEndCapWidth(10 / height);
  slider->SetLabelHeight(kText / height);
  slider->GetPoint1Coordinate()->SetValue(left, y);
  slider->GetPoint2Coordinate()->SetValue(right, y);
  slider->Modified();  // that its ends have moved it does not see
}

}  // namespace fuse_flow::viewing
