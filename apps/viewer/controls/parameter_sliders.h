#pragma once

#include "viewer/window.h"

#include <fuse_flow/fuse_flow.h>

#include <vtkSliderRepresentation2D.h>
#include <vtkSliderWidget.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include <functional>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief A parameter that a slider moves. */
struct SliderParameter {
  std::string title;
  double low;
  double high;
  double scale;  ///< of the slider to the parameter's unit: 0.001 for millimetres
  std::function<float&(FuseFlowParameters&)> member;
};

/** \brief τ, σ, the cell sizes, and the smallest weight. */
const std::vector<SliderParameter>& sliderParameters();

/** \brief Sets one. Cells are never smaller than the smallest: one of the two takes the other with it. */
void setParameter(const SliderParameter& parameter, float value, FuseFlowParameters& parameters);

/** \brief Sliders in the window, one a parameter; over each its title and value. */
class ParameterSliders {
 public:
  using OnChange = std::function<void(const SliderParameter& parameter, float value)>;

  /** \param on_change called with each move; the value in the parameter's own unit */
  ParameterSliders(Window& window, OnChange on_change);
  ~ParameterSliders();
  ParameterSliders(const ParameterSliders&) = delete;
  ParameterSliders& operator=(const ParameterSliders&) = delete;

  void setVisible(bool visible);
  bool visible() const { return visible_; }
  /** \brief Moves the sliders to the values of the parameters, without a callback. The caption also shows a value out of a slider's
   *  range. */
  void setValues(const FuseFlowParameters& parameters);
  /** \brief Right of the window, below one another, and no lower than y, pixels from the window's lower border. */
  void arrange(double y);
  /** \brief What they take of the window's width, pixels. */
  double takenWidth() const;
  vtkSliderRepresentation2D* representation(std::size_t k) { return representations_[k]; }
  vtkTextActor* caption(std::size_t k) { return captions_[k]; }

 private:
  void moved(vtkObject* widget, unsigned long event, void* data);

  Window& window_;
  OnChange on_change_;
  std::vector<vtkSmartPointer<vtkSliderRepresentation2D>> representations_;
  std::vector<vtkSmartPointer<vtkSliderWidget>> widgets_;
  std::vector<vtkSmartPointer<vtkTextActor>> captions_;
  bool visible_{false};
};

}  // namespace fuse_flow::viewing
