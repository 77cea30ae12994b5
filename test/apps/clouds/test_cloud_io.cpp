#include "clouds/cloud_io.h"

#include "../recordings/io_fixture.h"
#include "recordings/files/file_io.h"

#include <fuse_flow/point_types.h>

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <cstring>
#include <limits>

namespace {

using namespace io_test;

class CloudIo : public IoTest {
 protected:
  /** \brief The bytes of a file that has just been written, up to its data and from there. */
  std::pair<std::string, std::string> split(const std::string& name, const std::string& last_line) const {
    const std::string bytes = io::readFile(path(name));
    const std::size_t at = bytes.find(last_line);
    EXPECT_NE(at, std::string::npos);
    return {bytes.substr(0, at + last_line.size()), bytes.substr(at + last_line.size())};
  }
};

template <typename Value>
std::string bytesOf(const Value& value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

template <typename... Values>
std::string record(const Values&... values) {
  return (bytesOf(values) + ...);
}

PointFused fused(float x, float y, float z) {
  PointFused p;
  p.x = x, p.y = y, p.z = z;
  p.r = 10, p.g = 20, p.b = 30;
  p.confidence = 0.75f;
  p.view_count = 3;
  return p;
}

TEST_F(CloudIo, APlyIsWhatOtherProgramsExpect) {
  pcl::PointCloud<PointFused> cloud;
  cloud.push_back(fused(1, -2, 3.5f));
  cloud.push_back(fused(4, 5, 6));
  io::writeCloud(path("a.ply"), cloud);
  const auto [header, data] = split("a.ply", "end_header\n");
  EXPECT_EQ(header,
            "ply\nformat binary_little_endian 1.0\nelement vertex 2\n"
            "property float x\nproperty float y\nproperty float z\n"
            "property uchar red\nproperty uchar green\nproperty uchar blue\n"
            "property float confidence\nproperty uint view_count\nend_header\n");
  EXPECT_EQ(data, record(1.0f, -2.0f, 3.5f) + "\x0a\x14\x1e" + record(0.75f, 3u) + record(4.0f, 5.0f, 6.0f) +
                      "\x0a\x14\x1e" + record(0.75f, 3u));
}

TEST_F(CloudIo, APcdIsWhatPclExpects) {
  pcl::PointCloud<PointFused> cloud;
  cloud.push_back(fused(1, -2, 3.5f));
  cloud.sensor_origin_ << 0.5f, 0.25f, -1, 0;
  cloud.sensor_orientation_ = Eigen::Quaternionf(0.5f, -0.5f, 0.5f, -0.5f);
  io::writeCloud(path("a.pcd"), cloud);
  const auto [header, data] = split("a.pcd", "DATA binary\n");
  EXPECT_EQ(header,
            "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgba confidence view_count\n"
            "SIZE 4 4 4 4 4 4\nTYPE F F F U F U\nCOUNT 1 1 1 1 1 1\nWIDTH 1\nHEIGHT 1\n"
            "VIEWPOINT 0.5 0.25 -1 0.5 -0.5 0.5 -0.5\nPOINTS 1\nDATA binary\n");
  EXPECT_EQ(data, record(1.0f, -2.0f, 3.5f, 0xff0a141eu, 0.75f, 3u));
}

TEST_F(CloudIo, NormalsHaveTheNamesThatOtherProgramsExpect) {
  pcl::PointCloud<pcl::PointXYZRGBNormal> cloud(1, 1);
  io::writeCloud(path("a.ply"), cloud);
  const std::string header = split("a.ply", "end_header\n").first;
  EXPECT_NE(header.find("property float nx\nproperty float ny\nproperty float nz\n"), std::string::npos) << header;
}

TEST_F(CloudIo, EveryFieldComesBack) {
  pcl::PointCloud<PointFused> cloud;
  for (int i = 0; i < 5; ++i) {
    cloud.push_back(fused(static_cast<float>(i) / 3, 1e-20f, -7e9f));
    cloud.back().view_count = static_cast<std::uint32_t>(i);
    cloud.back().g = static_cast<std::uint8_t>(250 + i);
  }
  for (const char* name : {"a.ply", "a.pcd", "A.PLY", "A.PCD"}) {
    pcl::PointCloud<PointFused> back;
    io::writeCloud(path(name), cloud);
    io::readCloud(path(name), back);
    ASSERT_EQ(back.size(), cloud.size()) << name;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      EXPECT_EQ(back[i].getVector3fMap(), cloud[i].getVector3fMap()) << name;
      EXPECT_EQ(back[i].r, 10) << name;
      EXPECT_EQ(back[i].g, cloud[i].g) << name;
      EXPECT_EQ(back[i].b, 30) << name;
      EXPECT_EQ(back[i].confidence, 0.75f) << name;
      EXPECT_EQ(back[i].view_count, i) << name;
    }
  }
}

TEST_F(CloudIo, NormalsComeBack) {
  pcl::PointCloud<pcl::PointXYZRGBNormal> cloud(1, 1), back;
  cloud[0].normal_x = 0.6f;
  cloud[0].normal_z = -0.8f;
  cloud[0].curvature = 0.25f;
  for (const char* name : {"a.ply", "a.pcd"}) {
    io::writeCloud(path(name), cloud);
    io::readCloud(path(name), back);
    EXPECT_EQ(back[0].normal_x, 0.6f) << name;
    EXPECT_EQ(back[0].normal_z, -0.8f) << name;
    EXPECT_EQ(back[0].curvature, 0.25f) << name;
  }
}

TEST_F(CloudIo, APcdKeepsRowsPoseAndMissingPoints) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  pcl::PointCloud<pcl::PointXYZ> cloud(3, 2), back;
  for (std::size_t i = 0; i < 6; ++i) cloud[i].x = static_cast<float>(i);
  cloud[4].x = cloud[4].y = cloud[4].z = nan;
  cloud.sensor_origin_ << 1, 2, 3, 0;
  cloud.sensor_orientation_ = Eigen::Quaternionf(0.5f, -0.5f, 0.5f, -0.5f);
  io::writeCloud(path("a.pcd"), cloud);
  io::readCloud(path("a.pcd"), back);
  EXPECT_EQ(back.width, 3u);
  EXPECT_EQ(back.height, 2u);
  EXPECT_EQ(back.at(2, 1).x, 5.0f);
  EXPECT_TRUE(std::isnan(back.at(1, 1).z));
  EXPECT_EQ(back.sensor_origin_.head<3>(), Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(back.sensor_orientation_.coeffs(), cloud.sensor_orientation_.coeffs());
}

TEST_F(CloudIo, APlyLeavesOutPointsThatAreNotFinite) {
  pcl::PointCloud<pcl::PointXYZ> cloud(4, 1), back;
  cloud[0].y = std::numeric_limits<float>::quiet_NaN();
  cloud[2].z = -std::numeric_limits<float>::infinity();
  cloud[1].x = 1;
  cloud[3].x = 3;
  io::writeCloud(path("a.ply"), cloud);
  io::readCloud(path("a.ply"), back);
  ASSERT_EQ(back.size(), 2u);
  EXPECT_EQ(back[0].x, 1.0f);
  EXPECT_EQ(back[1].x, 3.0f);
}

TEST_F(CloudIo, APlyAsOpen3dWritesItIsRead) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment Created by Open3D\nelement vertex 2\nproperty double x\n"
      "property double y\nproperty double z\nproperty double nx\nproperty double ny\nproperty double nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  const std::string points =
      record(1.5, -2.0, 0.1, 0.0, 0.6, 0.8) + "\x01\x02\x03" + record(4.0, 5.0, 6.0, 1.0, 0.0, 0.0) + "\x04\x05\x06";
  pcl::PointCloud<pcl::PointXYZRGBNormal> cloud;
  io::readCloud(write("a.ply", header + points), cloud);
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud[0].getVector3fMap(), Eigen::Vector3f(1.5f, -2.0f, 0.1f));
  EXPECT_EQ(cloud[1].getVector3fMap(), Eigen::Vector3f(4, 5, 6));
  EXPECT_EQ(cloud[0].getNormalVector3fMap(), Eigen::Vector3f(0, 0.6f, 0.8f));
  EXPECT_EQ(cloud[1].g, 5);
}

TEST_F(CloudIo, APcdInDoublesIsRead) {
  const std::string file = write("a.pcd",
                                 "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
                                 "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA binary\n" +
                                     record(1.5, -2.0, 0.1));
  pcl::PointCloud<pcl::PointXYZ> cloud;
  io::readCloud(file, cloud);
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud[0].getVector3fMap(), Eigen::Vector3f(1.5f, -2.0f, 0.1f));
}

TEST_F(CloudIo, AMeshWithFacesAndTextIsReadAsItsPoints) {
  const std::string file = write("a.ply",
                                 "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 3\nproperty float x\n"
                                 "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
                                 "property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\n"
                                 "end_header\n0 0 1 255 0 0\n1 0 2 0 255 0\n0 1 3 0 0 255\n3 0 1 2\n");
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  io::readCloud(file, cloud);
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud[2].getVector3fMap(), Eigen::Vector3f(0, 1, 3));
  EXPECT_EQ(cloud[1].g, 255);
}

TEST_F(CloudIo, AnotherExtensionIsRefused) {
  pcl::PointCloud<pcl::PointXYZ> cloud(1, 1);
  EXPECT_TRUE(refuses<io::OutputError>([&] { io::writeCloud(path("a.xyz"), cloud); },
                                       {path("a.xyz"), "'.xyz'", ".ply or .pcd"}));
  EXPECT_TRUE(refuses<io::OutputError>([&] { io::writeCloud(path("a"), cloud); }, {path("a"), ".ply or .pcd"}));
  EXPECT_TRUE(refuses([&] { io::readCloud(path("a.xyz"), cloud); }, {path("a.xyz"), ".ply or .pcd"}));
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(CloudIo, WhatCannotBeReadIsNamed) {
  pcl::PointCloud<pcl::PointXYZ> cloud;
  const auto isRefused = [&](const std::string& file, const std::string& problem) {
    return refuses([&] { io::readCloud(file, cloud); }, {file, problem});
  };
  EXPECT_TRUE(isRefused(path("no.ply"), "not found"));
  fs::create_directory(path("folder.pcd"));
  EXPECT_TRUE(isRefused(path("folder.pcd"), "is not a file"));
  for (const char* name : {"empty.ply", "empty.pcd"}) EXPECT_TRUE(isRefused(write(name, ""), "damaged or cut short"));
  for (const char* name : {"text.ply", "text.pcd"}) EXPECT_TRUE(isRefused(write(name, "not a cloud\n"), "damaged"));
  EXPECT_TRUE(isRefused(write("a.ply",
                              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                              "end_header\n1 2\n"),
                        "has no field z"));
  EXPECT_TRUE(isRefused(write("b.ply",
                              "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\n"
                              "property int z\nend_header\n1 2 3\n"),
                        "field x is not of floating point"));
  EXPECT_TRUE(isRefused(write("c.ply",
                              "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
                              "property float z\nend_header\n"),
                        "has no points"));
}

TEST_F(CloudIo, ColorsOfAPlyInAnotherOrderAreRefused) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  for (const char* color : {"blue", "green", "diffuse_blue"}) {
    const std::string file = write("a.ply", header + "property uchar " + color + "\nend_header\n1 2 3 4\n");
    EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, color, "must be red, green, blue"}));
  }
  const std::string begin = header + "property uchar red\n";
  for (const char* rest :
       {"", "property uchar blue\n", "property float confidence\nproperty uchar green\nproperty uchar blue\n"}) {
    const std::string file = write("b.ply", begin + rest + "end_header\n1 2 3 4 5 6 7\n");
    EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, "must be red, green, blue"})) << rest;
  }
}

// PCL's reader would end the program.
TEST_F(CloudIo, APlyWithListsOrAGridOfVerticesIsRefused) {
  const std::string header =
      "ply\nformat ascii 1.0\nobj_info num_cols 1\nobj_info num_rows 1\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\n";
  pcl::PointCloud<pcl::PointXYZ> cloud;
  const std::string list = write("a.ply", header + "property list int int k\nend_header\n1 2 3 -1 5\n");
  EXPECT_TRUE(refuses([&] { io::readCloud(list, cloud); }, {list, "list", "vertices"}));
  const std::string grid =
      write("b.ply", header + "element range_grid 1\nproperty list uchar int k\nend_header\n1 2 3\n1 2147483647\n");
  EXPECT_TRUE(refuses([&] { io::readCloud(grid, cloud); }, {grid, "range_grid"}));
}

// PCL's reader would end the program.
TEST_F(CloudIo, APlyWithOtherRowsAndColumnsThanVerticesIsRefused) {
  pcl::PointCloud<pcl::PointXYZ> cloud;
  const auto file = [&](const std::string& columns, const std::string& rows) {
    return write("a.ply", "ply\nformat ascii 1.0\nobj_info num_cols " + columns + "\nobj_info num_rows " + rows +
                              "\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
                              "0 0 1\n0 0 1\n0 0 1\n0 0 1\n");
  };
  io::readCloud(file("2", "2"), cloud);
  EXPECT_EQ(cloud.size(), 4u);
  for (const auto& [columns, rows] : {std::pair{"2", "1"}, {"3", "2"}, {"0", "4"}, {"-2", "-3"}, {"nan", "4"}})
    EXPECT_TRUE(refuses([&, name = file(columns, rows)] { io::readCloud(name, cloud); }, {"a.ply", "4 vertices"}))
        << columns << ' ' << rows;
}

// PCL's reader would take gigabytes.
TEST_F(CloudIo, APcdWithFieldsOfASizeThatNoNumberHasIsRefused) {
  pcl::PointCloud<pcl::PointXYZ> cloud;
  for (const char* size : {"2147483648", "4294967295", "0", "-4", "3"}) {
    const std::string file =
        write("a.pcd", std::string("VERSION 0.7\nFIELDS x y z\nSIZE 4 ") + size +
                           " 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0"
                           "\nPOINTS 1\nDATA ascii\n1 2 3\n");
    EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, "damaged"})) << size;
  }
}

TEST_F(CloudIo, APcdThatPclHasCompressedIsRead) {
  pcl::PointCloud<pcl::PointXYZRGBNormal> cloud, back;
  for (int i = 0; i < 50; ++i) {
    pcl::PointXYZRGBNormal p;
    p.x = static_cast<float>(i), p.normal_z = 1, p.r = 7;
    cloud.push_back(p);
  }
  ASSERT_EQ(pcl::PCDWriter().writeBinaryCompressed(path("a.pcd"), cloud), 0);
  io::readCloud(path("a.pcd"), back);
  ASSERT_EQ(back.size(), 50u);
  EXPECT_EQ(back[49].x, 49);
  EXPECT_EQ(back[49].normal_z, 1);
  EXPECT_EQ(back[49].r, 7);
}

// PCL's reader would write and read where it pleases, or ask for all memory there is.
TEST_F(CloudIo, APcdWhoseNumbersLieIsRefused) {
  const auto header = [](const std::string& count, const std::string& data) {
    return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 " + count +
           "\nWIDTH 10\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 10\nDATA " + data + "\n";
  };
  pcl::PointCloud<pcl::PointXYZ> cloud;
  const std::string bytes(120, '\1');
  for (const char* count : {"-1", "-2000000000", "2000000000"}) {
    const std::string file = write("a.pcd", header(count, "binary") + bytes);
    EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, "damaged"})) << count;
  }
  for (const std::uint32_t compressed : {0u, 10u, 112u, 4294967295u})
    for (const std::uint32_t whole : {0u, 10u, 119u, 121u, 2147483648u, 4294967295u}) {
      const std::string file = write("b.pcd", header("1", "binary_compressed") + record(compressed, whole) + bytes);
      EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, "damaged"})) << compressed << ' ' << whole;
    }
}

TEST_F(CloudIo, ACloudCutShortAnywhereIsRefused) {
  pcl::PointCloud<PointFused> cloud, back;
  for (int i = 0; i < 3; ++i) cloud.push_back(fused(1, 2, 3));
  for (const char* name : {"a.ply", "a.pcd"}) {
    io::writeCloud(path(name), cloud);
    const std::string whole = io::readFile(path(name));
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const std::string file = write(name, whole.substr(0, size));
      EXPECT_TRUE(refuses([&] { io::readCloud(file, back); }, {file})) << "after " << size << " bytes";
    }
  }
}

TEST_F(CloudIo, ACloudWithAnyByteChangedIsReadOrRefused) {
  pcl::PointCloud<PointFused> cloud, back;
  for (int i = 0; i < 3; ++i) cloud.push_back(fused(1, 2, 3));
  for (const char* name : {"a.ply", "a.pcd"}) {
    io::writeCloud(path(name), cloud);
    const std::string whole = io::readFile(path(name));
    for (std::size_t at = 0; at < whole.size(); ++at)
      for (const int change : {0x01, 0x08, 0x10, 0x40}) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ change);
        const std::string file = write(name, damaged);
        try {
          io::readCloud(file, back);
        } catch (const io::InputError& error) {
          EXPECT_NE(std::string(error.what()).find(file), std::string::npos) << error.what();
        }
      }
  }
}

/** \brief PCL's readers would take gigabytes first. */
TEST_F(CloudIo, AHeaderThatPromisesMoreThanTheFileHoldsIsRefused) {
  const std::string ply = "element vertex 1000000000\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string pcd =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1000000000\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1000000000\n";
  pcl::PCLPointCloud2 cloud;
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"a.ply", "ply\nformat binary_little_endian 1.0\n" + ply + "end_header\n" + record(1.0f, 2.0f, 3.0f)},
           {"b.ply", "ply\nformat ascii 1.0\n" + ply + "end_header\n1 2 3\n"},
           {"a.pcd", pcd + "DATA binary\n" + record(1.0f, 2.0f, 3.0f)},
           {"b.pcd", pcd + "DATA ascii\n1 2 3\n"},
           {"c.pcd", pcd + "DATA binary_compressed\n" + record(12u, 12u, 1.0f, 2.0f, 3.0f)}}) {
    const std::string file = write(name, bytes);
    EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, "cut short"}));
    EXPECT_EQ(cloud.data.size(), 0u) << name;
  }
}

/** \brief PCL's reader takes POINTSX for POINTS, the last of two, and memory by it. */
TEST_F(CloudIo, APcdWhoseHeaderHasALineTwiceOrOneThatNoPcdHasIsRefused) {
  const std::string begin = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
  const std::string end = "WIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n1 2 3\n";
  pcl::PCLPointCloud2 cloud;
  io::readCloud(write("a.pcd", begin + end), cloud);
  EXPECT_EQ(cloud.width, 1u);
  for (const char* line : {"POINTS 250000000", "POINTSX 250000000", "WIDTHS 5", "WIDTH 1", "COLUMNS x y z",
                           "DATAX ascii", "SIZES 4 4 8", "points 1", "\x01"}) {
    const std::string file = write("b.pcd", begin + line + "\n" + end);
    cloud = {};
    EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, "header has"})) << line;
    EXPECT_EQ(cloud.data.size(), 0u) << line;
  }
  for (const char* data : {"DATA", "DATA asci", "DATA binaryX"}) {
    const std::string file = write("c.pcd", begin + "WIDTH 1\nHEIGHT 1\nPOINTS 1\n" + data + "\n1 2 3\n");
    EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, "DATA"})) << data;
  }
}

TEST_F(CloudIo, APcdWithoutSizesThatPromisesMoreThanItHoldsIsRefused) {
  pcl::PCLPointCloud2 cloud;
  for (const char* data : {"ascii", "binary"}) {
    const std::string file = write(
        "a.pcd", std::string("FIELDS x y z\nWIDTH 250000000\nHEIGHT 1\nPOINTS 250000000\nDATA ") + data + "\n1 2 3\n");
    EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, "fewer values"})) << data;
  }
}

/** \brief A line without an end, such as a file of something else has, is not read until memory is full. */
TEST_F(CloudIo, AHeaderWithoutAnEndIsReadForAMebibyteOnly) {
  pcl::PCLPointCloud2 cloud;
  for (const char* name : {"a.pcd", "a.ply"}) {
    const std::string file = write(name, "ply\nVERSION 0.7 ");
    fs::resize_file(file, std::uintmax_t{1} << 36);  // 64 GiB, none of which is on the disk
    EXPECT_TRUE(refuses([&] { io::readCloud(file, cloud); }, {file, "first 1048576 bytes"})) << name;
  }
}

/** \brief Such a file fails at its first byte, with EIO, as one on a broken disk does; PCL's reader of headers goes on for ever. */
TEST_F(CloudIo, AFileThatCannotBeReadIsRefused) {
  pcl::PCLPointCloud2 cloud;
  for (const char* name : {"a.pcd", "a.ply"}) {
    fs::create_symlink("/proc/self/mem", folder_ / name);
    EXPECT_TRUE(refuses([&] { io::readCloud(path(name), cloud); }, {path(name)})) << name;
  }
}

TEST_F(CloudIo, APlyWithNumbersThatAreNoWholeOnesIsRefused) {
  pcl::PCLPointCloud2 cloud;
  const auto file = [&](const std::string& count, const std::string& info) {
    return write("a.ply", "ply\nformat ascii 1.0\n" + info + "element vertex " + count +
                              "\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 1\n");
  };
  for (const char* count : {"1e9", "-1", "0x1", "99999999999", "1.0", ""})
    EXPECT_TRUE(refuses([&, name = file(count, "")] { io::readCloud(name, cloud); }, {"a.ply", "whole number"}))
        << count;
  // 1e0 is 1 for one who reads numbers, and 1 for one who reads up to the letter; 1e3 is not.
  for (const char* info :
       {"obj_info num_cols 1e3\nobj_info num_rows 1e-3\n", "obj_info num_cols 1\nobj_info num_rows\n"})
    EXPECT_TRUE(refuses([&, name = file("1", info)] { io::readCloud(name, cloud); }, {"a.ply", "obj_info"})) << info;
  // PCL passes over white space in front of a line.
  const std::string two_ends = write("b.ply",
                                     "ply\nformat ascii 1.0\nelement vertex 300000000\nproperty float x\n"
                                     "property float y\nproperty float z\n end_header\nelement vertex 0\nend_header\n");
  cloud = {};
  EXPECT_TRUE(refuses([&] { io::readCloud(two_ends, cloud); }, {two_ends, "cut short"}));
  EXPECT_EQ(cloud.data.size(), 0u);
  const std::string alpha =
      write("c.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
            "property uchar alpha\nend_header\n1 2 3 4\n");
  EXPECT_TRUE(refuses([&] { io::readCloud(alpha, cloud); }, {alpha, "alpha without red"}));
}

TEST_F(CloudIo, TextWithoutAByteTooManyIsWhole) {
  pcl::PCLPointCloud2 cloud;
  io::readCloud(write("a.ply",
                      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
                      "element face 1\nproperty list uchar int vertex_indices\nend_header\n1 2 3\n4 5 6\n0\n"),
                cloud);
  EXPECT_EQ(cloud.width, 2u);
  io::readCloud(write("a.pcd",
                      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
                      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6"),
                cloud);
  EXPECT_EQ(cloud.width, 2u);
}

}  // namespace
