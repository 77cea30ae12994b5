#ifdef FUSE_FLOW_WITH_DRACO

#include "sinks/draco_file.h"

#include <fuse_flow/recordings/error.h>

#include "../recordings/io_fixture.h"

#include <draco/compression/decode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

namespace {

using namespace io_test;

// Draco's own decoder reads them.
class DracoFile : public IoTest {
 protected:
  /** \brief Of a point: where it is, in steps, and r, g, b, confidence and number of views. */
  using Point = std::array<int, 8>;

  static stream::StreamedCloud cloudOf(const std::vector<Point>& points, double step, float origin, bool all) {
    stream::StreamedCloud cloud;
    cloud.step = step;
    for (const Point& point : points) {
      for (int k = 0; k < 3; ++k)
        cloud.positions.push_back(static_cast<float>(origin + step * point[static_cast<std::size_t>(k)]));
      if (!all) continue;
      for (std::size_t k = 3; k < 6; ++k) cloud.colors.push_back(static_cast<std::uint8_t>(point[k]));
      cloud.confidence.push_back(static_cast<std::uint8_t>(point[6]));
      cloud.view_counts.push_back(static_cast<std::uint8_t>(point[7]));
      for (const float part : {0.0f, 0.6f, 0.8f}) cloud.normals.push_back(part);
    }
    return cloud;
  }

  static std::unique_ptr<draco::PointCloud> decoded(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    draco::DecoderBuffer buffer;
    buffer.Init(bytes.data(), bytes.size());
    draco::Decoder decoder;
    auto cloud = decoder.DecodePointCloudFromBuffer(&buffer);
    EXPECT_TRUE(cloud.ok()) << cloud.status().error_msg_string();
    return std::move(cloud).value();
  }

  /** \brief Sorted, as Draco has its own order. */
  static std::vector<Point> pointsOf(const draco::PointCloud& cloud, double step, float origin) {
    using Attribute = draco::GeometryAttribute;
    const auto* position = cloud.GetNamedAttribute(Attribute::POSITION);
    const auto* color = cloud.GetNamedAttribute(Attribute::COLOR);
    const auto* confidence = cloud.GetAttributeByUniqueId(
        static_cast<std::uint32_t>(cloud.GetAttributeIdByMetadataEntry("name", "confidence")));
    const auto* views = cloud.GetAttributeByUniqueId(
        static_cast<std::uint32_t>(cloud.GetAttributeIdByMetadataEntry("name", "view_count")));
    std::vector<Point> points(cloud.num_points());
    for (draco::PointIndex i(0); i < cloud.num_points(); ++i) {
      Point& point = points[i.value()];
      std::array<float, 3> at{};
      position->GetMappedValue(i, at.data());
      for (std::size_t k = 0; k < 3; ++k) {
        point[k] = static_cast<int>(std::lround((at[k] - origin) / step));
        EXPECT_NEAR(at[k], origin + step * point[k], 0.02 * step);  // on the lattice, but for a float's digits
      }
      std::array<std::uint8_t, 3> rgb{};
      if (color) color->GetMappedValue(i, rgb.data());
      for (std::size_t k = 0; k < 3; ++k) point[3 + k] = rgb[k];
      std::uint8_t value = 0;
      if (confidence) confidence->GetMappedValue(i, &value);
      point[6] = value;
      value = 0;
      if (views) views->GetMappedValue(i, &value);
      point[7] = value;
    }
    std::sort(points.begin(), points.end());
    return points;
  }

  static std::vector<Point> randomPoints(int count, int extent) {
    std::mt19937 random(3);
    std::vector<Point> points(static_cast<std::size_t>(count));
    for (Point& point : points)
      for (std::size_t k = 0; k < point.size(); ++k)
        point[k] = static_cast<int>(random() % static_cast<unsigned>(k < 3 ? extent : 256));
    return points;
  }
};

TEST_F(DracoFile, HasThePointsOfTheCloudOnItsLattice) {
  // The extent is where a bit more is needed, and where it is not.
  for (const auto& [count, extent, step] :
       {std::tuple{5000, 4095, 0.001}, {5000, 4097, 0.001}, {300, 100000, 0.0005}, {1, 1, 0.001}}) {
    SCOPED_TRACE(extent);
    std::vector<Point> points = randomPoints(count, extent);
    io::writeDraco(path("cloud.drc"), cloudOf(points, step, -2, true));
    const auto cloud = decoded(path("cloud.drc"));
    std::sort(points.begin(), points.end());
    EXPECT_EQ(pointsOf(*cloud, step, -2), points);
    const auto* normal = cloud->GetNamedAttribute(draco::GeometryAttribute::NORMAL);
    std::array<float, 3> n{};
    normal->GetMappedValue(draco::PointIndex(0), n.data());
    EXPECT_NEAR(n[1], 0.6, 0.005);
    EXPECT_NEAR(n[2], 0.8, 0.005);
  }
}

TEST_F(DracoFile, OfPositionsAloneHasNothingElse) {
  const std::vector<Point> points = randomPoints(1000, 3000);
  io::writeDraco(path("cloud.drc"), cloudOf(points, 0.001, 0, false));
  const auto cloud = decoded(path("cloud.drc"));
  EXPECT_EQ(cloud->num_attributes(), 1);
  EXPECT_EQ(cloud->num_points(), 1000u);
}

TEST_F(DracoFile, RefusesWhatDracoCannotHold) {
  EXPECT_THROW(io::writeDraco(path("none.drc"), {}), io::OutputError);
  EXPECT_THROW(io::writeDraco(path("none.drc"), cloudOf({{1}}, 0, 0, false)), io::OutputError);
  EXPECT_THROW(io::writeDraco(path("far.drc"), cloudOf({{0}, {2000000000}}, 0.001, 0, false)), io::OutputError);
  EXPECT_FALSE(fs::exists(path("none.drc")));
  EXPECT_FALSE(fs::exists(path("far.drc")));
}

}  // namespace

#endif
