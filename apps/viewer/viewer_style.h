#pragma once

#include <pcl/visualization/interactor_style.h>

#include <functional>

namespace fuse_flow::viewing {

/** \brief PCLVisualizer's mouse, and the viewer's own keys. The hooks see every event first, and return whether it
 *  was meant for them. */
class ViewerStyle : public pcl::visualization::PCLVisualizerInteractorStyle {
 public:
  static ViewerStyle* New();
  vtkTypeMacro(ViewerStyle, PCLVisualizerInteractorStyle)

      std::function<void()> on_key;  ///< a key went down; see passKeyToPcl()
  std::function<bool()> on_press;    ///< the left button; true: consumed
  std::function<bool()> on_move;     ///< true: consumed
  std::function<bool()> on_release;  ///< the left button; true: consumed

  /** \brief What PCLVisualizer does on the key of the event at hand. */
  void passKeyToPcl() { Superclass::OnKeyDown(); }

  void OnKeyDown() override;
  void OnLeftButtonDown() override;
  void OnLeftButtonUp() override;
  void OnMouseMove() override;
  /** \brief Nothing: VTK's own keys would act beside ours. */
  void OnChar() override {}
  /** \brief Nothing: PCL's would draw with every tick. */
  void OnTimer() override {}
};

}  // namespace fuse_flow::viewing
