#pragma once

#include "viewer/panes.h"

#include <fuse_flow/camera.h>

#include <vtkBillboardTextActor3D.h>
#include <vtkSmartPointer.h>

#include <vector>

namespace fuse_flow::viewing {

/** \brief The lines of each camera's field of view, from its centre to its image's corners at a depth, and around them, in
 *  its colour: eight a camera; world frame, metres. */
vtkSmartPointer<vtkPolyData> frustumLines(const std::vector<Camera>& cameras, float depth);

/** \brief Draws where the cameras stand and what they look at, in their colours, with their names. */
class Frusta {
 public:
  explicit Frusta(Panes& panes);
  void setCameras(const std::vector<Camera>& cameras);
  void setVisible(bool visible);

 private:
  void addName(const Camera& camera, std::size_t number);

  Panes& panes_;
  std::vector<Camera> cameras_;
  vtkSmartPointer<vtkPolyDataMapper> lines_mapper_;
  vtkSmartPointer<vtkActor> lines_;
  std::vector<vtkSmartPointer<vtkBillboardTextActor3D>> names_;
  bool visible_{true};
};

}  // namespace fuse_flow::viewing
