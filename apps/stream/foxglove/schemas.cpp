#include "stream/foxglove/schemas.h"

#include "stream/foxglove/protobuf_writer.h"

#include <openssl/evp.h>

#include <vector>

namespace fuse_flow::stream::foxglove {

namespace {

/** \brief Types of fields, by their numbers in descriptor.proto. */
enum Type : std::uint32_t {
  kDouble = 1,
  kInt64 = 3,
  kInt32 = 5,
  kFixed32 = 7,
  kString = 9,
  kMessage = 11,
  kBytes = 12,
  kEnum = 14
};

struct Field {
  const char* name;
  std::uint32_t number;
  Type type;
  const char* type_name;  ///< of a message or an enumeration; else null
  bool repeated;
};

struct MessageType {
  const char* name;
  std::vector<Field> fields;
};

const char* const kTimestamp = ".google.protobuf.Timestamp";

const MessageType kVector{
    "Vector3",
    {{"x", 1, kDouble, nullptr, false}, {"y", 2, kDouble, nullptr, false}, {"z", 3, kDouble, nullptr, false}}};
const MessageType kQuaternion{"Quaternion",
                              {{"x", 1, kDouble, nullptr, false},
                               {"y", 2, kDouble, nullptr, false},
                               {"z", 3, kDouble, nullptr, false},
                               {"w", 4, kDouble, nullptr, false}}};
const MessageType kPose{"Pose",
                        {{"position", 1, kMessage, ".foxglove.Vector3", false},
                         {"orientation", 2, kMessage, ".foxglove.Quaternion", false}}};
const MessageType kPackedField{"PackedElementField",
                               {{"name", 1, kString, nullptr, false},
                                {"offset", 2, kFixed32, nullptr, false},
                                {"type", 3, kEnum, ".foxglove.PackedElementField.NumericType", false}}};
const MessageType kPointCloud{"PointCloud",
                              {{"timestamp", 1, kMessage, kTimestamp, false},
                               {"frame_id", 2, kString, nullptr, false},
                               {"pose", 3, kMessage, ".foxglove.Pose", false},
                               {"point_stride", 4, kFixed32, nullptr, false},
                               {"fields", 5, kMessage, ".foxglove.PackedElementField", true},
                               {"data", 6, kBytes, nullptr, false}}};
const MessageType kTransform{"FrameTransform",
                             {{"timestamp", 1, kMessage, kTimestamp, false},
                              {"parent_frame_id", 2, kString, nullptr, false},
                              {"child_frame_id", 3, kString, nullptr, false},
                              {"translation", 4, kMessage, ".foxglove.Vector3", false},
                              {"rotation", 5, kMessage, ".foxglove.Quaternion", false}}};
const MessageType kTransforms{"FrameTransforms", {{"transforms", 1, kMessage, ".foxglove.FrameTransform", true}}};
const MessageType kCalibration{"CameraCalibration",
                               {{"timestamp", 1, kMessage, kTimestamp, false},
                                {"width", 2, kFixed32, nullptr, false},
                                {"height", 3, kFixed32, nullptr, false},
                                {"distortion_model", 4, kString, nullptr, false},
                                {"D", 5, kDouble, nullptr, true},
                                {"K", 6, kDouble, nullptr, true},
                                {"R", 7, kDouble, nullptr, true},
                                {"P", 8, kDouble, nullptr, true},
                                {"frame_id", 9, kString, nullptr, false}}};
const MessageType kImage{"CompressedImage",
                         {{"timestamp", 1, kMessage, kTimestamp, false},
                          {"data", 2, kBytes, nullptr, false},
                          {"format", 3, kString, nullptr, false},
                          {"frame_id", 4, kString, nullptr, false}}};

ProtobufWriter numericTypes() {
  ProtobufWriter result;
  result.text(1, "NumericType");
  std::uint64_t number = 0;
  for (const char* name : {"UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64"})
    result.message(2, ProtobufWriter().text(1, name).whole(2, number++));
  return result;
}

/** \brief A DescriptorProto. */
ProtobufWriter descriptorOf(const MessageType& type) {
  ProtobufWriter result;
  result.text(1, type.name);
  for (const Field& field : type.fields) {
    ProtobufWriter of_field;
    of_field.text(1, field.name).whole(3, field.number).whole(4, field.repeated ? 3 : 1).whole(5, field.type);
    if (field.type_name) of_field.text(6, field.type_name);
    result.message(2, of_field);
  }
  if (&type == &kPackedField) result.message(4, numericTypes());
  return result;
}

/** \brief A FileDescriptorProto. */
ProtobufWriter fileOf(const std::string& name, const std::string& package, const std::vector<std::string>& needs,
                      const std::vector<const MessageType*>& types) {
  ProtobufWriter result;
  result.text(1, name).text(2, package);
  for (const std::string& each : needs) result.text(3, each);
  for (const MessageType* type : types) result.message(4, descriptorOf(*type));
  result.text(12, "proto3");
  return result;
}

/** \param types the last one is what the schema is of */
Schema schemaOf(const std::vector<const MessageType*>& types) {
  const std::string name = types.back()->name, time_file = "google/protobuf/timestamp.proto";
  const MessageType timestamp{"Timestamp",
                              {{"seconds", 1, kInt64, nullptr, false}, {"nanos", 2, kInt32, nullptr, false}}};
  const std::string set = ProtobufWriter()
                              .message(1, fileOf(time_file, "google.protobuf", {}, {&timestamp}))
                              .message(1, fileOf("foxglove/" + name + ".proto", "foxglove", {time_file}, types))
                              .bytes();
  std::string base64(4 * ((set.size() + 2) / 3) + 1, '\0');  // with the zero that it ends with
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(base64.data()), reinterpret_cast<const unsigned char*>(set.data()),
                  static_cast<int>(set.size()));
  base64.pop_back();
  return {"foxglove." + name, base64};
}

}  // namespace

const Schema& pointCloudSchema() {
  static const Schema schema = schemaOf({&kVector, &kQuaternion, &kPose, &kPackedField, &kPointCloud});
  return schema;
}

const Schema& transformsSchema() {
  static const Schema schema = schemaOf({&kVector, &kQuaternion, &kTransform, &kTransforms});
  return schema;
}

const Schema& calibrationSchema() {
  static const Schema schema = schemaOf({&kCalibration});
  return schema;
}

const Schema& imageSchema() {
  static const Schema schema = schemaOf({&kImage});
  return schema;
}

}  // namespace fuse_flow::stream::foxglove
