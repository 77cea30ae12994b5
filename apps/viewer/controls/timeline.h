#pragma once

#include "viewer/window.h"

#include <vtkSliderRepresentation2D.h>
#include <vtkSliderWidget.h>
#include <vtkSmartPointer.h>

#include <functional>
#include <optional>

namespace fuse_flow::viewing {

/** \brief A slider over the frames of a recording, lower right; a source without an end has none. */
class Timeline {
 public:
  using OnSeek = std::function<void(std::size_t frame)>;

  Timeline(Window& window, OnSeek on_seek);
  ~Timeline();
  Timeline(const Timeline&) = delete;
  Timeline& operator=(const Timeline&) = delete;

  /** \brief What is shown, of how many; does not tell of it. The slider counts from 1. */
  void setFrame(std::size_t frame, std::optional<std::size_t> frames);
  void setVisible(bool visible);
  /** \param y pixels from the window's lower border */
  void arrange(double y);
  vtkSliderRepresentation2D* representation() { return slider_; }

 private:
  void moved(vtkObject* widget, unsigned long event, void* data);
  void update();

  Window& window_;
  OnSeek on_seek_;
  vtkSmartPointer<vtkSliderRepresentation2D> slider_;
  vtkSmartPointer<vtkSliderWidget> widget_;
  bool visible_{true};
  bool useful_{false};
};

}  // namespace fuse_flow::viewing
