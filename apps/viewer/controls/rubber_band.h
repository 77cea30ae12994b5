#pragma once

#include "viewer/window.h"

#include <vtkActor2D.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>

#include <array>
#include <utility>

namespace fuse_flow::viewing {

/** \brief A rectangle that is dragged over the window. */
class RubberBand {
 public:
  using Corner = std::array<int, 2>;  ///< pixels from the lower left

  explicit RubberBand(Window& window);

  void begin(const Corner& corner);
  void moveTo(const Corner& corner);
  /** \brief Takes it away. \returns where it began and ended */
  std::pair<Corner, Corner> end();
  bool dragged() const { return line_->GetVisibility() != 0; }

 private:
  vtkSmartPointer<vtkPoints> corners_;
  vtkSmartPointer<vtkActor2D> line_;
  Corner from_{}, to_{};
};

}  // namespace fuse_flow::viewing
