#include "recordings/messages/rig_messages.h"

#include "recordings/images/jpeg_encode.h"
#include "recordings/messages/ros_writing.h"

#include <fuse_flow/recordings/error.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <set>

namespace fuse_flow::io {
namespace {

// More types, as ROS 2 defines them.
using ros_definitions::of_header;
using ros_definitions::separator;
const std::string image_definition =
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] "
    "data\n" +
    of_header;
const std::string compressed_definition = "std_msgs/Header header\nstring format\nuint8[] data\n" + of_header;
const std::string info_definition =
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] "
    "k\nfloat64[9] "
    "r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n" +
    of_header + separator +
    "sensor_msgs/RegionOfInterest\nuint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n";

#ifdef FUSE_FLOW_WITH_FASTCDR

void putInfo(CdrMessage& message, Nanoseconds time, const std::string& frame, const Intrinsics& K) {
  const Distortion& d = K.distortion;
  const bool rational = d.k4 != 0 || d.k5 != 0 || d.k6 != 0;
  std::vector<double> D{d.k1, d.k2, d.p1, d.p2, d.k3};
  if (rational)
    for (const float k : {d.k4, d.k5, d.k6}) D.push_back(k);
  message.header(time, frame) << static_cast<std::uint32_t>(K.height) << static_cast<std::uint32_t>(K.width)
                              << std::string(rational ? "rational_polynomial" : "plumb_bob") << D;
  for (const double k : {double{K.fx}, 0.0, double{K.cx}, 0.0, double{K.fy}, double{K.cy}, 0.0, 0.0, 1.0}) message << k;
  for (int k = 0; k < 9; ++k) message << (k % 4 == 0 ? 1.0 : 0.0);
  for (const double p :
       {double{K.fx}, 0.0, double{K.cx}, 0.0, 0.0, double{K.fy}, double{K.cy}, 0.0, 0.0, 0.0, 1.0, 0.0})
    message << p;
  for (int k = 0; k < 6; ++k) message << std::uint32_t{0};  // no binning, no region of interest
  message << false;
}

bool isMillimetres(const Camera& camera) { return camera.depth_scale == 0.001f; }

#endif

}  // namespace

std::string nameInRos(std::string name) {
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) ? "camera_" + name : name;
}

namespace {

/** \brief Numbers of three bits a nibble, whose fourth bit says that more follow; eight nibbles a word, the first one highest. */
class NibbleWriter {
 public:
  /** \param out has room for all */
  explicit NibbleWriter(char* out) : begin_(out), out_(out) {}

  void put(std::uint32_t value) {
    if (value < 8) {
      push(value, 4);
    } else if (value < 64) {  // most differences of neighbours
      push((value & 7u) << 4 | 0x80u | value >> 3, 8);
    } else {
      for (; value >= 8; value >>= 3) push((value & 7u) | 8u, 4);
      push(value, 4);
    }
  }
  /** \returns how many bytes were written, whole words */
  std::size_t finish() {
    if (bits_ > 0) push(0, 32 - bits_);
    return static_cast<std::size_t>(out_ - begin_);
  }

 private:
  void push(std::uint32_t nibbles, int bits) {
    word_ = word_ << bits | nibbles;
    bits_ += bits;
    if (bits_ < 32) return;
    bits_ -= 32;
    const auto full = static_cast<std::uint32_t>(word_ >> bits_);
    std::memcpy(out_, &full, sizeof full);
    out_ += sizeof full;
  }

  char *begin_, *out_;
  std::uint64_t word_{0};
  int bits_{0};  // of word_ that are not written
};

/** \brief Appends encodeRvl() of an image. */
void appendRvl(const DepthImage& image, std::string& to) {
  const std::size_t at_first = to.size();
  const std::uint16_t* depth = image.data.data();
  const std::size_t count = image.data.size();
  // At most 7 nibbles a pixel: 6 of its difference, and one of the length of its run, which takes no more nibbles than it has pixels.
  to.resize(at_first + 4 * count + 64);
  NibbleWriter writer(to.data() + at_first);
  std::int32_t last = 0;
  for (std::size_t at = 0; at < count;) {
    const std::size_t zeros_from = at;
    while (at < count && depth[at] == 0) ++at;
    writer.put(static_cast<std::uint32_t>(at - zeros_from));
    const std::size_t from = at;
    while (at < count && depth[at] != 0) ++at;
    writer.put(static_cast<std::uint32_t>(at - from));
    for (std::size_t k = from; k < at; ++k) {
      const std::int32_t delta = depth[k] - last;
      writer.put(static_cast<std::uint32_t>(delta * 2) ^ (delta < 0 ? ~std::uint32_t(0) : 0));
      last = depth[k];
    }
  }
  to.resize(at_first + writer.finish());
}

}  // namespace

std::string encodeRvl(const DepthImage& image) {
  std::string words;
  appendRvl(image, words);
  return words;
}

#ifndef FUSE_FLOW_WITH_FASTCDR

RigMessages::RigMessages(const std::string& path, const std::vector<Camera>& cameras, const std::vector<bool>&,
                         const Options& options)
    : cameras_(cameras), options_(options), writer_(path, options.compression) {
  throw InputError(path + ": FUSE-Flow was built without Fast CDR; install libfastcdr-dev, and build it again");
}
void RigMessages::writeCalibration(Nanoseconds) {}
std::vector<RigMessages::Encoded> RigMessages::encode(std::size_t, Nanoseconds, const LoadedView&) const { return {}; }

#else

RigMessages::RigMessages(const std::string& path, const std::vector<Camera>& cameras,
                         const std::vector<bool>& has_color, const Options& options)
    : cameras_(cameras), options_(options), writer_(path, options.compression) {
  std::set<std::string> names;
  std::string corrected, in_float;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    const Camera& camera = cameras[k];
    Channels channels;
    channels.name = nameInRos(camera.name);
    if (!names.insert(channels.name).second)
      throw OutputError(path + ": two cameras are called '" + channels.name + "' in ROS, must be different");
    const std::string prefix = "/" + channels.name;
    if (isMillimetres(camera))
      channels.depth = writer_.addChannel(prefix + "/depth/image_raw/compressedDepth",
                                          "sensor_msgs/msg/CompressedImage", compressed_definition);
    channels.float_depth = writer_.addChannel(prefix + "/depth/image_raw", "sensor_msgs/msg/Image", image_definition);
    channels.depth_info =
        writer_.addChannel(prefix + "/depth/camera_info", "sensor_msgs/msg/CameraInfo", info_definition);
    if (has_color[k]) {
      channels.color = writer_.addChannel(prefix + "/color/image_raw/compressed", "sensor_msgs/msg/CompressedImage",
                                          compressed_definition);
      channels.color_info =
          writer_.addChannel(prefix + "/color/camera_info", "sensor_msgs/msg/CameraInfo", info_definition);
    }
    channels_.push_back(channels);
    const bool more = !camera.depth_correction.empty() || camera.multipath.modulation_frequency > 0 || camera.noise;
    if (more) corrected += (corrected.empty() ? "'" : ", '") + camera.name + "'";
    if (!isMillimetres(camera)) in_float += (in_float.empty() ? "'" : ", '") + camera.name + "'";
  }
  if (!corrected.empty())
    warnings_.push_back("depth correction, multipath and noise of " + corrected +
                        " have no place in such a file; --poses with the rig.json that has them gives them back");
  if (!in_float.empty())
    warnings_.push_back("depth of " + in_float + " is not in millimetres, and is written in metres, in float");
  tf_ = writer_.addChannel("/tf_static", "tf2_msgs/msg/TFMessage", ros_definitions::transforms);
}

void RigMessages::writeCalibration(Nanoseconds time) {
  CdrMessage tf(1024 * (1 + cameras_.size()));
  std::uint32_t transforms = 0;
  for (std::size_t k = 0; k < cameras_.size(); ++k) transforms += cameras_[k].color && channels_[k].color ? 2 : 1;
  tf << transforms;
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    const Channels& c = channels_[k];
    const Camera& camera = cameras_[k];
    const std::string depth_frame = c.name + "_depth", color_frame = camera.color ? c.name + "_color" : depth_frame;
    putTransform(tf, time, "world", depth_frame, camera.T_world_camera);
    if (camera.color && c.color) putTransform(tf, time, depth_frame, color_frame, camera.color->T_depth_color);
    CdrMessage info;
    putInfo(info, time, depth_frame, camera.intrinsics);
    writer_.write(c.depth_info, time, info.view());
    if (!c.color) continue;
    CdrMessage color_info;
    putInfo(color_info, time, color_frame, camera.color ? camera.color->intrinsics : camera.intrinsics);
    writer_.write(c.color_info, time, color_info.view());
  }
  writer_.write(tf_, time, tf.view());
}

std::vector<RigMessages::Encoded> RigMessages::encode(std::size_t camera, Nanoseconds time,
                                                      const LoadedView& images) const {
  std::vector<Encoded> messages;
  const Channels& c = channels_[camera];
  const std::string depth_frame = c.name + "_depth";
  if (!images.depth16.empty() && c.depth) {
    std::string data(12, '\0');  // an enumeration that nobody sets, and parameters for float depth
    for (const std::uint32_t side :
         {static_cast<std::uint32_t>(images.depth16.width), static_cast<std::uint32_t>(images.depth16.height)})
      data.append(reinterpret_cast<const char*>(&side), sizeof side);
    appendRvl(images.depth16, data);
    CdrMessage message;
    message.header(time, depth_frame) << std::string("16UC1; compressedDepth rvl");
    messages.push_back({c.depth, time, message.endingWith(data.data(), data.size())});
  } else if (!images.depth16.empty() || !images.depth32.empty()) {
    FloatImage metres;
    if (!images.depth16.empty()) {
      metres.resize(images.depth16.width, images.depth16.height);
      const float scale = cameras_[camera].depth_scale;
      std::transform(images.depth16.data.begin(), images.depth16.data.end(), metres.data.begin(),
                     [&](std::uint16_t raw) { return raw == 65535 ? 0.0f : static_cast<float>(raw) * scale; });
    }
    const FloatImage& depth = metres.empty() ? images.depth32 : metres;
    CdrMessage message;
    message.header(time, depth_frame) << static_cast<std::uint32_t>(depth.height)
                                      << static_cast<std::uint32_t>(depth.width) << std::string("32FC1")
                                      << std::uint8_t{0} << static_cast<std::uint32_t>(depth.width * sizeof(float));
    messages.push_back({c.float_depth, time, message.endingWith(depth.data.data(), depth.data.size() * sizeof(float))});
  }
  if (images.color.empty() || !c.color) return messages;
  const std::string jpeg = encodeJpeg(images.color, options_.color_quality);
  CdrMessage message;
  message.header(time, cameras_[camera].color ? c.name + "_color" : depth_frame)
      << std::string("rgb8; jpeg compressed bgr8");
  messages.push_back({c.color, time, message.endingWith(jpeg.data(), jpeg.size())});
  return messages;
}

#endif

RigMessages::~RigMessages() = default;

void RigMessages::write(const std::vector<Encoded>& messages) {
  if (messages.empty()) return;
  if (!calibrated_) writeCalibration(messages.front().time);
  calibrated_ = true;
  for (const Encoded& message : messages) writer_.write(message.channel, message.time, message.bytes);
}

void RigMessages::write(Nanoseconds time, const LoadedFrame& frame) {
  for (std::size_t k = 0; k < cameras_.size(); ++k) write(encode(k, time, frame.images[k]));
}

void RigMessages::finish() { writer_.finish(); }

}  // namespace fuse_flow::io
