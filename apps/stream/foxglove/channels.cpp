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

/** \brief Of each camera a name that no other one has, nor the frame of the clouds: topics and frames are told apart by it. */
std::vector<std::string> namesOf(const Description& description) {
  std::set<std::string> taken{utf8(description.frame)};
  std::vector<std::string> names;
  for (const Camera& camera : description.cameras) {
    const std::string wanted = camera.name.empty() ? "camera" : utf8(camera.name);
    std::string name = wanted;
    for (int k = 2; !taken.insert(name).second; ++k) name = wanted + "_" + std::to_string(k);
    names.push_back(name);
  }
  return names;
}

std::string transformsOf(const Description& description, const std::vector<std::string>& names, std::uint64_t time) {
  ProtobufWriter message;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const Eigen::Isometry3d& T = description.cameras[k].T_world_camera;
    const Eigen::Quaterniond q(T.rotation());
    const Eigen::Vector3d t = T.translation();
    message.message(1, ProtobufWriter()
                           .time(1, time)
                           .text(2, utf8(description.frame))
                           .text(3, names[k])
                           .message(4, ProtobufWriter().real(1, t.x()).real(2, t.y()).real(3, t.z()))
                           .message(5, ProtobufWriter().real(1, q.x()).real(2, q.y()).real(3, q.z()).real(4, q.w())));
  }
  return message.bytes();
}

/** \brief Of a camera without distortion: what is streamed of its lens has none. */
std::string calibrationOf(const Intrinsics& in, const std::string& name, std::uint64_t time) {
  const double fx{in.fx}, fy{in.fy}, cx{in.cx}, cy{in.cy};
  return ProtobufWriter()
      .time(1, time)
      .fixed32(2, static_cast<std::uint32_t>(in.width))
      .fixed32(3, static_cast<std::uint32_t>(in.height))
      .text(4, "plumb_bob")
      .reals(5, {0, 0, 0, 0, 0})
      .reals(6, {fx, 0, cx, 0, fy, cy, 0, 0, 1})
      .reals(7, {1, 0, 0, 0, 1, 0, 0, 0, 1})
      .reals(8, {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0})
      .text(9, name)
      .bytes();
}

}  // namespace

const Topic* Channels::find(std::uint32_t id) const {
  const auto found = std::lower_bound(topics.begin(), topics.end(), id,
                                      [](const Topic& topic, std::uint32_t wanted) { return topic.id < wanted; });
  return found == topics.end() || found->id != id ? nullptr : &*found;
}

Channels channelsOf(const Description& description, std::uint64_t time, const Channels& before) {
  std::map<std::string, const Topic*> old;
  for (const Topic& topic : before.topics) old[topic.name] = &topic;
  Channels channels;
  channels.version = before.version + 1;
  channels.name = description.name.empty() ? "FUSE-Flow" : description.name;
  channels.frame = utf8(description.frame);
  channels.last_id = std::max(before.last_id, kPointsChannel);
  channels.topics.push_back({kPointsChannel, "/points", &pointCloudSchema(), nullptr, 0, 0});
  // The same at the same time is the same: only then was anything changed.
  const auto add = [&](const std::string& name, const Schema& schema, const auto& messageAt) {
    const auto was = old.find(name);
    Topic topic{0, name, &schema, nullptr, channels.version, time};
    topic.id = was == old.end() ? ++channels.last_id : was->second->id;
    if (was != old.end() && messageAt(was->second->time) == *was->second->message) {
      topic = *was->second;
    } else {
      topic.message = std::make_shared<const std::string>(messageAt(time));
    }
    channels.topics.push_back(std::move(topic));
  };
  const std::vector<std::string> names = namesOf(description);
  add("/tf", transformsSchema(), [&](std::uint64_t at) { return transformsOf(description, names, at); });
  for (std::size_t k = 0; k < names.size(); ++k)
    add("/cameras/" + names[k] + "/calibration", calibrationSchema(),
        [&](std::uint64_t at) { return calibrationOf(description.cameras[k].intrinsics, names[k], at); });
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
