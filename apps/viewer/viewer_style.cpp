#include "viewer/viewer_style.h"

#include <vtkObjectFactory.h>

namespace fuse_flow::viewing {

vtkStandardNewMacro(ViewerStyle)

    void ViewerStyle::OnKeyDown() {
  if (on_key) on_key();
}

void ViewerStyle::OnLeftButtonDown() {
  if (!on_press || !on_press()) Superclass::OnLeftButtonDown();
}

void ViewerStyle::OnLeftButtonUp() {
  if (!on_release || !on_release()) Superclass::OnLeftButtonUp();
}

void ViewerStyle::OnMouseMove() {
  if (!on_move || !on_move()) Superclass::OnMouseMove();
}

}  // namespace fuse_flow::viewing
