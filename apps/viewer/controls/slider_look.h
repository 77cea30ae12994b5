#pragma once

#include "viewer/window.h"

#include <vtkSliderRepresentation2D.h>
#include <vtkSmartPointer.h>

namespace fuse_flow::viewing {

/** \brief From the border of the window, pixels. */
constexpr double kSliderMargin = 30;

/** \brief On each side of a slider's middle, pixels. */
constexpr double kSliderHalf = 7;

/** \brief A slider as all of ours look, without a title: VTK would write it below, where the next slider's value is. */
vtkSmartPointer<vtkSliderRepresentation2D> makeSlider(double low, double high);

/** \brief From left to right at a height, pixels from the lower left, and as thick as it should be in this window. */
void placeSlider(vtkSliderRepresentation2D* slider, Window& window, double left, double right, double y);

}  // namespace fuse_flow::viewing
