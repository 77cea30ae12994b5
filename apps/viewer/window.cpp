#include "viewer/window.h"

#include <vtkGenericRenderWindowInteractor.h>

namespace fuse_flow::viewing {

Window::Window(const std::string& title, int width, int height, bool offscreen)
    : style_(vtkSmartPointer<ViewerStyle>::New()), overlay_(vtkSmartPointer<vtkRenderer>::New()) {
  const auto window = vtkSmartPointer<vtkRenderWindow>::New();
  window->SetOffScreenRendering(offscreen);
  window->SetMultiSamples(0);  // points have no edges to smooth
  int no_arguments = 0;
  visualizer_ = std::make_unique<pcl::visualization::PCLVisualizer>(
      no_arguments, nullptr, vtkSmartPointer<vtkRenderer>::New(), window, title, style_, false);
  visualizer_->setShowFPS(false);
  visualizer_->setSize(width, height);
  window->SetNumberOfLayers(2);
  overlay_->SetLayer(1);
  overlay_->InteractiveOff();
  window->AddRenderer(overlay_);
  if (offscreen)
    interactor_ = vtkSmartPointer<vtkGenericRenderWindowInteractor>::New();
  else
    interactor_ = vtkSmartPointer<vtkRenderWindowInteractor>::New();
  visualizer_->setupInteractor(interactor_, window);
  style_->UseTimersOff();
}

/** \brief PCL's style holds the window, which holds the interactor, which holds the style: none of them would ever go. */
Window::~Window() { interactor_->SetInteractorStyle(nullptr); }

void Window::pressKey(const std::string& key) {
  const bool ctrl = key.rfind("ctrl+", 0) == 0, alt = key.rfind("alt+", 0) == 0;
  const std::string name = key.substr(ctrl ? 5 : alt ? 4 : 0);
  char code = name.size() == 1 ? name[0] : '\0';
  if (name == "plus") code = '+';
  if (name == "minus") code = '-';
  interactor_->SetAltKey(alt);
  interactor_->SetKeyEventInformation(ctrl, 0, code, 0, name.c_str());
  interactor_->InvokeEvent(vtkCommand::KeyPressEvent);
  interactor_->InvokeEvent(vtkCommand::KeyReleaseEvent);
  interactor_->SetAltKey(0);
}

void Window::moveCursor(int x, int y) {
  interactor_->SetEventInformation(x, y, 0, 0);
  interactor_->InvokeEvent(vtkCommand::MouseMoveEvent);
}

}  // namespace fuse_flow::viewing
