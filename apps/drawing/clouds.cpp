#include "drawing/clouds.h"

#include "drawing/image_of.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fuse_flow::drawing {
namespace {

vtkSmartPointer<vtkPolyData> toPolyData(const ColoredPoints& cloud) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> vertices;
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  for (std::size_t k = 0; k < cloud.positions.size(); ++k) {
    const Eigen::Vector3f& p = cloud.positions[k];
    const vtkIdType id = points->InsertNextPoint(p.x(), p.y(), p.z());
    vertices->InsertNextCell(1, &id);
    const unsigned char rgb[3] = {cloud.colors[k].r, cloud.colors[k].g, cloud.colors[k].b};
    colors->InsertNextTypedTuple(rgb);
  }
  const auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetVerts(vertices);
  data->GetPointData()->SetScalars(colors);
  return data;
}

void place(vtkCamera* camera, vtkRenderer* renderer, vtkPolyData* first, const Viewpoint& viewpoint) {
  double b[6];
  first->GetBounds(b);
  const double centre[3] = {(b[0] + b[1]) / 2, (b[2] + b[3]) / 2, (b[4] + b[5]) / 2};
  const double reach = std::max({b[1] - b[0], b[3] - b[2], b[5] - b[4]});
  const std::vector<double>& at = viewpoint.at;
  const std::vector<double>& from = viewpoint.from;
  camera->SetViewUp(viewpoint.up[0], viewpoint.up[1], viewpoint.up[2]);
  camera->SetFocalPoint(at.empty() ? centre[0] : at[0], at.empty() ? centre[1] : at[1], at.empty() ? centre[2] : at[2]);
  camera->SetPosition(from.empty() ? centre[0] + reach : from[0], from.empty() ? centre[1] - reach : from[1],
                      from.empty() ? centre[2] + reach : from[2]);
  if (from.empty()) renderer->ResetCamera(b);
  camera->Zoom(viewpoint.zoom);
  renderer->ResetCameraClippingRange(b);
}

}  // namespace

io::ColorImage drawClouds(const std::vector<ColoredPoints>& clouds, const Viewpoint& viewpoint) {
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetSize(viewpoint.width, viewpoint.height);
  vtkNew<vtkCamera> camera;
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    const vtkSmartPointer<vtkPolyData> data = toPolyData(clouds[k]);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(data);
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    actor->GetProperty()->SetPointSize(viewpoint.point_size);
    actor->GetProperty()->SetLighting(false);
    vtkNew<vtkRenderer> renderer;
    renderer->AddActor(actor);
    renderer->SetBackground(0.08, 0.09, 0.11);
    const double n = static_cast<double>(clouds.size());
    renderer->SetViewport(static_cast<double>(k) / n, 0, static_cast<double>(k + 1) / n, 1);
    renderer->SetActiveCamera(camera);
    window->AddRenderer(renderer);
    if (k == 0) place(camera, renderer, data, viewpoint);
  }
  window->Render();
  return imageOf(window);
}

Rgb8 errorColor(float distance, float limit) {
  constexpr std::array<std::array<float, 3>, 4> scale = {
      {{40, 90, 200}, {40, 180, 120}, {240, 210, 60}, {220, 40, 40}}};
  const float at = 3.0f * std::clamp(distance / limit, 0.0f, 1.0f);
  const std::size_t k = std::min<std::size_t>(2, static_cast<std::size_t>(at));
  const float t = at - static_cast<float>(k);
  const auto channel = [&](std::size_t c) {
    return static_cast<std::uint8_t>(std::lround((1 - t) * scale[k][c] + t * scale[k + 1][c]));
  };
  return {channel(0), channel(1), channel(2)};
}

}  // namespace fuse_flow::drawing
