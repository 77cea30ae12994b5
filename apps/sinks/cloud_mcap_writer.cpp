#include "sinks/cloud_mcap_writer.h"

namespace fuse_flow::io {

void CloudMcapWriter::describe(const stream::Description& description) {
  messages_.describe(description.frame, description.cameras);
}

void CloudMcapWriter::write(const stream::StreamedCloud& cloud) {
  const auto of = [](const auto& array) { return array.empty() ? nullptr : array.data(); };
  CloudArrays arrays;
  arrays.points = cloud.size();
  arrays.positions = of(cloud.positions);
  arrays.colors = of(cloud.colors);
  arrays.confidence = of(cloud.confidence);
  arrays.view_counts = of(cloud.view_counts);
  arrays.normals = of(cloud.normals);
  messages_.write(cloud.times.captured != 0 ? cloud.times.captured : cloud.times.encoded, arrays);
}

}  // namespace fuse_flow::io
