#include "viewer/world/frusta.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPoints.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>

namespace fuse_flow::viewing {
namespace {

constexpr float kDepth = 0.25f;  // metres: of the drawn frusta
constexpr int kNameSize = 13;    // points
constexpr float kDots = 6;       // pixels, where frusta are drawn as dots

bool same(const std::vector<Camera>& a, const std::vector<Camera>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Camera& x, const Camera& y) { return x.name == y.name && sameCalibration(x, y); });
}

/** \brief A text in the world that no point hides. */
class Name : public vtkBillboardTextActor3D {
 public:
  static Name* New();

 protected:
  Name() { QuadMapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(0, kInFront); }
};
vtkStandardNewMacro(Name);

}  // namespace

vtkSmartPointer<vtkPolyData> frustumLines(const std::vector<Camera>& cameras, float depth) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  for (std::size_t number = 0; number < cameras.size(); ++number) {
    const Intrinsics& K = cameras[number].intrinsics;
    const Eigen::Isometry3d& T = cameras[number].T_world_camera;
    const vtkIdType centre = points->InsertNextPoint(T.translation().data());
    const float right = static_cast<float>(K.width - 1), bottom = static_cast<float>(K.height - 1);
    for (const Pixel& corner : {Pixel{0, 0}, Pixel{right, 0}, Pixel{right, bottom}, Pixel{0, bottom}}) {
      const Vec3 p = pointOnRay(unproject(K, corner), depth);
      const Eigen::Vector3d p_W = T * Eigen::Vector3f(p.x, p.y, p.z).cast<double>();
      points->InsertNextPoint(p_W.data());
    }
    const Rgb8 color = cameraColor(number);
    const auto line = [&](vtkIdType from, vtkIdType to) {
      const vtkIdType ends[2] = {centre + from, centre + to};
      const unsigned char rgb[3] = {color.r, color.g, color.b};
      lines->InsertNextCell(2, ends);
      colors->InsertNextTypedTuple(rgb);
    };
    for (vtkIdType k = 1; k <= 4; ++k) {
      line(0, k);
      line(k, k % 4 + 1);
    }
  }
  const auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetLines(lines);
  data->GetCellData()->SetScalars(colors);
  return data;
}

Frusta::Frusta(Panes& panes)
    : panes_(panes),
      lines_mapper_(vtkSmartPointer<vtkPolyDataMapper>::New()),
      lines_(vtkSmartPointer<vtkActor>::New()) {
  lines_mapper_->SetInputData(frustumLines({}, kDepth));
  lines_->SetMapper(lines_mapper_);
  lines_->GetProperty()->SetLighting(false);
  lines_->GetProperty()->SetPointSize(kDots);
  lines_->PickableOff();
  for (std::size_t k = 0; k < kPanes; ++k) panes_.renderer(k)->AddViewProp(lines_);
}

void Frusta::addName(const Camera& camera, std::size_t number) {
  const Rgb8 color = cameraColor(number);
  const auto name = vtkSmartPointer<Name>::New();
  const Eigen::Vector3d centre = camera.T_world_camera.translation();
  name->SetInput(camera.name.c_str());
  name->SetPosition(centre.x(), centre.y(), centre.z());
  name->SetDisplayOffset(kNameSize / 2, kNameSize / 2);
  name->GetTextProperty()->SetColor(color.r / 255.0, color.g / 255.0, color.b / 255.0);
  name->GetTextProperty()->SetFontSize(kNameSize);
  name->GetTextProperty()->SetBackgroundColor(0, 0, 0);
  name->GetTextProperty()->SetBackgroundOpacity(0.7);
  name->GetTextProperty()->BoldOn();
  name->ForceOpaqueOn();  // translucent props make VTK draw the whole scene in more passes
  name->PickableOff();
  name->SetVisibility(visible_);
  for (std::size_t k = 0; k < kPanes; ++k) panes_.renderer(k)->AddViewProp(name);
  names_.push_back(name);
}

void Frusta::setCameras(const std::vector<Camera>& cameras) {
  if (same(cameras, cameras_)) return;
  cameras_ = cameras;
  lines_mapper_->SetInputData(frustumLines(cameras, kDepth));
  for (const auto& name : names_)
    for (std::size_t k = 0; k < kPanes; ++k) panes_.renderer(k)->RemoveViewProp(name);
  names_.clear();
  for (std::size_t number = 0; number < cameras.size(); ++number) addName(cameras[number], number);
}

void Frusta::setVisible(bool visible) {
  visible_ = visible;
  lines_->SetVisibility(visible);
  for (const auto& name : names_) name->SetVisibility(visible);
}

}  // namespace fuse_flow::viewing
