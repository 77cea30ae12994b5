#include "viewer/world/probe.h"

#include "viewer/world/drawn_point.h"

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
  // Over everything: they lie on the surface that they measure, whose points would hide them.
  mapper->SetRelativeCoincidentTopologyPointOffsetParameter(kInFront);
  mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, kInFront);
  actor_->SetMapper(mapper);
  actor_->GetProperty()->SetColor(1, 0.75, 0.2);
  actor_->GetProperty()->SetLighting(false);
  actor_->GetProperty()->SetPointSize(10);
  actor_->GetProperty()->SetLineWidth(3);
  actor_->PickableOff();
  for (std::size_t k = 0; k < kPanes; ++k) panes_.renderer(k)->AddActor(actor_);
  draw();
}

Eigen::Matrix4f Probe::projectionOf(std::size_t pane) {
  panes_.aimCamera(pane);
  const double aspect = panes_.renderer(pane)->GetTiledAspectRatio();
  // VTK's matrices are row by row.
  const Eigen::Matrix4d projection = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(
      panes_.camera()->GetCompositeProjectionTransformMatrix(aspect, -1, 1)->GetData());
  return projection.cast<float>();
}

Eigen::Vector2f Probe::clipPlace(std::size_t pane, double x, double y) {
  const int* origin = panes_.renderer(pane)->GetOrigin();
  const int* size = panes_.renderer(pane)->GetSize();
  return Eigen::Vector2d(2 * (x - origin[0] + 0.5) / size[0] - 1, 2 * (y - origin[1] + 0.5) / size[1] - 1)
      .cast<float>();
}

std::optional<PickedPoint> Probe::pick(int x, int y) {
  const std::size_t pane = panes_.paneAt(x);
  const std::shared_ptr<const FusedCloud>& shown = panes_.cloud(pane);
  if (!shown || shown->cloud->empty()) return std::nullopt;
  const Eigen::Vector2f at = clipPlace(pane, x, y);
  const Eigen::Vector2f radius = clipPlace(pane, x + kTolerance, y + kTolerance) - at;
  const std::optional<std::size_t> index = pointDrawnAt(*shown->cloud, projectionOf(pane), at, radius);
  if (!index) return std::nullopt;
  return PickedPoint{pane, *index, (*shown->cloud)[*index].getVector3fMap()};
}

std::string Probe::describe(const PickedPoint& point) const {
  const FusedCloud& shown = *panes_.cloud(point.pane);
  const PointFused& p = (*shown.cloud)[point.index];
  std::ostringstream text;
  text << std::fixed << std::setprecision(3) << "x " << p.x << ", y " << p.y << ", z " << p.z << " m"
       << std::setprecision(2);
  if (shown.attributes.confidence_known) text << ", omega " << p.confidence;
  if (shown.attributes.views_known) text << ", " << p.view_count << (p.view_count == 1 ? " view" : " views");
  return text.str();
}

SelectedPoints Probe::select(const std::array<int, 2>& from, const std::array<int, 2>& to) {
  SelectedPoints selected;
  selected.pane = panes_.paneAt(from[0]);
  const std::shared_ptr<const FusedCloud>& shown = panes_.cloud(selected.pane);
  if (!shown) return selected;
  const Eigen::Vector2f a = clipPlace(selected.pane, from[0], from[1]), b = clipPlace(selected.pane, to[0], to[1]);
  const std::vector<std::size_t> inside =
      pointsDrawnIn(*shown->cloud, projectionOf(selected.pane), a.cwiseMin(b), a.cwiseMax(b));
  selected.count = inside.size();
  for (const std::size_t k : inside) {
    const PointFused& p = (*shown->cloud)[k];
    selected.box.extend(p.getVector3fMap());
    selected.mean_confidence += static_cast<double>(p.confidence) / static_cast<double>(inside.size());
    selected.mean_view_count += static_cast<double>(p.view_count) / static_cast<double>(inside.size());
  }
  return selected;
}

std::string Probe::describe(const SelectedPoints& points) const {
  if (points.count == 0) return "there is no point in the rectangle";
  const FusedCloud& shown = *panes_.cloud(points.pane);
  const Eigen::Vector3f size = points.box.sizes();
  std::ostringstream text;
  text << points.count << (points.count == 1 ? " point of " : " points of ") << shown.setting->title << std::fixed
       << std::setprecision(3) << ", " << size.x() << " x " << size.y() << " x " << size.z() << " m";
  if (shown.attributes.confidence_known) text << ", omega " << std::setprecision(2) << points.mean_confidence;
  if (shown.attributes.views_known) text << ", " << std::setprecision(1) << points.mean_view_count << " views";
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
