#include "clouds/plain_clouds.h"

#include "../recordings/io_fixture.h"

#include "clouds/cloud_io.h"
#include "methods/plain_fusion.h"

#include <pcl/point_types.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>

namespace {

using namespace io_test;

class PlainCloudsTest : public IoTest {
 protected:
  /** \brief A square of 20 x 20 points, 10 mm apart, in the plane z, of one colour. */
  std::string writeSquare(const std::string& name, float z, std::uint8_t red, float shift = 0) const {
    pcl::PointCloud<pcl::PointXYZRGB> cloud;
    for (int v = 0; v < 20; ++v)
      for (int u = 0; u < 20; ++u) {
        pcl::PointXYZRGB p(red, 0, 0);
        p.x = 0.01f * static_cast<float>(u) + shift;
        p.y = 0.01f * static_cast<float>(v);
        p.z = z;
        cloud.push_back(p);
      }
    fs::create_directories(fs::path(path(name)).parent_path());
    io::writeCloud(path(name), cloud);
    return path(name);
  }
};

TEST_F(PlainCloudsTest, FilesAreTheScannersOfOneFrame) {
  const std::vector<std::string> files{writeSquare("a.ply", 1.001f, 200), writeSquare("b.pcd", 1.005f, 100)};
  ASSERT_TRUE(io::PlainClouds::are(files));
  io::PlainClouds clouds(files, "");
  EXPECT_EQ(clouds.scanners(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(clouds.frames(), std::vector<std::size_t>{0});
  pcl::PointCloud<io::PointFusedNormal> points;
  std::vector<std::uint32_t> scanners;
  clouds.read(0, points, scanners);
  ASSERT_EQ(points.size(), 800u);
  EXPECT_EQ(scanners.front(), 0u);
  EXPECT_EQ(scanners.back(), 1u);
  EXPECT_EQ(points[0].confidence, 1);
  EXPECT_EQ(points[0].r, 200);

  // Two scanners 4 mm apart, within one cell, become one surface between them, which both have seen.
  pcl::PointCloud<io::PointFusedNormal> fused;
  io::fusePlainCloud(points, scanners, {}, 1, fused);
  EXPECT_LT(fused.size(), 600u);
  EXPECT_GT(fused.size(), 200u);
  std::size_t both = 0;
  for (const io::PointFusedNormal& p : fused) {
    EXPECT_GT(p.z, 1.0009f);
    EXPECT_LT(p.z, 1.0051f);
    both += p.view_count == 2;
  }
  EXPECT_GT(both, fused.size() / 2);
  pcl::PointCloud<io::PointFusedNormal> again;
  io::fusePlainCloud(points, scanners, {}, 3, again);
  ASSERT_EQ(again.size(), fused.size());
  for (std::size_t k = 0; k < fused.size(); ++k) EXPECT_EQ(again[k].getVector3fMap(), fused[k].getVector3fMap());
}

TEST_F(PlainCloudsTest, FoldersHaveAFileForEachFrame) {
  writeSquare("left/scan_0001.ply", 1, 1);
  writeSquare("left/scan_0002.ply", 1, 2);
  writeSquare("right/2.ply", 1, 3);
  write("right/notes.txt", "no cloud");
  const std::vector<std::string> folders{path("left"), path("right")};
  ASSERT_TRUE(io::PlainClouds::are(folders));
  io::PlainClouds clouds(folders, "");
  EXPECT_EQ(clouds.frames(), (std::vector<std::size_t>{1, 2}));
  pcl::PointCloud<io::PointFusedNormal> points;
  std::vector<std::uint32_t> scanners;
  clouds.read(1, points, scanners);
  EXPECT_EQ(points.size(), 400u);  // the right one has lost it
  clouds.read(2, points, scanners);
  EXPECT_EQ(points.size(), 800u);
  writeSquare("right/other_2.ply", 1, 3);
  EXPECT_TRUE(refuses([&] { io::PlainClouds(folders, ""); }, {"2.ply", "other_2.ply", "one cloud of a frame"}));
  EXPECT_TRUE(refuses(
      [&] {
        io::PlainClouds({path("left"), writeSquare("c.ply", 1, 1)}, "");
      },
      {"c.ply", "all be folders"}));
}

TEST_F(PlainCloudsTest, PosesMoveTheScannerOfTheirName) {
  const std::vector<std::string> files{writeSquare("a.ply", 1, 1), writeSquare("b.ply", 1, 1)};
  nlohmann::json rig;
  for (const auto& [name, x] : {std::pair{"b", 5.0}, {"a", 0.0}})
    rig["cameras"].push_back({{"name", name},
                              {"width", 4},
                              {"height", 3},
                              {"fx", 4},
                              {"fy", 4},
                              {"cx", 2},
                              {"cy", 1},
                              {"depth_scale", 1},
                              {"T_world_camera", {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
  io::PlainClouds clouds(files, write("rig.json", rig.dump()));
  pcl::PointCloud<io::PointFusedNormal> points;
  std::vector<std::uint32_t> scanners;
  clouds.read(0, points, scanners);
  EXPECT_EQ(points[0].x, 0);
  EXPECT_EQ(points[400].x, 5);
  rig["cameras"].erase(0);
  EXPECT_TRUE(refuses([&] { io::PlainClouds(files, write("rig.json", rig.dump())); }, {"rig.json", "no camera 'b'"}));
}

TEST_F(PlainCloudsTest, WhatIsNoPlainCloud) {
  const std::string file = writeSquare("a.ply", 1, 1);
  EXPECT_FALSE(io::PlainClouds::are({}));
  EXPECT_FALSE(io::PlainClouds::are({file, path("missing.ply")}));
  EXPECT_FALSE(io::PlainClouds::are({file, write("rig.json", "{}")}));
  pcl::PointCloud<pcl::PointXYZ> organized(4, 3);
  io::writeCloud(path("organized.pcd"), organized);
  EXPECT_FALSE(io::PlainClouds::are({path("organized.pcd")}));  // a recording
  fs::create_directories(path("empty"));
  EXPECT_FALSE(io::PlainClouds::are({path("empty")}));
  // A recording stays one, though somebody has put a cloud beside it.
  writeSquare("recording/scan_1.ply", 1, 1);
  EXPECT_TRUE(io::PlainClouds::are({path("recording")}));
  write("recording/rig.json", "{}");
  EXPECT_FALSE(io::PlainClouds::are({path("recording")}));
}

TEST_F(PlainCloudsTest, NormalsAreOfAllCloudsOrOfNone) {
  pcl::PointCloud<pcl::PointNormal> cloud(1, 1);
  cloud[0].z = 1;
  cloud[0].normal_x = 1;
  io::writeCloud(path("n.ply"), cloud);
  const std::vector<std::string> files{path("n.ply"), writeSquare("a.ply", 1, 1)};
  io::PlainClouds clouds(files, "");
  EXPECT_TRUE(clouds.haveNormals());
  pcl::PointCloud<io::PointFusedNormal> points;
  std::vector<std::uint32_t> scanners;
  EXPECT_TRUE(refuses([&] { clouds.read(0, points, scanners); }, {"a.ply", "has no normals"}));
}

TEST_F(PlainCloudsTest, AConfidenceOfTheFileIsKept) {
  pcl::PointCloud<PointFused> cloud(2, 1);
  cloud[0].z = cloud[1].z = 1;
  cloud[1].x = 1;
  cloud[0].confidence = 0.25f;
  cloud[1].confidence = 0.5f;
  io::writeCloud(path("a.ply"), cloud);
  pcl::PointCloud<io::PointFusedNormal> points;
  std::vector<std::uint32_t> scanners;
  io::PlainClouds({path("a.ply")}, "").read(0, points, scanners);
  EXPECT_EQ(points[0].confidence, 0.25f);
  EXPECT_EQ(points[1].confidence, 0.5f);
}

/** \brief As LiveScan3D writes a frame of its sensor. */
std::string liveScanFrame(const std::vector<std::array<int, 3>>& millimetres, const std::string& stamp) {
  std::string bytes = "n_points= " + std::to_string(millimetres.size()) + "\nframe_timestamp= " + stamp + "\n";
  for (const std::array<int, 3>& point : millimetres)
    for (const int axis : point) {
      bytes += static_cast<char>(axis & 0xff);
      bytes += static_cast<char>(axis >> 8 & 0xff);
    }
  for (std::size_t k = 0; k < millimetres.size(); ++k) {
    bytes += static_cast<char>(30 + k);  // blue
    bytes += static_cast<char>(20 + k);
    bytes += static_cast<char>(10 + k);
    bytes += '\xff';
  }
  return bytes + "\n";
}

TEST_F(PlainCloudsTest, FilesOfLiveScan3DAreTheScannersOfSeveralFrames) {
  // Points whose bytes look like line ends: frames are found by their sizes.
  const std::string first = liveScanFrame({{10, 2570, -1}, {-32768, 32767, 1234}}, "17"),
                    second = liveScanFrame({}, "50"), third = liveScanFrame({{1, 2, 3}}, "4294967295");
  write("a.bin", first + second + third);
  write("b.bin", first + second + third + "n_points= 100\nframe_timestamp= 99\nabc");
  const std::vector<std::string> files{path("a.bin"), path("b.bin")};
  ASSERT_TRUE(io::PlainClouds::are(files));
  io::PlainClouds clouds(files, "");
  EXPECT_EQ(clouds.frames(), (std::vector<std::size_t>{0, 1, 2}));
  ASSERT_EQ(clouds.warnings().size(), 1u);
  EXPECT_NE(clouds.warnings()[0].find("b.bin: its last frame is cut short"), std::string::npos);
  EXPECT_FALSE(clouds.haveNormals());
  pcl::PointCloud<io::PointFusedNormal> points;
  std::vector<std::uint32_t> scanners;
  clouds.read(0, points, scanners);
  ASSERT_EQ(points.size(), 4u);
  EXPECT_EQ(scanners, (std::vector<std::uint32_t>{0, 0, 1, 1}));
  EXPECT_FLOAT_EQ(points[0].y, 2.57f);
  EXPECT_FLOAT_EQ(points[0].z, -0.001f);
  EXPECT_FLOAT_EQ(points[3].x, -32.768f);
  EXPECT_FLOAT_EQ(points[3].y, 32.767f);
  EXPECT_EQ(points[1].r, 11);
  EXPECT_EQ(points[1].g, 21);
  EXPECT_EQ(points[1].b, 31);
  EXPECT_EQ(points[2].confidence, 1);
  clouds.read(1, points, scanners);
  EXPECT_TRUE(points.empty());
  clouds.read(2, points, scanners);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_FLOAT_EQ(points[1].z, 0.003f);
}

TEST_F(PlainCloudsTest, FilesThatLiveScan3DHasNotWrittenAreRefused) {
  write("other.bin", std::string("cameras of COLMAP"));
  EXPECT_FALSE(io::PlainClouds::are({path("other.bin")}));
  write("a.bin", liveScanFrame({{1, 2, 3}}, "0") + "and then text\nof another kind\n");
  EXPECT_TRUE(refuses([&] { io::PlainClouds({path("a.bin")}, ""); }, {"a.bin", "frame 1", "n_points="}));
  write("b.bin", std::string("n_points= -5\nframe_timestamp= 0\n"));
  EXPECT_TRUE(refuses([&] { io::PlainClouds({path("b.bin")}, ""); }, {"b.bin", "frame 0"}));
  write("c.bin", std::string("n_points= 5"));
  EXPECT_TRUE(refuses([&] { io::PlainClouds({path("c.bin")}, ""); }, {"c.bin", "no whole frame"}));
  write("d.bin", liveScanFrame({{1, 2, 3}}, "0"));
  writeSquare("e.ply", 1, 9);
  EXPECT_TRUE(refuses([&] { io::PlainClouds({path("d.bin"), path("e.ply")}, ""); }, {"e.ply", "all be files"}));
  write("f.bin", liveScanFrame({{1, 2, 3}}, "0") + liveScanFrame({{1, 2, 3}}, "1"));
  const io::PlainClouds different({path("d.bin"), path("f.bin")}, "");
  ASSERT_EQ(different.warnings().size(), 1u);
  EXPECT_NE(different.warnings()[0].find("d.bin has 1 frames"), std::string::npos);
}

}  // namespace
