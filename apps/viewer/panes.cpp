#include "viewer/panes.h"

#include <vtkActor2D.h>
#include <vtkBoundingBox.h>
#include <vtkCoordinate.h>
#include <vtkLineSource.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkRendererCollection.h>

#include <algorithm>
#include <cmath>

namespace fuse_flow::viewing {
namespace {

constexpr int kGrip = 8;  // pixels on each side of the line

vtkSmartPointer<vtkActor2D> makeLine() {
  vtkNew<vtkLineSource> source;
  source->SetPoint1(0, 0, 0);
  source->SetPoint2(0, 1, 0);
  vtkNew<vtkCoordinate> window_shares;
  window_shares->SetCoordinateSystemToNormalizedViewport();
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputConnection(source->GetOutputPort());
  mapper->SetTransformCoordinate(window_shares);
  const auto line = vtkSmartPointer<vtkActor2D>::New();
  line->SetMapper(mapper);
  line->GetProperty()->SetColor(1, 0.75, 0.2);
  line->GetProperty()->SetLineWidth(2);
  line->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  return line;
}

}  // namespace

Panes::Panes(Window& window) : window_(window), line_(makeLine()) {
  for (std::size_t k = 0; k < kPanes; ++k) {
    int viewport = 0;
    window.visualizer().createViewPort(0, 0, 1, 1, viewport);  // with the camera of those before it
    renderers_[k] = static_cast<vtkRenderer*>(window.visualizer().getRendererCollection()->GetItemAsObject(viewport));
    for (auto* mappers : {&fine_, &coarse_}) {
      (*mappers)[k] = vtkSmartPointer<vtkPolyDataMapper>::New();
      (*mappers)[k]->SetInputData(vtkNew<vtkPolyData>());
    }
    actors_[k] = vtkSmartPointer<vtkActor>::New();
    actors_[k]->SetMapper(fine_[k]);
    actors_[k]->GetProperty()->SetLighting(false);
    renderers_[k]->AddActor(actors_[k]);
    observers_[k] = renderers_[k]->AddObserver(vtkCommand::StartEvent, this, &Panes::aimAt);
  }
  window.overlay()->AddActor2D(line_);
  arrange();
}

Panes::~Panes() {
  for (std::size_t k = 0; k < kPanes; ++k) renderers_[k]->RemoveObserver(observers_[k]);
}

void Panes::setCloud(std::size_t pane, std::shared_ptr<const FusedCloud> cloud) {
  if (clouds_[pane] == cloud) return;
  clouds_[pane] = std::move(cloud);
  updateMappers();
}

/** \brief Only what is about to be drawn is handed to VTK, so that a moving view never waits for all points. */
void Panes::updateMappers() {
  for (std::size_t k = 0; k < kPanes; ++k) {
    if (clouds_[k]) {
      if (show_coarse_)
        coarse_[k]->SetInputData(clouds_[k]->coarse);
      else
        fine_[k]->SetInputData(clouds_[k]->points);
    }
    actors_[k]->SetMapper(show_coarse_ ? coarse_[k] : fine_[k]);
    actors_[k]->SetVisibility(clouds_[k] != nullptr);
  }
}

void Panes::setCoarse(bool coarse) {
  if (show_coarse_ == coarse) return;
  show_coarse_ = coarse;
  updateMappers();
}

void Panes::setComparing(bool comparing) {
  comparing_ = comparing;
  arrange();
}

void Panes::setLayout(Layout layout) {
  layout_ = layout;
  arrange();
}

void Panes::setSplit(double share) {
  split_ = std::clamp(share, 0.02, 0.98);
  arrange();
}

std::array<double, 2> Panes::extent(std::size_t pane) const {
  if (!comparing_) return {0, 1};
  const double middle = layout_ == Layout::Split ? split_ : 0.5;
  return pane == 0 ? std::array<double, 2>{0, middle} : std::array<double, 2>{middle, 1};
}

void Panes::arrange() {
  for (std::size_t k = 0; k < kPanes; ++k) {
    const auto [begin, end] = extent(k);
    renderers_[k]->SetViewport(begin, 0, end, 1);
  }
  renderers_[1]->SetDraw(comparing_);
  renderers_[1]->SetInteractive(comparing_);
  line_->SetVisibility(comparing_);
  line_->SetPosition(extent(1)[0], 0);
}

/** \brief The frustum of a whole window, cut at the line: each part has its own middle, in halves of its own width. */
void Panes::aimCamera(std::size_t pane) {
  double shift = 0;
  if (comparing_ && layout_ == Layout::Split) {
    const auto [begin, end] = extent(pane);
    shift = (begin + end - 1) / (end - begin);
  }
  camera()->SetWindowCenter(shift, 0);
}

void Panes::fitClippingRange() {
  vtkBoundingBox both;
  for (const auto& renderer : renderers_) {
    double bounds[6];
    renderer->ComputeVisiblePropBounds(bounds);
    if (vtkMath::AreBoundsInitialized(bounds)) both.AddBounds(bounds);
  }
  if (!both.IsValid()) return;
  double bounds[6];
  both.GetBounds(bounds);
  renderers_[0]->ResetCameraClippingRange(bounds);
}

void Panes::aimAt(vtkObject* renderer, unsigned long, void*) { aimCamera(renderer == renderers_[0] ? 0 : 1); }

bool Panes::nearSplit(int x) const {
  return comparing_ && layout_ == Layout::Split && std::abs(x - split_ * window_.width()) <= kGrip;
}

std::size_t Panes::paneAt(int x) const { return comparing_ && x >= extent(1)[0] * window_.width() ? 1 : 0; }

void Panes::setPointSize(double pixels) {
  for (const auto& actor : actors_) actor->GetProperty()->SetPointSize(static_cast<float>(pixels));
}

void Panes::setBackground(double r, double g, double b) { window_.visualizer().setBackgroundColor(r, g, b, 0); }

}  // namespace fuse_flow::viewing
