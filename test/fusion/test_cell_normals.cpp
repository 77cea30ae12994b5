#include "../scenes.h"

#include <fuse_flow/impl/fusion/cell_normals.hpp>

namespace {

using Eigen::Vector3d;
using fuse_flow::Vec3;
using fuse_flow::host::CellNormals;
using fuse_flow::host::DepthMap;
using fuse_flow::host::DepthSurface;
using fuse_flow::host::RigGeometry;

Vector3d vector(const Vec3& v) { return {double{v.x}, double{v.y}, double{v.z}}; }

/** \brief A tilted board before a camera that stands askew, whose pixels are no squares. */
struct TiltedBoard {
  explicit TiltedBoard(float k1) : normal(Vector3d(0.3, -0.5, 1).normalized()) {
    fuse_flow::Camera camera = scenes::lookAt({0.3, -0.2, 0.1}, {0.1, 0.15, 1.4});
    camera.intrinsics.fx = 190;
    camera.intrinsics.fy = 140;
    camera.intrinsics.cx = 40.3f;
    camera.intrinsics.distortion.k1 = k1;
    scene = scenes::makeFlatScene({camera}, {1.0f});
    rig.update(scene.rig);
    depth.resize(camera.intrinsics.width, camera.intrinsics.height);
    const Vec3 centre = rig[0].T_world_camera.t;
    for (int v = 0; v < depth.height(); ++v)
      for (int u = 0; u < depth.width(); ++u) {  // where normal · (centre + z · ray) is 1.3
        const Vec3 ray = rotate(rig[0].T_world_camera, pointOnRay(rig[0].ray(u, v), 1.0f));
        depth.row(v)[u] = static_cast<float>((1.3 - normal.dot(vector(centre))) / normal.dot(vector(ray)));
      }
    if (normal.dot(camera.T_world_camera.translation()) < 1.3) normal = -normal;  // facing the camera
  }

  Vector3d normal;
  scenes::Scene scene;
  RigGeometry rig;
  DepthMap depth;
};

TEST(CellNormals, OfABoardAreThoseOfTheBoardBeforeAnyLensAtAnySpacing) {
  for (const float k1 : {0.0f, 0.04f})
    for (const int spacing : {1, 4}) {
      const TiltedBoard board(k1);
      CellNormals normals;
      normals.reserve(9);
      std::vector<Vec3> alone;
      for (const int v : {0, 31, board.depth.height() - 1})
        for (const int u : {0, 50, board.depth.width() - 1}) {
          normals.add(board.rig[0], board.depth, u, v, spacing);
          alone.push_back(surfaceDirection(board.rig[0], DepthSurface{board.depth, board.rig[0]}, u, v, spacing));
        }
      normals.compute();
      ASSERT_EQ(normals.size(), 9u);
      for (std::size_t k = 0; k < 9; ++k) {
        const Vector3d n(normals.x()[k], normals.y()[k], normals.z()[k]);
        EXPECT_LT(std::acos(n.normalized().dot(board.normal)), 2e-3) << k1 << ' ' << spacing << ' ' << k;
        EXPECT_EQ(normals.x()[k], alone[k].x);  // to the bit: the GPU computes them alone
        EXPECT_EQ(normals.y()[k], alone[k].y);
        EXPECT_EQ(normals.z()[k], alone[k].z);
      }
    }
}

TEST(CellNormals, AreThoseOfTheSurfaceThatNeighboursContinue) {
  // Right of column 50 there is a wall 0.3 m behind; the normals at the edge are still the board's.
  TiltedBoard board(0);
  for (int v = 0; v < board.depth.height(); ++v)
    for (int u = 51; u < board.depth.width(); ++u) board.depth.row(v)[u] = board.depth.row(v)[50] + 0.3f;
  CellNormals normals;
  normals.reserve(1);
  normals.add(board.rig[0], board.depth, 50, 31, 1);
  normals.compute();
  const Vector3d n(normals.x()[0], normals.y()[0], normals.z()[0]);
  EXPECT_LT(std::acos(n.normalized().dot(board.normal)), 2e-3);
}

TEST(CellNormals, AreZeroWhereNothingIsAround) {
  TiltedBoard board(0);
  for (int v = 0; v < board.depth.height(); ++v)
    for (int u = 0; u < board.depth.width(); ++u)
      if (u != 50 || v != 31) board.depth.row(v)[u] = 0;
  CellNormals normals;
  normals.reserve(1);
  normals.add(board.rig[0], board.depth, 50, 31, 1);
  normals.compute();
  EXPECT_EQ(normals.x()[0], 0.0f);
  EXPECT_EQ(normals.y()[0], 0.0f);
  EXPECT_EQ(normals.z()[0], 0.0f);
}

}  // namespace
