#include "recordings/messages/camera_topics.h"

#include "recordings/files/cut_short.h"
#include "recordings/messages/camera_lens.h"
#include "recordings/messages/frame_tree.h"
#include "recordings/messages/image_messages.h"
#include "recordings/streams/time_matching.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <tuple>

namespace fuse_flow::io {
namespace {

constexpr std::size_t kHeaderBytes = 4096;  // a header and an encoding are shorter

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool isRaw(const Topic& topic) { return topic.type == "sensor_msgs/Image"; }
bool isImageTopic(const Topic& topic) { return isRaw(topic) || topic.type == "sensor_msgs/CompressedImage"; }

/** \brief A message, and what reads its fields. */
struct Opened {
  std::string bytes;
  std::unique_ptr<WireReader> in;
};

std::unique_ptr<Opened> openMessage(MessageLog& log, std::size_t topic, std::size_t message) {
  auto opened = std::make_unique<Opened>();
  log.read(topic, message, opened->bytes);
  const Topic& t = log.topics()[topic];
  opened->in =
      makeWireReader(t.wire, log.path() + ": message " + std::to_string(message) + " of " + t.name, opened->bytes);
  return opened;
}

std::string parentOf(const std::string& topic) { return topic.substr(0, topic.find_last_of('/')); }

/** \brief Without what image_transport adds: "/camera/depth/image_raw". */
std::string baseName(const Topic& topic) {
  for (const char* transport : {"/compressedDepth", "/compressed"})
    if (endsWith(topic.name, transport)) return topic.name.substr(0, topic.name.size() - std::string(transport).size());
  return topic.name;
}

/** \brief Whether it was warped to the other sensor's pixels: "aligned_depth_to_color", "rgb_to_depth", "depth_registered". */
bool isWarped(const std::string& base) {
  return contains(base, "aligned") || contains(base, "registered") || contains(base, "_to_");
}
bool isRectified(const std::string& base) { return contains(base.substr(base.find_last_of('/') + 1), "rect"); }

/** \brief A RealSense's own bag calls its streams so: "/device_0/sensor_0/Depth_0/image/data". */
bool isRealSense(const std::string& topic) { return topic.rfind("/device_", 0) == 0 && contains(topic, "/sensor_"); }
std::string realSenseStream(const std::string& topic) { return topic.substr(0, topic.find("/image/data")); }

/** \brief The namespace of the device that a topic of images belongs to: what is before the first part that names a sensor. */
std::string deviceOf(const std::string& base) {
  if (isRealSense(base)) return base.substr(0, base.find('/', 1));
  std::string device;
  std::size_t at = 0;
  while (at < base.size()) {
    const std::size_t end = std::min(base.find('/', at + 1), base.size());
    std::string part = base.substr(at, end - at);
    std::transform(part.begin(), part.end(), part.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (const char* sensor : {"depth", "color", "colour", "rgb", "image", "infra", "aligned"})
      if (contains(part, sensor)) return device;
    if (part == "/ir") return device;
    device += base.substr(at, end - at);
    at = end;
  }
  return parentOf(base);
}

/** \brief The images of a topic. */
class TopicTrack : public ImageTrack {
 public:
  /** \param kept the numbers of its messages, of ascending stamps */
  TopicTrack(std::shared_ptr<MessageLog> log, std::size_t topic, bool depth, const Intrinsics& K,
             std::vector<Nanoseconds> stamps, std::vector<std::size_t> kept)
      : log_(std::move(log)), topic_(topic), depth_(depth), K_(K), stamps_(std::move(stamps)), kept_(std::move(kept)) {}

  const std::vector<Nanoseconds>& stamps() const override { return stamps_; }

  void fetch(std::size_t image, std::string& bytes) override { log_->read(topic_, kept_[image], bytes); }

  void decode(std::size_t image, const std::string& bytes, LoadedView& into) const override {
    const Topic& topic = log_->topics()[topic_];
    const std::string name = log_->path() + ": message " + std::to_string(kept_[image]) + " of " + topic.name;
    const std::unique_ptr<WireReader> in = makeWireReader(topic.wire, name, bytes);
    const SizeCheck check = [&](int width, int height) {
      if (width == K_.width && height == K_.height) return;
      throw InputError(name + ": is " + std::to_string(width) + "x" + std::to_string(height) +
                       " pixels, its camera is calibrated for " + std::to_string(K_.width) + "x" +
                       std::to_string(K_.height));
    };
    if (isRaw(topic))
      decodeMessage(name, readImage(*in), into, check);
    else
      decodeMessage(name, readCompressedImage(*in), into, check);
  }

 private:
  template <typename Message>
  void decodeMessage(const std::string& name, const Message& message, LoadedView& into, const SizeCheck& check) const {
    if (depth_)
      decodeDepth(name, message, into, check);
    else
      decodeColor(name, message, into.color, check);
  }

  std::shared_ptr<MessageLog> log_;
  std::size_t topic_;
  bool depth_;
  Intrinsics K_;
  std::vector<Nanoseconds> stamps_;
  std::vector<std::size_t> kept_;
};

/** \brief A topic of images, as a choice for a camera. */
struct ImageTopic {
  std::size_t topic{0};
  std::string base;
  std::string frame;  ///< of its messages
};

/** \brief The choices that a device has. */
struct Device {
  std::vector<ImageTopic> depth, color;
};

/** \brief All about one log while it is opened. */
class Discovery {
 public:
  Discovery(std::shared_ptr<MessageLog> log, bool use_color, std::vector<std::string>& warnings)
      : log_(std::move(log)), use_color_(use_color), warnings_(warnings) {}

  std::vector<RecordedCamera> run(const std::string& name) {
    readFrames();
    listImages();
    joinColor();
    if (devices_.empty()) {
      const std::vector<std::string>& damage = log_->warnings();
      throw InputError(damage.empty() ? log_->path() + ": has no images of a depth camera" + others()
                                      : damage[0] + "; there are no images of a depth camera in the rest");
    }
    std::vector<RecordedCamera> cameras;
    for (const auto& [device, choices] : devices_)
      cameras.push_back(open(devices_.size() == 1 ? name : plainName(device, name), choices));
    sayUnused();
    return cameras;
  }

 private:
  /** \brief "/robot/front" is robot_front. */
  static std::string plainName(const std::string& device, const std::string& otherwise) {
    std::string name = device.substr(std::min<std::size_t>(1, device.size()));
    std::replace(name.begin(), name.end(), '/', '_');
    return name.empty() ? otherwise : name;
  }

  /** \brief What there is instead, for who has the wrong file. */
  std::string others() const {
    std::set<std::string> types;
    for (const Topic& topic : log_->topics()) types.insert(topic.type);
    std::string list;
    for (const std::string& type : types) list += (list.empty() ? "; it has " : ", ") + cutShort(type);
    return list + "; must have sensor_msgs/Image or CompressedImage of depth (16UC1, 32FC1), and CameraInfo";
  }

  void readFrames() {
    const std::vector<Topic>& topics = log_->topics();
    std::set<std::string> moving;
    for (std::size_t t = 0; t < topics.size(); ++t) {
      if (topics[t].type != "tf2_msgs/TFMessage" && topics[t].type != "tf/tfMessage") continue;
      // Of what tf repeats, the first says where a camera stands; the others, whether it moves.
      for (std::size_t message = 0; message < topics[t].times.size(); ++message) {
        const auto opened = openMessage(*log_, t, message);
        for (const TransformMessage& transform : readTransforms(*opened->in))
          if (frames_.add(transform)) moving.insert(transform.child);
      }
    }
    moving_ = std::move(moving);
  }

  void listImages() {
    const std::vector<Topic>& topics = log_->topics();
    for (std::size_t t = 0; t < topics.size(); ++t) {
      if (!isImageTopic(topics[t]) || topics[t].times.empty()) continue;
      const auto opened = openMessage(*log_, t, 0);
      ImageTopic image{t, baseName(topics[t]), ""};
      ImageKind kind = ImageKind::Neither;
      if (isRaw(topics[t])) {
        const ImageMessage message = readImage(*opened->in);
        image.frame = message.header.frame;
        kind = kindOf(message, topics[t].name);
      } else {
        const CompressedImageMessage message = readCompressedImage(*opened->in);
        image.frame = message.header.frame;
        kind = kindOf(message, topics[t].name);
      }
      if (kind == ImageKind::Depth) devices_[deviceOf(image.base)].depth.push_back(image);
      if (kind == ImageKind::Color) devices_[deviceOf(image.base)].color.push_back(image);
      if (kind == ImageKind::Neither) unused_.push_back(topics[t].name);
    }
  }

  /** \brief Colour in a namespace below that of a device with depth is a choice for it, as the left image of a stereo camera is. */
  void joinColor() {
    for (auto device = devices_.begin(); device != devices_.end();) {
      const std::string& name = device->first;
      Device* above = nullptr;  // the longest comes last
      for (auto& [other, choices] : devices_)
        if (other.size() < name.size() && name.compare(0, other.size() + 1, other + "/") == 0 && !choices.depth.empty())
          above = &choices;
      if (!device->second.depth.empty() || !above) {
        ++device;
        continue;
      }
      above->color.insert(above->color.end(), device->second.color.begin(), device->second.color.end());
      device = devices_.erase(device);
    }
  }

  std::optional<CameraInfoMessage> infoOf(const ImageTopic& image) const {
    const std::string name = isRealSense(image.base) ? realSenseStream(image.base) + "/info/camera_info"
                                                     : parentOf(image.base) + "/camera_info";
    const std::optional<std::size_t> topic = log_->find(name);
    if (!topic || log_->topics()[*topic].times.empty()) return std::nullopt;
    return readCameraInfo(*openMessage(*log_, *topic, 0)->in);
  }

  /** \brief From the colour camera to the depth camera; absent: nothing says it. */
  std::optional<Eigen::Isometry3d> colorPose(const ImageTopic& depth, const ImageTopic& color) const {
    if (isRealSense(depth.base)) {
      const auto from_depth = realSensePose(depth), from_color = realSensePose(color);
      if (!from_depth || !from_color) return std::nullopt;
      return *from_depth * from_color->inverse();
    }
    if (depth.frame == color.frame) return Eigen::Isometry3d::Identity();
    return frames_.between(depth.frame, color.frame);
  }

  /** \brief From the device's reference to a stream of it, as RealSense's extrinsics are. */
  std::optional<Eigen::Isometry3d> realSensePose(const ImageTopic& image) const {
    const std::string prefix = realSenseStream(image.base) + "/tf/";
    const std::vector<Topic>& topics = log_->topics();
    for (std::size_t t = 0; t < topics.size(); ++t)
      if (topics[t].name.rfind(prefix, 0) == 0 && !topics[t].times.empty())
        return readTransform(*openMessage(*log_, t, 0)->in);
    return std::nullopt;
  }

  /** \brief Metres per unit of a depth topic: a RealSense says it, others have millimetres. */
  float unitOf(const ImageTopic& depth) const {
    constexpr float millimetres = 0.001f;
    if (!isRealSense(depth.base)) return millimetres;
    const std::string sensor = parentOf(realSenseStream(depth.base));
    for (const char* option : {"/option/Depth_Units/value", "/option/Depth Units/value"}) {
      const std::optional<std::size_t> topic = log_->find(sensor + option);
      if (!topic || log_->topics()[*topic].times.empty()) continue;
      const float unit = openMessage(*log_, *topic, 0)->in->f32();
      if (unit > 0 && std::isfinite(unit)) return unit;
    }
    const auto opened = openMessage(*log_, depth.topic, 0);
    readImage(*opened->in);
    if (const std::string_view behind = opened->in->rest(); behind.size() == sizeof(float)) {
      float unit = 0;
      std::memcpy(&unit, behind.data(), sizeof unit);
      if (unit > 0 && std::isfinite(unit)) return unit;
    }
    warnings_.push_back(log_->path() +
                        ": does not say the unit of depth, millimetres are taken; --depth-scale gives another");
    return millimetres;
  }

  /** \brief The best first: not warped, more of them, not compressed. */
  void sort(std::vector<ImageTopic>& images) const {
    const auto rank = [this](const ImageTopic& image) {
      const Topic& topic = log_->topics()[image.topic];
      return std::make_tuple(isWarped(image.base), -static_cast<long long>(topic.times.size()), !isRaw(topic));
    };
    std::stable_sort(images.begin(), images.end(),
                     [&](const ImageTopic& a, const ImageTopic& b) { return rank(a) < rank(b); });
  }

  std::unique_ptr<ImageTrack> track(const ImageTopic& image, bool depth, const Intrinsics& K) {
    const Topic& topic = log_->topics()[image.topic];
    std::vector<Nanoseconds> stamps;
    std::string start;
    for (std::size_t message = 0; message < topic.times.size(); ++message) {
      log_->readStart(image.topic, message, kHeaderBytes, start);
      stamps.push_back(readHeader(*makeWireReader(topic.wire, log_->path() + ": " + topic.name, start)).stamp);
    }
    if (std::all_of(stamps.begin(), stamps.end(), [](Nanoseconds stamp) { return stamp == 0; })) {
      warnings_.push_back(log_->path() + ": the headers of " + topic.name +
                          " have no time stamps; the times of recording are taken");
      stamps = topic.times;
    }
    std::vector<std::size_t> kept;
    stamps = ascendingStamps(log_->path() + ": " + topic.name, stamps, kept, warnings_);
    return std::make_unique<TopicTrack>(log_, image.topic, depth, K, std::move(stamps), std::move(kept));
  }

  RecordedCamera open(const std::string& name, Device device) {
    RecordedCamera recorded;
    recorded.camera.name = name;
    recorded.file = log_->path();
    recorded.clock = "the clock of headers";
    sort(device.depth);
    sort(device.color);
    const std::optional<Choice> choice = choose(name, device);
    if (!choice) return recorded;  // it has no images then, and is left out
    for (const std::vector<ImageTopic>* images : {&device.depth, &device.color})
      for (const ImageTopic& image : *images)
        if ((!choice->depth || image.topic != choice->depth->topic) &&
            (!choice->color || image.topic != choice->color->topic))
          unused_.push_back(log_->topics()[image.topic].name);
    const ImageTopic& first = choice->depth ? *choice->depth : *choice->color;
    recorded.camera.intrinsics = choice->lens;
    if (choice->depth) {
      recorded.camera.depth_scale = unitOf(*choice->depth);
      recorded.depth = track(*choice->depth, true, choice->lens);
    }
    if (choice->color && choice->depth) recorded.camera.color = choice->color_camera;
    if (choice->color)
      recorded.color =
          track(*choice->color, false, choice->color_camera ? choice->color_camera->intrinsics : choice->lens);
    place(first.frame, recorded);
    return recorded;
  }

  /** \brief What a device is read by. */
  struct Choice {
    std::optional<ImageTopic> depth, color;
    Intrinsics lens;                          ///< of depth, or, without, of colour
    std::optional<ColorCamera> color_camera;  ///< colour is from elsewhere, or of another size
  };

  /** \brief Depth as the sensor measured it with the colour camera beside it, if it is known how they stand; else depth in the pixels of colour, if there is any; else depth alone. */
  std::optional<Choice> choose(const std::string& name, const Device& device) {
    std::optional<Choice> alone;
    for (const ImageTopic& depth : device.depth) {
      const std::optional<CameraInfoMessage> info = infoOf(depth);
      if (!info) continue;
      Choice choice;
      choice.depth = depth;
      std::vector<std::string> said;
      choice.lens = lensOf(log_->path() + ": " + depth.base, *info, isRectified(depth.base), said);
      const bool any_color = use_color_ && chooseColor(device, choice, said);
      if (!alone || any_color) {
        said_ = said;
        alone = choice;
      }
      if (any_color || !use_color_ || device.color.empty()) break;
    }
    if (alone) {
      warnings_.insert(warnings_.end(), said_.begin(), said_.end());
      if (use_color_ && !alone->color && !device.color.empty())
        warnings_.push_back(log_->path() + ": camera '" + name +
                            "': nothing says where its colour camera stands: tf has no way from " +
                            device.color[0].frame + " to " + alone->depth->frame + "; its points have no colour");
      return alone;
    }
    if (!device.depth.empty())
      throw InputError(log_->path() + ": there is no CameraInfo for " + device.depth[0].base + ", must be at " +
                       parentOf(device.depth[0].base) + "/camera_info");
    for (const ImageTopic& color : device.color)
      if (const std::optional<CameraInfoMessage> info = infoOf(color)) {
        Choice choice;
        choice.color = color;
        choice.lens = lensOf(log_->path() + ": " + color.base, *info, isRectified(color.base), warnings_);
        return choice;
      }
    return std::nullopt;
  }

  bool chooseColor(const Device& device, Choice& choice, std::vector<std::string>& said) const {
    for (const ImageTopic& color : device.color) {
      const std::optional<CameraInfoMessage> info = infoOf(color);
      const std::optional<Eigen::Isometry3d> T = colorPose(*choice.depth, color);
      if (!info || !T) continue;
      ColorCamera own;
      own.intrinsics = lensOf(log_->path() + ": " + color.base, *info, isRectified(color.base), said);
      own.T_depth_color = *T;
      const bool same = T->isApprox(Eigen::Isometry3d::Identity(), 1e-9) && sameLens(own.intrinsics, choice.lens);
      choice.color = color;
      if (!same) choice.color_camera = own;
      return true;
    }
    return false;
  }

  static bool sameLens(const Intrinsics& a, const Intrinsics& b) {
    return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
  }

  void place(const std::string& frame, RecordedCamera& recorded) {
    recorded.frame = frame;
    if (!frames_.has(frame)) return;
    recorded.camera.T_world_camera = frames_.toRoot(frame);
    recorded.posed = true;
    recorded.world = frames_.root(frame);
    for (std::string at = frame; frames_.has(at); at = frames_.parent(at))
      if (moving_.count(at) > 0) {
        warnings_.push_back(log_->path() + ": camera '" + recorded.camera.name +
                            "' moves while it records, tf says; it is taken to stay where it was first (" + at + ")");
        break;
      }
  }

  void sayUnused() {
    if (unused_.empty()) return;
    std::string list;
    for (const std::string& topic : unused_) list += (list.empty() ? "" : ", ") + topic;
    warnings_.push_back(log_->path() + ": not used: " + list);
  }

  std::shared_ptr<MessageLog> log_;
  bool use_color_;
  std::vector<std::string>& warnings_;
  FrameTree frames_;
  std::set<std::string> moving_;
  std::map<std::string, Device> devices_;  // by namespace
  std::vector<std::string> unused_;        // topics of images
  std::vector<std::string> said_;
};

}  // namespace

std::vector<RecordedCamera> camerasOf(std::shared_ptr<MessageLog> log, const std::string& name, bool use_color,
                                      std::vector<std::string>& warnings) {
  return Discovery(std::move(log), use_color, warnings).run(name);
}

}  // namespace fuse_flow::io
