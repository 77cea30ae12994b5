#pragma once

#include "viewer/panes.h"

#include <Eigen/Geometry>

#include <vtkBoxRepresentation.h>
#include <vtkBoxWidget2.h>
#include <vtkSmartPointer.h>

#include <functional>

namespace fuse_flow::viewing {

/** \brief A box in the first view whose faces have handles; what lies outside is not fused. */
class CropBox {
 public:
  using OnChange = std::function<void(const Eigen::AlignedBox3f& box)>;

  /** \param on_change called while a handle moves; world frame, metres */
  CropBox(Window& window, Panes& panes, OnChange on_change);
  ~CropBox();
  CropBox(const CropBox&) = delete;
  CropBox& operator=(const CropBox&) = delete;

  void show(const Eigen::AlignedBox3f& box);
  void setColor(double r, double g, double b);
  void hide();
  bool visible() { return widget_->GetEnabled() != 0; }
  Eigen::AlignedBox3d box();

 private:
  void moved(vtkObject* widget, unsigned long event, void* data);

  Panes& panes_;
  OnChange on_change_;
  vtkSmartPointer<vtkBoxRepresentation> representation_;
  vtkSmartPointer<vtkBoxWidget2> widget_;
};

}  // namespace fuse_flow::viewing
