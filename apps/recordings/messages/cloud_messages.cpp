#include "recordings/messages/cloud_messages.h"

#include "recordings/messages/rig_messages.h"
#include "recordings/messages/ros_writing.h"

#include <fuse_flow/recordings/error.h>

#include <cstring>
#include <set>

namespace fuse_flow::io {

void CloudMessages::describe(const std::string& frame, const std::vector<Camera>& cameras) {
  frame_ = frame;
  cameras_ = cameras;
  described_ = false;
}

#ifndef FUSE_FLOW_WITH_FASTCDR

CloudMessages::CloudMessages(const std::string& path, const std::string& compression) : writer_(path, compression) {
  throw InputError(path + ": FUSE-Flow was built without Fast CDR; install libfastcdr-dev, and build it again");
}
void CloudMessages::writeTransforms(Nanoseconds) {}
void CloudMessages::write(Nanoseconds, const CloudArrays&) {}

#else

namespace {

// sensor_msgs/msg/PointField
constexpr std::uint8_t field_of_uint32 = 6, field_of_float32 = 7;

const std::string cloud_definition =
    "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool "
    "is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n" +
    ros_definitions::of_header + ros_definitions::separator +
    "sensor_msgs/PointField\nuint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 "
    "UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n";

struct CloudField {
  std::string name;
  std::uint8_t type;
};

/** \brief Each of four bytes, of the types that PCL's point types have, which it compares when it converts a message. */
std::vector<CloudField> fieldsOf(const CloudArrays& cloud) {
  std::vector<CloudField> fields;
  for (const char* name : {"x", "y", "z"}) fields.push_back({name, field_of_float32});
  if (cloud.colors) fields.push_back({"rgb", field_of_float32});
  if (cloud.confidence) fields.push_back({"confidence", field_of_float32});
  if (cloud.view_counts) fields.push_back({"view_count", field_of_uint32});
  if (cloud.normals)
    for (const char* name : {"normal_x", "normal_y", "normal_z"}) fields.push_back({name, field_of_float32});
  return fields;
}

template <typename Value>
char* putValues(char* to, const Value* values, std::size_t count) {
  std::memcpy(to, values, count * sizeof(Value));
  return to + count * sizeof(Value);
}

std::string packedPoints(const CloudArrays& cloud, std::size_t step) {
  std::string data(cloud.points * step, '\0');
  char* to = data.data();
  for (std::size_t i = 0; i < cloud.points; ++i) {
    to = putValues(to, cloud.positions + 3 * i, 3);
    if (cloud.colors) {
      const std::uint8_t* c = cloud.colors + 3 * i;
      const std::uint8_t bgra[4] = {c[2], c[1], c[0], 255};
      to = putValues(to, bgra, 4);
    }
    if (cloud.confidence) {
      const float confidence = static_cast<float>(cloud.confidence[i]) / 255.0f;
      to = putValues(to, &confidence, 1);
    }
    if (cloud.view_counts) {
      const std::uint32_t count = cloud.view_counts[i];
      to = putValues(to, &count, 1);
    }
    if (cloud.normals) to = putValues(to, cloud.normals + 3 * i, 3);
  }
  return data;
}

}  // namespace

CloudMessages::CloudMessages(const std::string& path, const std::string& compression)
    : writer_(path, compression),
      points_(writer_.addChannel("/points", "sensor_msgs/msg/PointCloud2", cloud_definition)),
      tf_(writer_.addChannel("/tf_static", "tf2_msgs/msg/TFMessage", ros_definitions::transforms)) {}

void CloudMessages::writeTransforms(Nanoseconds time) {
  CdrMessage tf(1024 * (1 + cameras_.size()));
  tf << static_cast<std::uint32_t>(cameras_.size());
  std::set<std::string> names{frame_};
  for (const Camera& camera : cameras_) {
    const std::string wanted = nameInRos(camera.name);
    std::string name = wanted;
    for (int k = 2; !names.insert(name).second; ++k) name = wanted + "_" + std::to_string(k);
    putTransform(tf, time, frame_, name, camera.T_world_camera);
  }
  writer_.write(tf_, time, tf.view());
}

void CloudMessages::write(Nanoseconds time, const CloudArrays& cloud) {
  if (!described_) writeTransforms(time);
  described_ = true;
  const std::vector<CloudField> fields = fieldsOf(cloud);
  const std::size_t step = 4 * fields.size();
  CdrMessage message;
  message.header(time, frame_) << std::uint32_t{1} << static_cast<std::uint32_t>(cloud.points)
                               << static_cast<std::uint32_t>(fields.size());
  std::uint32_t offset = 0;
  for (const CloudField& field : fields) {
    message << field.name << offset << field.type << std::uint32_t{1};
    offset += 4;
  }
  message << false << static_cast<std::uint32_t>(step) << static_cast<std::uint32_t>(step * cloud.points);
  const std::string data = packedPoints(cloud, step);
  std::string bytes = message.endingWith(data.data(), data.size());
  bytes += '\1';  // dense: no point lacks a coordinate
  writer_.write(points_, time, bytes);
}

#endif

}  // namespace fuse_flow::io
