#include "simulation/surfaces/implicit_surface.h"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3d;

Vector3d gradient(const ImplicitBody& body, const Vector3d& p) {
  constexpr double step = 1e-5;
  Vector3d g;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d by = step * Vector3d::Unit(axis);
    g[axis] = (body(p + by) - body(p - by)) / (2 * step);
  }
  return g;
}

/** \brief The nearest point of the surface, by Newton's steps along the gradient. */
Vector3d onSurface(const ImplicitBody& body, Vector3d p, int steps) {
  for (int k = 0; k < steps; ++k) {
    const double f = body(p);
    if (std::fabs(f) < 1e-9) break;
    const Vector3d g = gradient(body, p);
    p -= f / std::max(g.squaredNorm(), 1e-3) * g;
  }
  return p;
}

struct Polygons {
  std::vector<Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/** \brief The body at the points of a grid. In cubes of points that no surface can pass, one value stands for all. */
void sample(const ImplicitBody& body, const Eigen::AlignedBox3d& bounds, double voxel, const Eigen::Vector3i& size,
            float* values) {
  constexpr int side = 4;
  constexpr double steepest = 2;  // change of a body's value per metre
  const double reach = steepest * voxel * std::sqrt(3.0) * 0.5 * (side - 1);
  const auto at = [&](double i, double j, double k) { return body(bounds.min() + voxel * Vector3d(i, j, k)); };
  const auto value = [&](int i, int j, int k) -> float& {
    return values[(static_cast<std::ptrdiff_t>(k) * size.y() + j) * size.x() + i];
  };
  for (int k0 = 0; k0 < size.z(); k0 += side)
    for (int j0 = 0; j0 < size.y(); j0 += side)
      for (int i0 = 0; i0 < size.x(); i0 += side) {
        constexpr double middle = 0.5 * (side - 1);
        const double here = at(i0 + middle, j0 + middle, k0 + middle);
        const bool far = std::fabs(here) > reach;
        for (int k = k0; k < std::min(k0 + side, size.z()); ++k)
          for (int j = j0; j < std::min(j0 + side, size.y()); ++j)
            for (int i = i0; i < std::min(i0 + side, size.x()); ++i)
              value(i, j, k) = static_cast<float>(far ? here : at(i, j, k));
      }
}

Polygons flyingEdges(const ImplicitBody& body, const Eigen::AlignedBox3d& bounds, double voxel) {
  const Eigen::Vector3i size = (bounds.sizes() / voxel).array().ceil().cast<int>() + 1;
  vtkNew<vtkImageData> grid;
  grid->SetDimensions(size.x(), size.y(), size.z());
  grid->SetOrigin(bounds.min().x(), bounds.min().y(), bounds.min().z());
  grid->SetSpacing(voxel, voxel, voxel);
  vtkNew<vtkFloatArray> values;
  values->SetNumberOfTuples(grid->GetNumberOfPoints());
  sample(body, bounds, voxel, size, values->GetPointer(0));
  grid->GetPointData()->SetScalars(values);
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(grid);
  contour->SetValue(0, 0.0);
  contour->ComputeNormalsOff();
  contour->ComputeGradientsOff();
  contour->ComputeScalarsOff();
  contour->Update();
  vtkPolyData* surface = contour->GetOutput();
  Polygons polygons;
  for (vtkIdType k = 0; k < surface->GetNumberOfPoints(); ++k) polygons.vertices.emplace_back(surface->GetPoint(k));
  vtkNew<vtkIdList> corners;
  vtkCellArray* cells = surface->GetPolys();
  for (cells->InitTraversal(); cells->GetNextCell(corners) != 0;)
    polygons.triangles.push_back({static_cast<std::uint32_t>(corners->GetId(0)),
                                  static_cast<std::uint32_t>(corners->GetId(1)),
                                  static_cast<std::uint32_t>(corners->GetId(2))});
  return polygons;
}

/** \brief Moves every vertex towards the mean of its neighbours and back onto the surface: slivers become triangles. */
void relax(const ImplicitBody& body, Polygons& polygons) {
  std::vector<Vector3d> sum(polygons.vertices.size(), Vector3d::Zero());
  std::vector<double> count(polygons.vertices.size(), 0);
  for (const auto& t : polygons.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum[t[k]] += polygons.vertices[t[(k + 1) % 3]] + polygons.vertices[t[(k + 2) % 3]];
      count[t[k]] += 2;
    }
  }
  for (std::size_t k = 0; k < sum.size(); ++k) {
    Vector3d& p = polygons.vertices[k];
    p = onSurface(body, p + 0.6 * (sum[k] / std::max(count[k], 1.0) - p), 2);
  }
}

}  // namespace

Vector3d gradientDirection(const ImplicitBody& body, const Vector3d& p) { return gradient(body, p).normalized(); }

TriangleMesh polygonise(const ImplicitBody& body, const Eigen::AlignedBox3d& bounds, double voxel) {
  Polygons polygons = flyingEdges(body, bounds, voxel);
  for (int k = 0; k < 4; ++k) relax(body, polygons);
  for (Vector3d& p : polygons.vertices) p = onSurface(body, p, 8);
  TriangleMesh mesh;
  for (const Vector3d& p : polygons.vertices) {
    mesh.vertices.push_back(p.cast<float>());
    mesh.normals.push_back(gradientDirection(body, p).cast<float>());
  }
  double outward = 0;  // which way round VTK turns its triangles
  for (const auto& t : polygons.triangles) {
    const Vector3d a = polygons.vertices[t[0]];
    outward += (polygons.vertices[t[1]] - a).cross(polygons.vertices[t[2]] - a).dot(mesh.normals[t[0]].cast<double>());
  }
  for (auto& t : polygons.triangles) {
    if (outward < 0) std::swap(t[1], t[2]);
    mesh.triangles.push_back(t);
  }
  return mesh;
}

double capsuleDistance(const Vector3d& p, const Vector3d& a, const Vector3d& b, double radius_a, double radius_b) {
  const Vector3d ab = b - a;
  const double along = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (p - a - along * ab).norm() - (radius_a + along * (radius_b - radius_a));
}

double ellipsoidDistance(const Vector3d& p, const Vector3d& centre, const Vector3d& half_axes) {
  const Vector3d q = (p - centre).cwiseQuotient(half_axes);
  const double slope = q.cwiseQuotient(half_axes).norm();
  return slope > 1e-9 ? q.norm() * (q.norm() - 1) / slope : -half_axes.minCoeff();
}

double smoothUnion(double a, double b, double blend) {
  const double h = std::max(blend - std::fabs(a - b), 0.0) / blend;
  return std::min(a, b) - 0.25 * h * h * blend;
}

}  // namespace fuse_flow::simulation
