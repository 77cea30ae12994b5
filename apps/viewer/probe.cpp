#include "viewer/probe.h"

#include "viewer/drawn_point.h"

#include <vtkCellArray.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkProperty.h>

#include <iomanip>
#include <sstream>

namespace fuse_flow::viewing {
namespace {

constexpr double kTolerance = 4;  // pixels

}  // namespace

Probe::Probe(Panes& panes)
    : panes_(panes), drawn_(vtkSmartPointer<vtkPolyData>::New()), actor_(vtkSmartPointer<vtkActor>::New()) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(drawn_);
  mapper->SetResolveCoincidentTopologyToPolygonOffset();
  actor_->SetMapper(mapper);
  actor_->GetProperty()->SetColor(1, 0.75, 0.2);
  actor_->GetProperty()->SetLighting(false);
  actor_->GetProperty()->SetPointSize(10);
  actor_->GetProperty()->SetLineWidth(3);
  actor_->PickableOff();
  for (std::size_t k = 0; k < kPanes; ++k) panes_.renderer(k)->AddActor(actor_);
  draw();
}

std::optional<PickedPoint> Probe::pick(int x, int y) {
  const std::size_t pane = panes_.paneAt(x);
  const std::shared_ptr<const FusedCloud>& shown = panes_.cloud(pane);
  if (!shown || shown->cloud->empty()) return std::nullopt;
  panes_.aimCamera(pane);
  vtkRenderer* renderer = panes_.renderer(pane);
  const int* origin = renderer->GetOrigin();
  const int* size = renderer->GetSize();
  // VTK's matrices are row by row.
  const Eigen::Matrix4d projection = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(
      panes_.camera()->GetCompositeProjectionTransformMatrix(renderer->GetTiledAspectRatio(), -1, 1)->GetData());
  const Eigen::Array2d pixel(2.0 / size[0], 2.0 / size[1]);
  const Eigen::Array2d at = pixel * (Eigen::Array2d(x - origin[0], y - origin[1]) + 0.5) - 1.0;
  const std::optional<std::size_t> index = pointDrawnAt(
      *shown->cloud, projection.cast<float>(), at.matrix().cast<float>(), (kTolerance * pixel).matrix().cast<float>());
  if (!index) return std::nullopt;
  return PickedPoint{pane, *index, (*shown->cloud)[*index].getVector3fMap()};
}

std::string Probe::describe(const PickedPoint& point) const {
  const PointFused& p = (*panes_.cloud(point.pane)->cloud)[point.index];
  std::ostringstream text;
  text << std::fixed << std::setprecision(3) << "x " << p.x << ", y " << p.y << ", z " << p.z << " m, omega "
       << std::setprecision(2) << p.confidence << ", " << p.view_count << (p.view_count == 1 ? " view" : " views");
  return text.str();
}

void Probe::mark(const PickedPoint& point) {
  if (marks_.size() == 2) marks_.clear();
  marks_.push_back(point.position);
  draw();
}

void Probe::clear() {
  marks_.clear();
  draw();
}

std::optional<double> Probe::distance() const {
  if (marks_.size() < 2) return std::nullopt;
  return static_cast<double>((marks_[1] - marks_[0]).norm());
}

void Probe::draw() {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> vertices, lines;
  for (const Eigen::Vector3f& mark : marks_) {
    const vtkIdType id = points->InsertNextPoint(mark.data());
    vertices->InsertNextCell(1, &id);
  }
  const vtkIdType ends[2] = {0, 1};
  if (marks_.size() == 2) lines->InsertNextCell(2, ends);
  drawn_->SetPoints(points);
  drawn_->SetVerts(vertices);
  drawn_->SetLines(lines);
  actor_->SetVisibility(!marks_.empty());
}

}  // namespace fuse_flow::viewing
