#include "viewer/world/point_data.h"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fuse_flow::viewing {

vtkSmartPointer<vtkPolyData> toPolyData(const Cloud& cloud, const std::vector<Rgb8>& colors,
                                        const std::vector<std::size_t>& numbers) {
  const auto count = static_cast<vtkIdType>(numbers.size());
  vtkNew<vtkFloatArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  float* position = coordinates->WritePointer(0, 3 * count);
  vtkNew<vtkUnsignedCharArray> scalars;
  scalars->SetNumberOfComponents(3);
  unsigned char* color = scalars->WritePointer(0, 3 * count);
  for (const std::size_t k : numbers) {
    for (const float x : {cloud[k].x, cloud[k].y, cloud[k].z}) *position++ = x;
    for (const std::uint8_t c : {colors[k].r, colors[k].g, colors[k].b}) *color++ = c;
  }
  // One cell that holds all points: a cell a point would take as long to build as the rest.
  vtkNew<vtkIdTypeArray> offsets, cell;
  offsets->InsertNextValue(0);
  if (count > 0) offsets->InsertNextValue(count);
  vtkIdType* number = cell->WritePointer(0, count);
  std::iota(number, number + count, vtkIdType{0});
  vtkNew<vtkCellArray> vertices;
  vertices->SetData(offsets, cell);
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);
  const auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetVerts(vertices);
  data->GetPointData()->SetScalars(scalars);
  data->ComputeBounds();  // here, not on the thread that draws
  return data;
}

std::vector<vtkSmartPointer<vtkPolyData>> slicesOf(const Cloud& cloud, const std::vector<Rgb8>& colors,
                                                   std::size_t points) {
  std::size_t count = std::clamp<std::size_t>((cloud.size() + points - 1) / points, 1, kMaxSlices);
  if (count % 2 == 0) ++count;  // an image has an even number of columns: no slice shall be a few of them
  // Each slice begins far from those before it, by the golden ratio, so that any number of them is evenly spread.
  auto step = static_cast<std::size_t>(std::lround(0.618 * static_cast<double>(count)));
  while (std::gcd(step, count) != 1) ++step;
  const std::size_t thin = thinSlices(count);
  std::vector<bool> is_thin(count, false);  // by the point's number modulo count
  std::vector<vtkSmartPointer<vtkPolyData>> slices;
  std::vector<std::size_t> numbers;
  const auto finish = [&] {
    slices.push_back(toPolyData(cloud, colors, numbers));
    numbers.clear();
  };
  for (std::size_t slice = 0; slice < thin; ++slice) {
    const std::size_t first = slice * step % count;
    is_thin[first] = true;
    for (std::size_t k = first; k < cloud.size(); k += count) numbers.push_back(k);
    finish();
  }
  for (std::size_t slice = thin, k = 0; slice < count; ++slice) {
    const std::size_t end = cloud.size() * (slice - thin + 1) / (count - thin);
    for (; k < end; ++k)
      if (!is_thin[k % count]) numbers.push_back(k);
    finish();
  }
  return slices;
}

}  // namespace fuse_flow::viewing
