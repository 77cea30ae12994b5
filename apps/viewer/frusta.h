#pragma once

#include "viewer/panes.h"

#include <fuse_flow/camera.h>

#include <vtkBillboardTextActor3D.h>
#include <vtkSmartPointer.h>

#include <vector>

namespace fuse_flow::viewing {

/** \brief The lines of a camera's field of view, from its centre to its image's corners at a depth, and around them: world
 *  frame, metres. */
vtkSmartPointer<vtkPolyData> frustumLines(const Camera& camera, float depth);

/** \brief Draws where the cameras stand and what they look at, in their colours, with their names. */
class Frusta {
 public:
  explicit Frusta(Panes& panes) : panes_(panes) {}
  void setCameras(const std::vector<Camera>& cameras);
  void setVisible(bool visible);

 private:
  struct Drawn {
    vtkSmartPointer<vtkActor> lines;
    vtkSmartPointer<vtkBillboardTextActor3D> name;
  };
  void draw(const Camera& camera, std::size_t number);

  Panes& panes_;
  std::vector<Camera> cameras_;
  std::vector<Drawn> drawn_;
  bool visible_{true};
};

}  // namespace fuse_flow::viewing
