#include "viewer/frusta.h"

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>

#include <algorithm>

namespace fuse_flow::viewing {
namespace {

constexpr float kDepth = 0.25f;  // metres: of the drawn frusta
constexpr int kNameSize = 13;    // points

bool same(const std::vector<Camera>& a, const std::vector<Camera>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Camera& x, const Camera& y) { return x.name == y.name && sameCalibration(x, y); });
}

}  // namespace

vtkSmartPointer<vtkPolyData> frustumLines(const Camera& camera, float depth) {
  const Intrinsics& K = camera.intrinsics;
  vtkNew<vtkPoints> points;
  const Eigen::Vector3d centre = camera.T_world_camera.translation();
  points->InsertNextPoint(centre.data());
  const float right = static_cast<float>(K.width - 1), bottom = static_cast<float>(K.height - 1);
  for (const Pixel& corner : {Pixel{0, 0}, Pixel{right, 0}, Pixel{right, bottom}, Pixel{0, bottom}}) {
    const Vec3 p = pointOnRay(unproject(K, corner), depth);
    const Eigen::Vector3d p_W = camera.T_world_camera * Eigen::Vector3f(p.x, p.y, p.z).cast<double>();
    points->InsertNextPoint(p_W.data());
  }
  vtkNew<vtkCellArray> lines;
  const auto line = [&](vtkIdType from, vtkIdType to) {
    const vtkIdType ends[2] = {from, to};
    lines->InsertNextCell(2, ends);
  };
  for (vtkIdType k = 1; k <= 4; ++k) {
    line(0, k);
    line(k, k % 4 + 1);
  }
  const auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetLines(lines);
  return data;
}

void Frusta::draw(const Camera& camera, std::size_t number) {
  const Rgb8 color = cameraColor(number);
  const double rgb[3] = {color.r / 255.0, color.g / 255.0, color.b / 255.0};
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(frustumLines(camera, kDepth));
  Drawn drawn{vtkSmartPointer<vtkActor>::New(), vtkSmartPointer<vtkBillboardTextActor3D>::New()};
  drawn.lines->SetMapper(mapper);
  drawn.lines->GetProperty()->SetColor(rgb[0], rgb[1], rgb[2]);
  drawn.lines->GetProperty()->SetLighting(false);
  drawn.lines->GetProperty()->SetLineWidth(2);
  const Eigen::Vector3d centre = camera.T_world_camera.translation();
  drawn.name->SetInput(camera.name.c_str());
  drawn.name->SetPosition(centre.x(), centre.y(), centre.z());
  drawn.name->SetDisplayOffset(kNameSize / 2, kNameSize / 2);
  drawn.name->GetTextProperty()->SetColor(rgb[0], rgb[1], rgb[2]);
  drawn.name->GetTextProperty()->SetFontSize(kNameSize);
  for (vtkProp* prop : {static_cast<vtkProp*>(drawn.lines), static_cast<vtkProp*>(drawn.name)}) {
    prop->PickableOff();
    prop->SetVisibility(visible_);
    for (std::size_t k = 0; k < kPanes; ++k) panes_.renderer(k)->AddViewProp(prop);
  }
  drawn_.push_back(std::move(drawn));
}

void Frusta::setCameras(const std::vector<Camera>& cameras) {
  if (same(cameras, cameras_)) return;
  for (const Drawn& drawn : drawn_)
    for (std::size_t k = 0; k < kPanes; ++k) {
      panes_.renderer(k)->RemoveViewProp(drawn.lines);
      panes_.renderer(k)->RemoveViewProp(drawn.name);
    }
  drawn_.clear();
  cameras_ = cameras;
  for (std::size_t number = 0; number < cameras.size(); ++number) draw(cameras[number], number);
}

void Frusta::setVisible(bool visible) {
  visible_ = visible;
  for (const Drawn& drawn : drawn_) {
    drawn.lines->SetVisibility(visible);
    drawn.name->SetVisibility(visible);
  }
}

}  // namespace fuse_flow::viewing
