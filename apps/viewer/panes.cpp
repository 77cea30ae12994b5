#include "viewer/panes.h"

#include "viewer/world/point_data.h"

#include <vtkActor2D.h>
#include <vtkBillboardTextActor3D.h>
#include <vtkBoundingBox.h>
#include <vtkCoordinate.h>
#include <vtkLineSource.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkPropCollection.h>
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

Panes::Panes(Window& window, std::function<void()> on_slice)
    : window_(window), on_slice_(std::move(on_slice)), line_(makeLine()) {
  vtkMapper::SetResolveCoincidentTopologyToPolygonOffset();  // of all mappers: kInFront needs it
  for (std::size_t k = 0; k < kPanes; ++k) {
    int viewport = 0;
    window.visualizer().createViewPort(0, 0, 1, 1, viewport);  // with the camera of those before it
    renderers_[k] = static_cast<vtkRenderer*>(window.visualizer().getRendererCollection()->GetItemAsObject(viewport));
    properties_[k] = vtkSmartPointer<vtkProperty>::New();
    properties_[k]->SetLighting(false);
    observers_[k] = renderers_[k]->AddObserver(vtkCommand::StartEvent, this, &Panes::aimAt);
  }
  window.overlay()->AddActor2D(line_);
  arrange();
}

Panes::~Panes() {
  for (std::size_t k = 0; k < kPanes; ++k) renderers_[k]->RemoveObserver(observers_[k]);
  for (const auto& slices : slices_)
    for (const Slice& slice : slices) slice.mapper->RemoveAllObservers();
}

void Panes::addSlice(std::size_t pane) {
  Slice slice{vtkSmartPointer<vtkActor>::New(), vtkSmartPointer<vtkPolyDataMapper>::New()};
  slice.mapper->AddObserver(vtkCommand::EndEvent, this, &Panes::onSlice);
  slice.actor->SetMapper(slice.mapper);
  slice.actor->SetProperty(properties_[pane]);
  renderers_[pane]->AddActor(slice.actor);
  slices_[pane].push_back(slice);
}

void Panes::onSlice(vtkObject*, unsigned long, void*) { on_slice_(); }

void Panes::setCloud(std::size_t pane, std::shared_ptr<const FusedCloud> cloud) {
  if (clouds_[pane] == cloud) return;
  clouds_[pane] = std::move(cloud);
  updateSlices();
}

/** \brief Only what is about to be drawn is handed to VTK, so that a moving view never waits for all points. */
void Panes::updateSlices() {
  const double share =
      coarse_ ? static_cast<double>(coarse_points_) / static_cast<double>(std::max<std::size_t>(1, allPoints())) : 1;
  for (std::size_t k = 0; k < kPanes; ++k) {
    const std::size_t count = clouds_[k] ? clouds_[k]->slices.size() : 0;
    const long wanted_slices = std::lround(std::min(1.0, share) * static_cast<double>(count));
    std::size_t drawn = std::min(count, static_cast<std::size_t>(std::max(1L, wanted_slices)));
    if (drawn < count) drawn = std::min(drawn, thinSlices(count));
    while (slices_[k].size() < count) addSlice(k);
    for (std::size_t i = 0; i < slices_[k].size(); ++i) {
      const Slice& slice = slices_[k][i];
      slice.actor->SetVisibility(i < drawn);
      vtkPolyData* wanted = i >= count                     ? nullptr
                            : slice.actor->GetVisibility() ? clouds_[k]->slices[i].Get()
                                                           : slice.mapper->GetInput();
      if (slice.mapper->GetInput() != wanted) slice.mapper->SetInputData(wanted);
    }
  }
}

void Panes::setCoarse(bool coarse) {
  if (coarse_ == coarse) return;
  coarse_ = coarse;
  updateSlices();
}

void Panes::setCoarsePoints(std::size_t points) {
  coarse_points_ = points;
  if (coarse_) updateSlices();
}

std::size_t Panes::allPoints() const {
  std::size_t points = 0;
  for (std::size_t k = 0; k < kPanes; ++k)
    if (draws(k)) points += clouds_[k]->cloud->size();
  return points;
}

std::size_t Panes::drawnPoints() const {
  vtkIdType points = 0;
  for (std::size_t k = 0; k < kPanes; ++k)
    for (const Slice& slice : slices_[k])
      if (draws(k) && slice.actor->GetVisibility()) points += slice.mapper->GetInput()->GetNumberOfPoints();
  return static_cast<std::size_t>(points);
}

std::optional<std::array<double, 6>> Panes::bounds(std::size_t pane) const {
  vtkBoundingBox box;
  if (clouds_[pane])
    for (const auto& slice : clouds_[pane]->slices) box.AddBounds(slice->GetBounds());
  if (!box.IsValid()) return std::nullopt;
  std::array<double, 6> bounds{};
  box.GetBounds(bounds.data());
  return bounds;
}

Eigen::AlignedBox3f Panes::boxInView() {
  constexpr double kOutermost = 0.01, kBorder = 0.9;  // shares of the points, and of the view's half
  const Cloud& cloud = *clouds_[0]->cloud;
  Eigen::AlignedBox3f box;
  std::vector<float> values(cloud.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(cloud.begin(), cloud.end(), values.begin(), [axis](const PointFused& p) { return p.data[axis]; });
    const auto at = [&](double share) {
      const auto place = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
      std::nth_element(values.begin(), place, values.end());
      return *place;
    };
    box.min()[axis] = at(kOutermost);
    box.max()[axis] = at(1 - kOutermost);
  }
  aimCamera(0);
  const auto seen = [&](const Eigen::Vector3f& p) {
    double x = static_cast<double>(p.x()), y = static_cast<double>(p.y()), z = static_cast<double>(p.z());
    renderers_[0]->WorldToView(x, y, z);
    return std::abs(x) < kBorder && std::abs(y) < kBorder && std::abs(z) < 1;
  };
  const Eigen::Vector3f centre = box.center(), half = box.sizes() / 2;
  for (float share = 1; share > 0.1f; share *= 0.9f) {
    bool all = true;
    for (int axis = 0; axis < 3; ++axis)
      for (const float side : {-1.0f, 1.0f})
        all = all && seen(centre + side * share * half[axis] * Eigen::Vector3f::Unit(axis));
    if (all) return Eigen::AlignedBox3f(centre - share * half, centre + share * half);
  }
  return box;  // the user looks elsewhere
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
  for (const auto& property : properties_) property->SetPointSize(static_cast<float>(pixels));
}

void Panes::setForm(Form form) {
  const int representation = form == Form::Points ? VTK_POINTS : form == Form::Lines ? VTK_WIREFRAME : VTK_SURFACE;
  vtkNew<vtkPropCollection> parts;
  for (const auto& renderer : renderers_) {
    vtkPropCollection* props = renderer->GetViewProps();
    props->InitTraversal();
    while (vtkProp* prop = props->GetNextProp())
      if (!vtkBillboardTextActor3D::SafeDownCast(prop)) prop->GetActors(parts);  // a name is to be read
  }
  parts->InitTraversal();
  while (vtkProp* part = parts->GetNextProp())
    if (vtkActor* actor = vtkActor::SafeDownCast(part)) actor->GetProperty()->SetRepresentation(representation);
}

void Panes::setBackground(double r, double g, double b) { window_.visualizer().setBackgroundColor(r, g, b, 0); }

}  // namespace fuse_flow::viewing
