#pragma once

#include "viewer/viewer_style.h"

#include <pcl/visualization/pcl_visualizer.h>

#include <vtkCamera.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <string>

namespace fuse_flow::viewing {

/** \brief A PCLVisualizer with a layer over it for what is not of the world: texts, images, sliders. */
class Window {
 public:
  /** \brief \param offscreen without a window and without events from outside; the display must exist all the same */
  Window(const std::string& title, int width, int height, bool offscreen);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  pcl::visualization::PCLVisualizer& visualizer() { return *visualizer_; }
  vtkRenderWindow* renderWindow() { return visualizer_->getRenderWindow(); }
  vtkRenderWindowInteractor* interactor() { return interactor_; }
  ViewerStyle* style() { return style_; }
  vtkRenderer* overlay() { return overlay_; }
  int width() { return renderWindow()->GetSize()[0]; }
  int height() { return renderWindow()->GetSize()[1]; }

  /** \brief Acts as if a key were pressed: a VTK name as "a", "space" or "Right", perhaps with "ctrl+" or "alt+" before it. */
  void pressKey(const std::string& key);
  /** \brief Acts as if the cursor went there; pixels from the lower left. */
  void moveCursor(int x, int y);

 private:
  vtkSmartPointer<ViewerStyle> style_;
  std::unique_ptr<pcl::visualization::PCLVisualizer> visualizer_;
  vtkSmartPointer<vtkRenderer> overlay_;
  vtkSmartPointer<vtkRenderWindowInteractor> interactor_;
};

}  // namespace fuse_flow::viewing
