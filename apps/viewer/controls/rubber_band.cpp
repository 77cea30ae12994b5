#include "viewer/controls/rubber_band.h"

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>

namespace fuse_flow::viewing {

RubberBand::RubberBand(Window& window)
    : corners_(vtkSmartPointer<vtkPoints>::New()), line_(vtkSmartPointer<vtkActor2D>::New()) {
  corners_->SetNumberOfPoints(4);
  const vtkIdType around[5] = {0, 1, 2, 3, 0};
  vtkNew<vtkCellArray> lines;
  lines->InsertNextCell(5, around);
  vtkNew<vtkPolyData> rectangle;
  rectangle->SetPoints(corners_);
  rectangle->SetLines(lines);
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(rectangle);
  line_->SetMapper(mapper);
  line_->GetProperty()->SetColor(1, 0.75, 0.2);
  line_->GetProperty()->SetLineWidth(2);
  line_->VisibilityOff();
  window.overlay()->AddActor2D(line_);
}

void RubberBand::begin(const Corner& corner) {
  from_ = corner;
  moveTo(corner);
  line_->VisibilityOn();
}

void RubberBand::moveTo(const Corner& corner) {
  to_ = corner;
  corners_->SetPoint(0, from_[0], from_[1], 0);
  corners_->SetPoint(1, to_[0], from_[1], 0);
  corners_->SetPoint(2, to_[0], to_[1], 0);
  corners_->SetPoint(3, from_[0], to_[1], 0);
  corners_->Modified();
}

std::pair<RubberBand::Corner, RubberBand::Corner> RubberBand::end() {
  line_->VisibilityOff();
  return {from_, to_};
}

}  // namespace fuse_flow::viewing
