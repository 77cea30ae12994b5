#pragma once

#include "viewer/panes.h"

#include <vtkAxesActor.h>
#include <vtkCubeAxesActor.h>
#include <vtkSmartPointer.h>

#include <array>

namespace fuse_flow::viewing {

/** \brief The axes of the world at its origin, half a metre long, and a grid with its metres around the cloud. */
class WorldAxes {
 public:
  explicit WorldAxes(Panes& panes);
  /** \brief The grid goes around these bounds, metres: low and high of x, y, z. */
  void setExtent(const double bounds[6]);
  void showAxes(bool visible) { axes_->SetVisibility(visible); }
  void showGrid(bool visible);
  /** \param grey of the grid, 0 … 1 */
  void setColor(double grey);

 private:
  vtkSmartPointer<vtkAxesActor> axes_;
  std::array<vtkSmartPointer<vtkCubeAxesActor>, kPanes> grids_;
};

}  // namespace fuse_flow::viewing
