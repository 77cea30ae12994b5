// Draws clouds side by side, from the same viewpoint, into a PNG.

#include "io/cloud_io.h"
#include "io/image_io.h"
#include "io/option_checks.h"
#include "io/tool.h"

#include <pcl/point_types.h>

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <cstdlib>

namespace {

using namespace fuse_flow;

struct Options {
  std::vector<std::string> clouds;
  std::string output;
  std::vector<double> from;
  std::vector<double> at;
  std::vector<double> up{0, 0, 1};
  std::vector<int> size{1600, 800};
  double zoom{1.0};
  float point_size{2.0f};
};

vtkSmartPointer<vtkPolyData> toPolyData(const pcl::PointCloud<pcl::PointXYZRGB>& cloud) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> vertices;
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  for (const pcl::PointXYZRGB& p : cloud) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) continue;
    const vtkIdType id = points->InsertNextPoint(p.x, p.y, p.z);
    vertices->InsertNextCell(1, &id);
    const unsigned char rgb[3] = {p.r, p.g, p.b};
    colors->InsertNextTypedTuple(rgb);
  }
  const auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetVerts(vertices);
  data->GetPointData()->SetScalars(colors);
  return data;
}

io::ColorImage toImage(vtkImageData* source) {
  io::ColorImage image;
  image.resize(source->GetDimensions()[0], source->GetDimensions()[1]);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const auto* rgb = static_cast<const unsigned char*>(source->GetScalarPointer(u, image.height - 1 - v, 0));
      image.at(u, v) = {rgb[0], rgb[1], rgb[2]};  // VTK keeps the bottom row first
    }
  return image;
}

int run(const Options& options) {
  std::vector<vtkSmartPointer<vtkPolyData>> clouds;
  for (const std::string& path : options.clouds) {
    pcl::PointCloud<pcl::PointXYZRGB> cloud;
    io::readCloud(path, cloud);
    clouds.push_back(toPolyData(cloud));
  }
  const char* display = std::getenv("DISPLAY");
  if (!display || !*display)  // VTK would abort
    throw io::InputError("DISPLAY is not set, must name a display: start it as 'xvfb-run -a fuse_flow_picture …'");
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetSize(options.size[0], options.size[1]);
  vtkNew<vtkCamera> camera;
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(clouds[k]);
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    actor->GetProperty()->SetPointSize(options.point_size);
    actor->GetProperty()->SetLighting(false);
    vtkNew<vtkRenderer> renderer;
    renderer->AddActor(actor);
    renderer->SetBackground(0.08, 0.09, 0.11);
    const double n = static_cast<double>(clouds.size());
    renderer->SetViewport(static_cast<double>(k) / n, 0, static_cast<double>(k + 1) / n, 1);
    renderer->SetActiveCamera(camera);
    window->AddRenderer(renderer);
    if (k > 0) continue;
    double b[6];
    clouds[0]->GetBounds(b);
    const double centre[3] = {(b[0] + b[1]) / 2, (b[2] + b[3]) / 2, (b[4] + b[5]) / 2};
    const double reach = std::max({b[1] - b[0], b[3] - b[2], b[5] - b[4]});
    const std::vector<double>& at = options.at;
    const std::vector<double>& from = options.from;
    camera->SetViewUp(options.up[0], options.up[1], options.up[2]);
    camera->SetFocalPoint(at.empty() ? centre[0] : at[0], at.empty() ? centre[1] : at[1],
                          at.empty() ? centre[2] : at[2]);
    camera->SetPosition(from.empty() ? centre[0] + reach : from[0], from.empty() ? centre[1] - reach : from[1],
                        from.empty() ? centre[2] + reach : from[2]);
    if (from.empty()) renderer->ResetCamera(b);
    camera->Zoom(options.zoom);
    renderer->ResetCameraClippingRange(b);
  }
  window->Render();
  vtkNew<vtkWindowToImageFilter> grab;
  grab->SetInput(window);
  grab->ReadFrontBufferOff();
  grab->Update();
  io::writeColorPng(options.output, toImage(grab->GetOutput()));
  return io::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Draws clouds side by side, from one viewpoint, into a PNG. Needs a display, or xvfb-run.",
               "fuse_flow_picture");
  app.add_option("cloud", options.clouds, "PLY or PCD files")->required();
  app.add_option("-o,--output", options.output, "PNG file")->required();
  app.add_option("--from", options.from, "where the viewer stands, m; default: outside the bounding box")
      ->expected(3)
      ->check(io::finiteNumber());
  app.add_option("--at", options.at, "what the viewer looks at, m; default: the middle of the first cloud")
      ->expected(3)
      ->check(io::finiteNumber());
  app.add_option("--up", options.up, "which way is up")->expected(3)->check(io::finiteNumber())->capture_default_str();
  app.add_option("--size", options.size, "width and height, pixels")
      ->expected(2)
      ->check(io::wholeNumber(1, 16384))
      ->capture_default_str();
  app.add_option("--zoom", options.zoom, "narrows the view")->check(io::positiveNumber())->capture_default_str();
  app.add_option("--point-size", options.point_size, "pixels")->check(io::positiveNumber())->capture_default_str();
  return io::runTool(app, argc, argv, [&] { return run(options); });
}
