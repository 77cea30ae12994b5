#include "simulation/surfaces/shapes.h"

#include "simulation/pi.h"
#include "simulation/portable_math.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kChord = 1e-4f;  // metres between a chord and its arc

/** \brief Pieces of a full circle: radius · (1 − cos(π / n)) ≤ kChord. */
int piecesOfCircle(float radius) {
  const float half_angle = portable::acos(std::max(0.0f, 1 - kChord / std::max(radius, kChord)));
  return std::clamp(static_cast<int>(std::ceil(kPiF / half_angle)), 12, 160);
}

std::uint32_t addVertex(TriangleMesh& mesh, const Vector3f& p, const Vector3f& normal) {
  mesh.vertices.push_back(p);
  mesh.normals.push_back(normal);
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

/** \brief Triangles without the degenerate ones of a row that is a point. */
void addTriangle(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const auto& v = mesh.vertices;
  if (v[a] != v[b] && v[b] != v[c] && v[c] != v[a]) mesh.triangles.push_back({a, b, c});
}

/** \brief Between two rows of n vertices, each a ring; the second is further along, and rings turn counter-clockwise seen
 *  from there. */
void joinRings(TriangleMesh& mesh, std::uint32_t first, std::uint32_t second, std::uint32_t n) {
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t next = (k + 1) % n;
    addTriangle(mesh, first + k, first + next, second + next);
    addTriangle(mesh, first + k, second + next, second + k);
  }
}

/** \brief Unit tangents of a piece of a profile; of second order at its ends too. */
std::vector<Vector2f> tangents(const std::vector<Vector2f>& piece) {
  const std::size_t n = piece.size();
  std::vector<Vector2f> result;
  for (std::size_t k = 0; k < n; ++k) {
    Vector2f t;
    if (n == 2)
      t = piece[1] - piece[0];
    else if (k == 0)
      t = -3 * piece[0] + 4 * piece[1] - piece[2];
    else if (k == n - 1)
      t = 3 * piece[n - 1] - 4 * piece[n - 2] + piece[n - 3];
    else
      t = piece[k + 1] - piece[k - 1];
    // A smooth piece meets the axis at a right angle.
    if (n > 2 && piece[k].x() == 0) t.y() = 0;
    result.push_back(t.normalized());
  }
  return result;
}

/** \brief A flat disc that ends a tube; normal along its axis. */
void addCap(TriangleMesh& mesh, const std::vector<Vector3f>& ring, const Vector3f& centre, const Vector3f& normal,
            bool reversed) {
  const std::uint32_t middle = addVertex(mesh, centre, normal);
  for (const Vector3f& p : ring) addVertex(mesh, p, normal);
  const auto n = static_cast<std::uint32_t>(ring.size());
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t a = middle + 1 + k, b = middle + 1 + (k + 1) % n;
    addTriangle(mesh, middle, reversed ? b : a, reversed ? a : b);
  }
}

std::vector<Vector3f> ringAround(const Vector3f& centre, const Vector3f& u, const Vector3f& v, float radius, int n) {
  std::vector<Vector3f> ring;
  for (int k = 0; k < n; ++k) {
    const float angle = 2 * kPiF * static_cast<float>(k) / static_cast<float>(n);
    ring.push_back(centre + radius * (portable::cos(angle) * u + portable::sin(angle) * v));
  }
  return ring;
}

}  // namespace

TriangleMesh box(const Vector3f& size) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      const Vector3f normal = side * Vector3f::Unit(axis);
      const Vector3f u = Vector3f::Unit((axis + 1) % 3), v = side * Vector3f::Unit((axis + 2) % 3);
      std::uint32_t corner[4];
      const float at[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
      for (int k = 0; k < 4; ++k)
        corner[k] = addVertex(mesh, 0.5f * size.cwiseProduct(normal + at[k][0] * u + at[k][1] * v), normal);
      addTriangle(mesh, corner[0], corner[1], corner[2]);
      addTriangle(mesh, corner[0], corner[2], corner[3]);
    }
  }
  return mesh;
}

TriangleMesh roundedBox(const Vector3f& size, float radius) {
  // A sphere made of the six sides of a cube, cut at its three great circles, the octants moved to the corners.
  const int steps = std::max(2, piecesOfCircle(radius) / 8);
  std::vector<double> slopes;
  std::vector<int> sides;
  for (int k = -steps; k <= steps; ++k)
    for (int side = k <= 0 ? -1 : 1; side <= (k >= 0 ? 1 : -1); side += 2) {
      slopes.push_back(std::abs(k) == steps ? (k < 0 ? -1.0 : 1.0)
                                            : portable::tan(0.25 * static_cast<double>(kPiF) * k / steps));
      sides.push_back(side);
    }
  const Vector3d core = (0.5f * size - Vector3f::Constant(radius)).cast<double>();
  const auto n = static_cast<std::uint32_t>(slopes.size());
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (std::uint32_t j = 0; j < n; ++j) {
        for (std::uint32_t i = 0; i < n; ++i) {
          Vector3d d, corner;
          d[axis] = corner[axis] = side;
          d[(axis + 1) % 3] = slopes[i];
          d[(axis + 2) % 3] = slopes[j];
          corner[(axis + 1) % 3] = sides[i];
          corner[(axis + 2) % 3] = sides[j];
          const Vector3d normal = d.normalized();
          addVertex(mesh, (core.cwiseProduct(corner) + static_cast<double>(radius) * normal).cast<float>(),
                    normal.cast<float>());
        }
      }
      for (std::uint32_t j = 0; j + 1 < n; ++j) {
        for (std::uint32_t i = 0; i + 1 < n; ++i) {
          const std::uint32_t a = first + j * n + i, b = a + 1, c = b + n, e = a + n;
          addTriangle(mesh, a, side > 0 ? b : c, side > 0 ? c : b);
          addTriangle(mesh, a, side > 0 ? c : e, side > 0 ? e : c);
        }
      }
    }
  }
  return mesh;
}

std::vector<Vector2f> arc(const Vector2f& centre, float radius, float from, float to) {
  const int n = std::max(
      4, static_cast<int>(std::ceil(static_cast<float>(piecesOfCircle(radius)) * std::fabs(to - from) / (2 * kPiF))));
  std::vector<Vector2f> points;
  for (int k = 0; k <= n; ++k) {
    const float angle = from + (to - from) * static_cast<float>(k) / static_cast<float>(n);
    Vector2f p = centre + radius * Vector2f(portable::cos(angle), portable::sin(angle));
    if (p.x() < 1e-6f) p.x() = 0;
    points.push_back(p);
  }
  return points;
}

TriangleMesh lathe(const Profile& profile) {
  float widest = 0;
  for (const auto& piece : profile)
    for (const Vector2f& p : piece) widest = std::max(widest, p.x());
  const int n = piecesOfCircle(widest);
  TriangleMesh mesh;
  for (const auto& piece : profile) {
    const std::vector<Vector2f> along = tangents(piece);
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const auto row = static_cast<std::uint32_t>(mesh.vertices.size());
      for (int j = 0; j < n; ++j) {
        const float angle = 2 * kPiF * static_cast<float>(j) / static_cast<float>(n);
        const float c = portable::cos(angle), s = portable::sin(angle);
        addVertex(mesh, {piece[k].x() * c, piece[k].x() * s, piece[k].y()},
                  {along[k].y() * c, along[k].y() * s, -along[k].x()});
      }
      if (k > 0) joinRings(mesh, row - static_cast<std::uint32_t>(n), row, static_cast<std::uint32_t>(n));
    }
  }
  return mesh;
}

TriangleMesh sphere(float radius) { return lathe({arc({0, 0}, radius, -kPiF / 2, kPiF / 2)}); }

TriangleMesh ellipsoid(const Vector3f& half_axes) {
  const float longest = half_axes.maxCoeff();
  return bent(sphere(longest), [&](const Vector3f& p) -> Vector3f { return p.cwiseProduct(half_axes) / longest; });
}

TriangleMesh cylinder(float bottom_radius, float top_radius, float height) {
  Profile profile = {{{0, 0}, {bottom_radius, 0}}, {{bottom_radius, 0}, {top_radius, height}}};
  if (top_radius > 0) profile.push_back({{top_radius, height}, {0, height}});
  return lathe(profile);
}

TriangleMesh tube(const std::vector<Vector3f>& path, float radius) {
  const int n = piecesOfCircle(radius);
  TriangleMesh mesh;
  Vector3f u = (path[1] - path[0]).normalized().unitOrthogonal();
  for (std::size_t k = 0; k < path.size(); ++k) {
    const std::size_t before = k > 0 ? k - 1 : 0, after = std::min(k + 1, path.size() - 1);
    const Vector3f along = (path[after] - path[before]).normalized();
    u = (u - u.dot(along) * along).normalized();  // carried along without a twist
    const std::vector<Vector3f> ring = ringAround(path[k], u, along.cross(u), radius, n);
    if (k == 0) addCap(mesh, ring, path[k], -along, true);
    const auto row = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vector3f& p : ring) addVertex(mesh, p, (p - path[k]).normalized());
    if (k > 0) joinRings(mesh, row - static_cast<std::uint32_t>(n), row, static_cast<std::uint32_t>(n));
    if (k + 1 == path.size()) addCap(mesh, ring, path[k], along, false);
  }
  return mesh;
}

TriangleMesh rod(const Vector3f& from, const Vector3f& to, float radius) { return tube({from, to}, radius); }

TriangleMesh torus(float ring_radius, float tube_radius) {
  const int n = piecesOfCircle(ring_radius + tube_radius), m = piecesOfCircle(tube_radius);
  TriangleMesh mesh;
  for (int k = 0; k < n; ++k) {
    const float angle = 2 * kPiF * static_cast<float>(k) / static_cast<float>(n);
    const Vector3f out(portable::cos(angle), portable::sin(angle), 0);
    for (const Vector3f& p : ringAround(ring_radius * out, out, -Vector3f::UnitZ(), tube_radius, m))
      addVertex(mesh, p, (p - ring_radius * out).normalized());
  }
  for (int k = 0; k < n; ++k)
    joinRings(mesh, static_cast<std::uint32_t>(k * m), static_cast<std::uint32_t>((k + 1) % n * m),
              static_cast<std::uint32_t>(m));
  return mesh;
}

TriangleMesh extrude(const std::vector<Vector2f>& polygon, float height) {
  TriangleMesh mesh;
  std::vector<Vector3f> low, high;
  for (const Vector2f& p : polygon) {
    low.emplace_back(p.x(), p.y(), 0.0f);
    high.emplace_back(p.x(), p.y(), height);
  }
  addCap(mesh, low, Vector3f::Zero(), -Vector3f::UnitZ(), true);
  addCap(mesh, high, height * Vector3f::UnitZ(), Vector3f::UnitZ(), false);
  for (std::size_t k = 0; k < low.size(); ++k) {
    const std::size_t next = (k + 1) % low.size();
    const Vector3f normal = (low[next] - low[k]).cross(Vector3f::UnitZ()).normalized();
    const std::uint32_t a = addVertex(mesh, low[k], normal), b = addVertex(mesh, low[next], normal);
    const std::uint32_t c = addVertex(mesh, high[next], normal), d = addVertex(mesh, high[k], normal);
    addTriangle(mesh, a, b, c);
    addTriangle(mesh, a, c, d);
  }
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const Eigen::Isometry3f& T) {
  for (Vector3f& v : mesh.vertices) v = T * v;
  for (Vector3f& n : mesh.normals) n = T.linear() * n;
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const Vector3f& by) {
  for (Vector3f& v : mesh.vertices) v += by;
  return mesh;
}

TriangleMesh bent(TriangleMesh mesh, const std::function<Vector3f(const Vector3f&)>& map) {
  constexpr float step = 1e-3f;
  for (std::size_t k = 0; k < mesh.vertices.size(); ++k) {
    const Vector3f p = mesh.vertices[k], u = mesh.normals[k].unitOrthogonal(), v = mesh.normals[k].cross(u);
    const Vector3f along_u = map(p + step * u) - map(p - step * u), along_v = map(p + step * v) - map(p - step * v);
    mesh.normals[k] = along_u.cross(along_v).normalized();
    mesh.vertices[k] = map(p);
  }
  return mesh;
}

void append(TriangleMesh& mesh, const TriangleMesh& more) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  mesh.normals.insert(mesh.normals.end(), more.normals.begin(), more.normals.end());
  mesh.rest.insert(mesh.rest.end(), more.rest.begin(), more.rest.end());
  for (const auto& t : more.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

Eigen::Isometry3f placed(const Vector3f& at, float angle) {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.translate(at);
  T.rotate(portable::turn(angle, Vector3f::UnitZ()));
  return T;
}

}  // namespace fuse_flow::simulation
