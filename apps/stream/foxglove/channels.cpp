#include "stream/foxglove/channels.h"

#include "stream/foxglove/protobuf_writer.h"

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace fuse_flow::stream::foxglove {

namespace {

using Json = nlohmann::json;

std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/** \brief Names come from files of others; texts of Protocol Buffers must be UTF-8. */
std::string utf8(const std::string& text) { return Json::parse(dumped(Json(text))).get<std::string>(); }

/** \brief What a camera is called in topics, and where it stands. */
struct CameraNames {
  std::string name;         ///< its frame, too
  std::string image_frame;  ///< of the camera that takes its images: the same, unless a separate one stands beside
};

/** \brief Of each camera names that no other one has, nor the frame of the clouds: topics and frames are told apart by them. */
std::vector<CameraNames> namesOf(const Description& description) {
  std::set<std::string> taken{utf8(description.frame)};
  const auto unique = [&](const std::string& wanted) {
    std::string name = wanted;
    for (int k = 2; !taken.insert(name).second; ++k) name = wanted + "_" + std::to_string(k);
    return name;
  };
  std::vector<CameraNames> names;
  for (const Camera& camera : description.cameras) {
    const std::string name = unique(camera.name.empty() ? "camera" : utf8(camera.name));
    names.push_back({name, name});
  }
  // After all others: the name of a camera does not depend on whether another one has a colour camera.
  for (std::size_t k = 0; k < names.size(); ++k)
    if (description.cameras[k].color) names[k].image_frame = unique(names[k].name + "_color");
  return names;
}

ProtobufWriter transformOf(const Eigen::Isometry3d& T_parent_child, const std::string& parent, const std::string& child,
                           std::uint64_t time) {
  const Eigen::Quaterniond q(T_parent_child.rotation());
  const Eigen::Vector3d t = T_parent_child.translation();
  return ProtobufWriter()
      .time(1, time)
      .text(2, parent)
      .text(3, child)
      .message(4, ProtobufWriter().real(1, t.x()).real(2, t.y()).real(3, t.z()))
      .message(5, ProtobufWriter().real(1, q.x()).real(2, q.y()).real(3, q.z()).real(4, q.w()));
}

std::string transformsOf(const Description& description, const std::vector<CameraNames>& names, std::uint64_t time) {
  const std::string frame = utf8(description.frame);
  ProtobufWriter message;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const Camera& camera = description.cameras[k];
    message.message(1, transformOf(camera.T_world_camera, frame, names[k].name, time));
    if (camera.color)
      message.message(1, transformOf(camera.color->T_depth_color, names[k].name, names[k].image_frame, time));
  }
  return message.bytes();
}

/** \brief Of the images as they are sent, which are as the camera took them: with its distortion. */
const Intrinsics& imageIntrinsics(const Camera& camera) {
  return camera.color ? camera.color->intrinsics : camera.intrinsics;
}

std::string calibrationOf(const Intrinsics& in, const std::string& frame, std::uint64_t time) {
  const double fx{in.fx}, fy{in.fy}, cx{in.cx}, cy{in.cy};
  const Distortion& d = in.distortion;
  const bool rational = d.k4 != 0 || d.k5 != 0 || d.k6 != 0;
  std::vector<double> D{d.k1, d.k2, d.p1, d.p2, d.k3};
  if (rational) D.insert(D.end(), {d.k4, d.k5, d.k6});
  return ProtobufWriter()
      .time(1, time)
      .fixed32(2, static_cast<std::uint32_t>(in.width))
      .fixed32(3, static_cast<std::uint32_t>(in.height))
      .text(4, rational ? "rational_polynomial" : "plumb_bob")
      .reals(5, D)
      .reals(6, {fx, 0, cx, 0, fy, cy, 0, 0, 1})
      .reals(7, {1, 0, 0, 0, 1, 0, 0, 0, 1})
      .reals(8, {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0})
      .text(9, frame)
      .bytes();
}

}  // namespace

const Topic* Channels::find(std::uint32_t id) const {
  const auto found = std::lower_bound(topics.begin(), topics.end(), id,
                                      [](const Topic& topic, std::uint32_t wanted) { return topic.id < wanted; });
  return found == topics.end() || found->id != id ? nullptr : &*found;
}

bool Channels::hasImages(std::uint32_t id) const {
  return std::any_of(images.begin(), images.end(), [&](const ImageChannel& image) { return image.id == id; });
}

Channels channelsOf(const Description& description, std::uint64_t time, const Channels& before,
                    std::optional<std::size_t> with_images) {
  std::map<std::string, const Topic*> old;
  for (const Topic& topic : before.topics) old[topic.name] = &topic;
  Channels channels;
  channels.version = before.version + 1;
  channels.name = description.name.empty() ? "FUSE-Flow" : description.name;
  channels.frame = utf8(description.frame);
  channels.last_id = std::max(before.last_id, kPointsChannel);
  channels.topics.push_back({kPointsChannel, "/points", &pointCloudSchema(), nullptr, 0, 0});
  const auto idOf = [&](const std::string& name) {
    const auto was = old.find(name);
    return was == old.end() ? ++channels.last_id : was->second->id;
  };
  // The same at the same time is the same: only then was anything changed.
  const auto add = [&](const std::string& name, const Schema& schema, const auto& messageAt) {
    const auto was = old.find(name);
    Topic topic{idOf(name), name, &schema, nullptr, channels.version, time};
    if (was != old.end() && messageAt(was->second->time) == *was->second->message) {
      topic = *was->second;
    } else {
      topic.message = std::make_shared<const std::string>(messageAt(time));
    }
    channels.topics.push_back(std::move(topic));
  };
  const std::vector<CameraNames> names = namesOf(description);
  add("/tf", transformsSchema(), [&](std::uint64_t at) { return transformsOf(description, names, at); });
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::string of_camera = "/cameras/" + names[k].name, image = of_camera + "/image";
    const Intrinsics& intrinsics = imageIntrinsics(description.cameras[k]);
    add(of_camera + "/calibration", calibrationSchema(),
        [&](std::uint64_t at) { return calibrationOf(intrinsics, names[k].image_frame, at); });
    channels.images.push_back({0, names[k].image_frame, intrinsics.width, intrinsics.height});
    if (k != with_images && old.count(image) == 0) continue;
    channels.images.back().id = idOf(image);
    channels.topics.push_back({channels.images.back().id, image, &imageSchema(), nullptr, 0, 0});
  }
  std::sort(channels.topics.begin(), channels.topics.end(), [](const Topic& a, const Topic& b) { return a.id < b.id; });
  return channels;
}

std::string serverInfo(const Channels& channels, const std::string& session) {
  return dumped({{"op", "serverInfo"},
                 {"name", channels.name},
                 {"capabilities", Json::array()},
                 {"metadata", Json::object()},
                 {"sessionId", session}});
}

std::string advertisement(const std::vector<const Topic*>& topics) {
  Json list = Json::array();
  for (const Topic* topic : topics)
    list.push_back({{"id", topic->id},
                    {"topic", topic->name},
                    {"encoding", "protobuf"},
                    {"schemaName", topic->schema->name},
                    {"schemaEncoding", "protobuf"},
                    {"schema", topic->schema->descriptors}});
  return dumped({{"op", "advertise"}, {"channels", list}});
}

std::string unadvertisement(const std::vector<std::uint32_t>& ids) {
  return dumped({{"op", "unadvertise"}, {"channelIds", ids}});
}

std::string statusMessage(int level, const std::string& text) {
  return dumped({{"op", "status"}, {"level", level}, {"message", text}});
}

}  // namespace fuse_flow::stream::foxglove
