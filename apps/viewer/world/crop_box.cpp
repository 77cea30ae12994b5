#include "viewer/world/crop_box.h"

namespace fuse_flow::viewing {

CropBox::CropBox(Window& window, Panes& panes, OnChange on_change)
    : panes_(panes),
      on_change_(std::move(on_change)),
      representation_(vtkSmartPointer<vtkBoxRepresentation>::New()),
      widget_(vtkSmartPointer<vtkBoxWidget2>::New()) {
  representation_->SetPlaceFactor(1);
  representation_->HandlesOn();
  representation_->GetOutlineProperty()->SetLineWidth(2);
  representation_->GetOutlineProperty()->SetDiffuse(0);  // it would make some edges brighter, in another colour
  widget_->SetInteractor(window.interactor());
  widget_->SetRepresentation(representation_);
  widget_->RotationEnabledOff();  // the crop box of the parameters is parallel to the axes
  widget_->KeyPressActivationOff();
  widget_->AddObserver(vtkCommand::InteractionEvent, this, &CropBox::moved);
}

CropBox::~CropBox() { hide(); }

void CropBox::show(const Eigen::AlignedBox3f& box) {
  const Eigen::Vector3d low = box.min().cast<double>(), high = box.max().cast<double>();
  double bounds[6] = {low.x(), high.x(), low.y(), high.y(), low.z(), high.z()};
  widget_->SetCurrentRenderer(panes_.renderer(0));  // else it takes the one under the cursor
  representation_->PlaceWidget(bounds);
  widget_->On();
}

void CropBox::setColor(double r, double g, double b) {
  for (vtkProperty* property : {representation_->GetOutlineProperty(), representation_->GetSelectedOutlineProperty(),
                                representation_->GetFaceProperty(), representation_->GetSelectedFaceProperty(),
                                representation_->GetHandleProperty()})
    property->SetColor(r, g, b);
  representation_->GetSelectedHandleProperty()->SetColor(1, 1, 1);  // that which is dragged
}

void CropBox::hide() { widget_->Off(); }

Eigen::AlignedBox3d CropBox::box() {
  const double* b = representation_->GetBounds();
  return {Eigen::Vector3d(b[0], b[2], b[4]), Eigen::Vector3d(b[1], b[3], b[5])};
}

void CropBox::moved(vtkObject*, unsigned long, void*) { on_change_(box().cast<float>()); }

}  // namespace fuse_flow::viewing
