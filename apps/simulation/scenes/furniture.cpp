#include "simulation/scenes/furniture.h"

#include "simulation/pi.h"
#include "simulation/portable_math.h"
#include "simulation/random.h"
#include "simulation/surfaces/shapes.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

const Material kOak{Material::Wood, {196, 152, 98}, {120, 78, 40}, 0.02f, 0.7f};
const Material kDarkWood{Material::Wood, {126, 76, 44}, {72, 40, 24}, 0.02f, 0.5f};

/** \brief A rectangle whose normal is u × v. */
TriangleMesh rectangle(const Vector3f& corner, const Vector3f& u, const Vector3f& v) {
  TriangleMesh mesh;
  mesh.vertices = {corner, corner + u, corner + u + v, corner + v};
  mesh.normals.assign(4, u.cross(v).normalized());
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

void add(Objects& objects, const std::string& name, const TriangleMesh& mesh, const Material& material,
         const Place& place, float z = 0) {
  Object object{name, moved(mesh, place.pose(z)), material, "furniture"};
  object.mesh.rest = moved(mesh, z * Vector3f::UnitZ()).vertices;  // the texture turns with the thing
  objects.push_back(std::move(object));
}

TriangleMesh boxAt(const Vector3f& centre, const Vector3f& size) { return moved(box(size), centre); }

float between(Random& random, float low, float high) {
  return low + (high - low) * static_cast<float>(random.uniform());
}

Material bookCover(Random& random) {
  constexpr Rgb8 colors[] = {{168, 44, 40},   {38, 70, 132}, {52, 112, 66}, {214, 176, 70},
                             {226, 220, 206}, {60, 56, 62},  {146, 84, 140}};
  const auto color = static_cast<std::size_t>(7 * random.uniform());
  const bool striped = random.uniform() < 0.4;
  return {striped ? Material::Stripes : Material::Plain, colors[color], colors[(color + 3) % 7], 0.06f,
          color == 5 ? 0.2f : 0.7f};
}

/** \brief A row of books from left to right on a board. */
void addBooks(Objects& objects, const Place& place, float left, float right, float board, Random& random) {
  for (int number = 0;; ++number) {
    const Vector3f size(between(random, 0.018f, 0.055f), between(random, 0.13f, 0.2f), between(random, 0.17f, 0.27f));
    if (left + size.x() > right) return;
    const Vector3f centre(left + 0.5f * size.x(), -0.13f + 0.5f * size.y(), board + 0.5f * size.z());
    add(objects, "book", boxAt(centre, size), bookCover(random), place);
    left += size.x() + (random.uniform() < 0.12 ? 0.06f : 0.0015f);
  }
}

/** \brief A closed blade from the origin along x, bending down towards its tip; thickest in the middle, sharp at its rim. */
TriangleMesh leaf(float length, float width, float thickness, float droop) {
  const float half = 0.5f * length;
  std::vector<Vector2f> below, above;
  constexpr int steps = 10;
  for (int k = 0; k <= steps; ++k) {
    const float r = static_cast<float>(k) / steps;
    below.emplace_back(half * r, -0.5f * thickness * (1 - r * r));
    above.emplace_back(half * (1 - r), 0.5f * thickness * (1 - (1 - r) * (1 - r)));
  }
  return bent(lathe({below, above}), [=](const Vector3f& p) -> Vector3f {
    const float along = p.x() / length + 0.5f, y = p.y() * width / length;
    return {length * along, y, p.z() - droop * along * along + 1.2f * y * y / width};
  });
}

}  // namespace

Eigen::Isometry3f Place::pose(float z) const { return placed({x, y, z}, angle); }

void addRoom(Objects& objects, const Eigen::AlignedBox3f& room) {
  const Vector3f a = room.min(), s = room.sizes();
  const Vector3f x = s.x() * Vector3f::UnitX(), y = s.y() * Vector3f::UnitY(), z = s.z() * Vector3f::UnitZ();
  objects.push_back({"floor", rectangle(a, x, y), {Material::Wood, {206, 168, 120}, {150, 106, 66}, 0.05f, 0.6f}});
  objects.push_back({"ceiling", rectangle(a + z, y, x), {Material::Plain, {238, 238, 232}, {}, 0.1f, 0.8f}, "wall"});
  const Material paper{Material::Noise, {222, 214, 196}, {190, 186, 170}, 0.12f, 0.75f};
  const Material striped{Material::Stripes, {206, 214, 218}, {168, 186, 196}, 0.16f, 0.75f};
  objects.push_back({"wall", rectangle(a, z, x), paper});
  objects.push_back({"wall", rectangle(a + x, z, y), striped});
  objects.push_back({"wall", rectangle(a + x + y, z, -x), paper});
  objects.push_back(
      {"wall", rectangle(a + y, z, -y), {Material::Noise, {196, 208, 190}, {160, 176, 156}, 0.2f, 0.75f}});
}

void addTable(Objects& objects, const Place& place, const Vector2f& size) {
  constexpr float board = 0.03f;
  const TriangleMesh top = roundedBox({size.x(), size.y(), board}, 0.008f);
  add(objects, "table top", moved(top, (kTableHeight - 0.5f * board) * Vector3f::UnitZ()), kOak, place);
  TriangleMesh legs;
  const float height = kTableHeight - board, apron = 0.07f;
  for (const float i : {-1.0f, 1.0f})
    for (const float j : {-1.0f, 1.0f})
      append(legs, boxAt({i * (0.5f * size.x() - 0.06f), j * (0.5f * size.y() - 0.06f), 0.5f * height},
                         {0.05f, 0.05f, height}));
  for (const float i : {-1.0f, 1.0f}) {
    append(legs, boxAt({i * (0.5f * size.x() - 0.06f), 0, height - 0.5f * apron}, {0.02f, size.y() - 0.17f, apron}));
    append(legs, boxAt({0, i * (0.5f * size.y() - 0.06f), height - 0.5f * apron}, {size.x() - 0.17f, 0.02f, apron}));
  }
  add(objects, "table legs", legs, kDarkWood, place);
}

void addChair(Objects& objects, const Place& place) {
  constexpr float seat = 0.45f, half = 0.19f, low = 0.0015f;  // legs lean: their ends' rims reach below their middles
  TriangleMesh frame;
  for (const float side : {-1.0f, 1.0f}) {
    append(frame, rod({side * (half + 0.01f), half + 0.01f, low}, {side * half, half, seat}, 0.016f));
    append(frame, rod({side * (half + 0.01f), -half - 0.03f, low}, {side * half, -half, seat}, 0.016f));
    append(frame, rod({side * half, -half, seat}, {side * (half - 0.01f), -half - 0.09f, 0.92f}, 0.014f));
    append(frame, rod({side * (half + 0.006f), half, 0.2f}, {side * (half + 0.006f), -half - 0.016f, 0.2f}, 0.009f));
  }
  append(frame, rod({-half + 0.01f, -half - 0.09f, 0.9f}, {half - 0.01f, -half - 0.09f, 0.9f}, 0.014f));
  for (int k = -2; k <= 2; ++k) {
    const float x = 0.065f * static_cast<float>(k);
    append(frame, rod({x, -half, seat}, {x, -half - 0.09f, 0.9f}, 0.006f));
  }
  add(objects, "chair frame", frame, kDarkWood, place);
  add(objects, "chair seat", moved(roundedBox({0.43f, 0.43f, 0.04f}, 0.015f), {0, 0, seat}),
      {Material::Checker, {176, 60, 52}, {222, 204, 178}, 0.045f, 0.6f}, place);
}

void addShelf(Objects& objects, const Place& place, float width, std::uint32_t seed) {
  constexpr float depth = 0.3f, height = 1.0f, board = 0.02f;
  TriangleMesh frame;
  for (const float side : {-1.0f, 1.0f})
    append(frame, boxAt({side * 0.5f * (width - board), 0, 0.5f * height}, {board, depth, height}));
  append(frame, boxAt({0, -0.5f * depth + 0.004f, 0.5f * height}, {width - 2 * board, 0.008f, height}));
  const float boards[] = {0.06f, 0.37f, 0.68f, 0.99f};
  for (const float top : boards) append(frame, boxAt({0, 0, top - 0.5f * board}, {width - 2 * board, depth, board}));
  add(objects, "shelf", frame, kOak, place);
  Random random(seed, 0, 0, 11);
  for (int k = 0; k < 3; ++k)
    addBooks(objects, place, -0.5f * width + board + 0.01f, 0.5f * width - board - between(random, 0.02f, 0.2f),
             boards[k], random);
}

void addSofa(Objects& objects, const Place& place) {
  const Material cloth{Material::Noise, {70, 104, 138}, {42, 62, 92}, 0.05f, 0.5f};
  const auto part = [&](const Vector3f& centre, const Vector3f& size, float radius) {
    add(objects, "sofa", moved(roundedBox(size, radius), centre), cloth, place);
  };
  part({0, 0, 0.17f}, {1.8f, 0.8f, 0.3f}, 0.03f);
  part({0, -0.3f, 0.5f}, {1.8f, 0.2f, 0.6f}, 0.07f);
  for (const float side : {-1.0f, 1.0f}) {
    part({side * 0.81f, 0.02f, 0.36f}, {0.18f, 0.76f, 0.5f}, 0.07f);
    part({side * 0.36f, 0.1f, 0.38f}, {0.71f, 0.6f, 0.14f}, 0.05f);
  }
  const Eigen::Quaternionf lean = portable::turn(0.35f, Vector3f::UnitX());
  for (const float side : {-1.0f, 1.0f}) {
    Eigen::Isometry3f T = placed({side * 0.5f, -0.08f, 0.6f}, 0.2f * side);
    T.rotate(lean);
    add(objects, "cushion", moved(ellipsoid({0.2f, 0.075f, 0.18f}), T),
        {Material::Checker, {212, 170, 64}, {236, 226, 200}, 0.06f, 0.7f}, place);
  }
}

void addFloorLamp(Objects& objects, const Place& place) {
  add(objects, "lamp foot",
      lathe({{{0, 0}, {0.14f, 0}},
             {{0.14f, 0}, {0.14f, 0.015f}},
             {{0.14f, 0.015f}, {0.012f, 0.03f}},
             {{0.012f, 0.03f}, {0.012f, 1.6f}},
             {{0.012f, 1.6f}, {0, 1.6f}}}),
      {Material::Plain, {70, 70, 74}, {}, 0.1f, 0.4f}, place);
  // A shell 4 mm thick, open below and above.
  add(objects, "lamp shade",
      lathe({{{0.2f, 1.45f}, {0.14f, 1.7f}},
             {{0.14f, 1.7f}, {0.136f, 1.7f}},
             {{0.136f, 1.7f}, {0.196f, 1.45f}},
             {{0.196f, 1.45f}, {0.2f, 1.45f}}}),
      {Material::Stripes, {240, 224, 184}, {222, 196, 140}, 0.05f, 0.8f}, place);
  add(objects, "lamp bulb", moved(sphere(0.04f), {0, 0, 1.62f}), {Material::Plain, {250, 246, 226}, {}, 0.1f, 0.8f},
      place);
}

void addPlant(Objects& objects, const Place& place, float standing_on, float height, std::uint32_t seed) {
  const float r = std::min(0.15f, 0.22f * height), pot = 0.3f * height;
  add(objects, "pot",
      lathe({{{0, 0}, {0.7f * r, 0}},
             {{0.7f * r, 0}, {r, pot}},
             {{r, pot}, {0.9f * r, pot}},
             {{0.9f * r, pot}, {0.88f * r, 0.9f * pot}},
             {{0.88f * r, 0.9f * pot}, {0, 0.9f * pot}}}),
      {Material::Noise, {188, 98, 64}, {150, 70, 46}, 0.03f, 0.7f}, place, standing_on);
  Random random(seed, 0, 0, 12);
  TriangleMesh stems, leaves;
  constexpr int count = 9;
  for (int k = 0; k < count; ++k) {
    const float turn = 2 * kPiF * (static_cast<float>(k) + between(random, -0.3f, 0.3f)) / count;
    const float top = height * between(random, 0.6f, 0.95f), lean = height * between(random, 0.06f, 0.2f);
    std::vector<Vector3f> path;
    for (int i = 0; i <= 12; ++i) {
      const float t = static_cast<float>(i) / 12;
      path.push_back(placed(Vector3f::Zero(), turn) *
                     Vector3f(0.2f * r + lean * t * t, 0, 0.85f * pot + (top - 0.85f * pot) * t));
    }
    append(stems, tube(path, 0.0025f + 0.002f * height));
    const float length = height * between(random, 0.22f, 0.34f);
    Eigen::Isometry3f T = placed(path.back(), turn + between(random, -0.4f, 0.4f));
    T.rotate(portable::turn(-between(random, 0.1f, 0.9f), Vector3f::UnitY()));
    append(
        leaves,
        moved(leaf(length, length * between(random, 0.3f, 0.45f), between(random, 0.0015f, 0.003f), 0.3f * length), T));
  }
  add(objects, "stems", stems, {Material::Plain, {88, 122, 52}, {}, 0.1f, 0.7f}, place, standing_on);
  add(objects, "leaves", leaves, {Material::Noise, {72, 140, 58}, {34, 92, 40}, 0.02f, 0.8f}, place, standing_on);
}

}  // namespace fuse_flow::simulation
