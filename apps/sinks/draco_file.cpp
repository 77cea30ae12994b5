#include "sinks/draco_file.h"

#include <fuse_flow/recordings/error.h>

#ifdef FUSE_FLOW_WITH_DRACO

#include "recordings/files/file_io.h"

#include <draco/compression/encode.h>
#include <draco/point_cloud/point_cloud_builder.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace fuse_flow::io {

bool hasDraco() { return true; }

void writeDraco(const std::string& path, const stream::StreamedCloud& cloud) {
  if (cloud.size() == 0) throw OutputError(path + ": Draco has no files without points");
  if (!(cloud.step > 0)) throw OutputError(path + ": the cloud has no step");
  std::array<float, 3> least{cloud.positions[0], cloud.positions[1], cloud.positions[2]}, greatest = least;
  for (std::size_t k = 0; k < cloud.positions.size(); ++k) {
    least[k % 3] = std::min(least[k % 3], cloud.positions[k]);
    greatest[k % 3] = std::max(greatest[k % 3], cloud.positions[k]);
  }
  double extent = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    extent = std::max(extent, static_cast<double>(greatest[axis]) - static_cast<double>(least[axis]));
  int bits = 1;
  while (bits < 30 && (std::int64_t{1} << bits) - 1 < static_cast<std::int64_t>(extent / cloud.step) + 1) ++bits;
  if (bits == 30) throw OutputError(path + ": the points are too far apart for Draco");

  using Attribute = draco::GeometryAttribute;
  draco::PointCloudBuilder builder;
  builder.Start(static_cast<std::uint32_t>(cloud.size()));
  const auto add = [&](Attribute::Type type, int parts, draco::DataType values, const void* data) {
    const int attribute = builder.AddAttribute(type, static_cast<std::int8_t>(parts), values);
    builder.SetAttributeValuesForAllPoints(attribute, data, 0);
    return attribute;
  };
  add(Attribute::POSITION, 3, draco::DT_FLOAT32, cloud.positions.data());
  if (!cloud.colors.empty()) add(Attribute::COLOR, 3, draco::DT_UINT8, cloud.colors.data());
  if (!cloud.normals.empty()) add(Attribute::NORMAL, 3, draco::DT_FLOAT32, cloud.normals.data());
  std::array<std::pair<const char*, int>, 2> generic{{{"confidence", -1}, {"view_count", -1}}};
  if (!cloud.confidence.empty())
    generic[0].second = add(Attribute::GENERIC, 1, draco::DT_UINT8, cloud.confidence.data());
  if (!cloud.view_counts.empty())
    generic[1].second = add(Attribute::GENERIC, 1, draco::DT_UINT8, cloud.view_counts.data());
  const std::unique_ptr<draco::PointCloud> points = builder.Finalize(false);
  if (!points) throw OutputError(path + ": Draco takes no such points");
  for (const auto& [name, attribute] : generic) {
    if (attribute < 0) continue;
    auto metadata = std::make_unique<draco::AttributeMetadata>();
    metadata->AddEntryString("name", name);
    points->AddAttributeMetadata(attribute, std::move(metadata));
  }

  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::POINT_CLOUD_KD_TREE_ENCODING);
  encoder.SetSpeedOptions(5, 5);
  const auto range = static_cast<float>(cloud.step * static_cast<double>((std::int64_t{1} << bits) - 1));
  encoder.SetAttributeExplicitQuantization(Attribute::POSITION, bits, 3, least.data(), range);
  encoder.SetAttributeQuantization(Attribute::NORMAL, 10);
  draco::EncoderBuffer buffer;
  if (const draco::Status status = encoder.EncodePointCloudToBuffer(*points, &buffer); !status.ok())
    throw OutputError(path + ": cannot be encoded: " + status.error_msg_string());
  writeFile(path, std::string(buffer.data(), buffer.size()));
}

}  // namespace fuse_flow::io

#else

namespace fuse_flow::io {

bool hasDraco() { return false; }

void writeDraco(const std::string& path, const stream::StreamedCloud&) {
  throw OutputError(path +
                    ": cannot be written, since FUSE-Flow was built without Draco; install libdraco-dev, and build it "
                    "again");
}

}  // namespace fuse_flow::io

#endif
