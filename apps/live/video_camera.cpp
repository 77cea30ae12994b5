#include "live/video_camera.h"

#include "live/device_kinds.h"

#ifdef FUSE_FLOW_WITH_LIBAV

#include "recordings/files/interrupt.h"
#include "recordings/streams/libav.h"
#include "recordings/streams/video_picture.h"

#include <fuse_flow/recordings/error.h>

extern "C" {
#include <libavcodec/avcodec.h>
#ifdef FUSE_FLOW_WITH_LIBAVDEVICE
#include <libavdevice/avdevice.h>
#endif
#include <libavformat/avformat.h>
}

#include <algorithm>
#include <deque>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <utility>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kWaiting = 4;  // pictures; of more the oldest are given up

/** \brief Names go into messages and recordings: "rtsp://user:secret@host" without what only the camera is to know. */
std::string withoutPassword(const std::string& id) {
  const std::size_t scheme = id.find("://");
  if (scheme == std::string::npos) return id;
  const std::size_t host = scheme + 3, path = id.find('/', host), at = id.rfind('@', path);
  return at == std::string::npos || at < host ? id : id.substr(0, host) + id.substr(at + 1);
}

/** \brief An open input, and a thread that decodes what it delivers. */
class VideoCamera : public Device {
 public:
  VideoCamera(const std::string& id, std::chrono::seconds patience, std::shared_ptr<const std::atomic<bool>> cancelled)
      : Device("video:" + withoutPassword(id)), cancelled_(std::move(cancelled)), deadline_(Clock::now() + patience) {
    open(id);
    if (!decodeNext()) fail("delivers no picture");
    camera_.name = cameraNameOf(name());
    Intrinsics& K = camera_.intrinsics;  // to be replaced: hasIntrinsics()
    K.width = frame_->width;
    K.height = frame_->height;
    K.fx = K.fy = static_cast<float>(K.width);
    K.cx = 0.5f * static_cast<float>(K.width - 1);
    K.cy = 0.5f * static_cast<float>(K.height - 1);
    // Some formats have no times, and libav counts pictures instead, whatever their rate.
    const bool counted = (context_->iformat->flags & AVFMT_NOTIMESTAMPS) != 0;
    first_time_ = counted ? AV_NOPTS_VALUE : frame_->best_effort_timestamp;
    opened_ = Clock::now();
    deadline_.reset();
    thread_ = std::thread([this] { run(); });  // from now on: what nobody takes must not wait in the network
  }
  ~VideoCamera() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  const Camera& camera() const override { return camera_; }
  bool hasColor() const override { return true; }
  bool hasDepth() const override { return false; }
  bool hasIntrinsics() const override { return false; }

  void start() override {
    const std::lock_guard<std::mutex> lock(mutex_);
    pictures_.clear();  // of before
  }
  std::optional<DeviceImages> wait(std::chrono::milliseconds longest) override {
    std::unique_lock<std::mutex> lock(mutex_);
    came_.wait_for(lock, longest, [this] { return !pictures_.empty() || !failure_.empty(); });
    if (!pictures_.empty()) {
      DeviceImages images = std::move(pictures_.front());
      pictures_.pop_front();
      return images;
    }
    if (!failure_.empty()) throw InputError(failure_);
    return {};
  }
  bool connected() override { return true; }  // where it is not, wait() throws
  std::string notice() override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(notice_, {});
  }

 private:
  struct Release {
    void operator()(AVFormatContext* context) const { avformat_close_input(&context); }
    void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  };
  template <typename Value>
  using Owned = std::unique_ptr<Value, Release>;

  [[noreturn]] void fail(const std::string& why) const { throw InputError(nameInMessages(name()) + ": " + why); }

  static int interrupted(void* camera) {
    const auto& self = *static_cast<VideoCamera*>(camera);
    return self.stop_ || (self.cancelled_ && *self.cancelled_) || interrupt_requested ||
                   (self.deadline_ && Clock::now() > *self.deadline_)
               ? 1
               : 0;
  }

  void open(const std::string& id) {
    const AVInputFormat* format = nullptr;
    std::string url = id, given;
    if (id.find("://") == std::string::npos) {
      format = localFormat();
      if (const std::size_t mark = id.find('?'); mark != std::string::npos) {
        url = id.substr(0, mark);
        given = id.substr(mark + 1);
      }
      std::error_code error;
      if (!fs::exists(url, error))
        fail("is not connected, or no address; must be /dev/video0, or rtsp://… and the like");
      if (!fs::is_character_file(url, error)) fail("is a file, and no camera; without \"video:\" it is a recording");
    }
    if (id.rfind("file:", 0) == 0) fail("is a file, and no camera; without \"video:file://\" it is a recording");
    AVDictionary* options = nullptr;
    if (!given.empty() && av_dict_parse_string(&options, given.c_str(), "=", "&", 0) < 0) {
      av_dict_free(&options);
      fail("what follows its question mark must be options, as video_size=1280x720&framerate=30");
    }
    if (id.rfind("rtsp://", 0) == 0) av_dict_set(&options, "rtsp_transport", "tcp", 0);
    avformat_network_init();
    AVFormatContext* context = avformat_alloc_context();
    context->interrupt_callback = {&VideoCamera::interrupted, this};
    if (format) context->flags |= AVFMT_FLAG_NONBLOCK;
    // Only the size must be found out. What is read for that is kept: a next key picture may be many seconds away.
    context->max_analyze_duration = AV_TIME_BASE;
    context->fps_probe_size = 0;
    const int error = avformat_open_input(&context, url.c_str(), const_cast<AVInputFormat*>(format), &options);
    const AVDictionaryEntry* left = av_dict_get(options, "", nullptr, AV_DICT_IGNORE_SUFFIX);
    const std::string unknown = left ? left->key : "";
    av_dict_free(&options);
    if (error < 0) fail("cannot be opened: " + libavReason(error));
    context_.reset(context);
    if (!unknown.empty() && unknown != "rtsp_transport") fail("has no option " + unknown);
    (void)avformat_find_stream_info(context, nullptr);
    const AVCodec* codec = nullptr;
    const int track = videoTrack(*context, codec);
    if (track == AVERROR_DECODER_NOT_FOUND) fail("its codec is not known here; must be another");
    if (track < 0) fail("delivers no video");
    stream_ = context->streams[track];
    codec_.reset(avcodec_alloc_context3(codec));
    avcodec_parameters_to_context(codec_.get(), stream_->codecpar);
    codec_->thread_count = 1;  // more would keep pictures back
    codec_->flags |= AV_CODEC_FLAG_LOW_DELAY;
    codec_->pkt_timebase = stream_->time_base;
    if (const int opened = avcodec_open2(codec_.get(), codec, nullptr); opened < 0)
      fail("cannot be decoded: " + libavReason(opened));
  }

  /** \brief The driver of cameras at this computer. */
  const AVInputFormat* localFormat() const {
#ifdef FUSE_FLOW_WITH_LIBAVDEVICE
    static const int once = [] { return avdevice_register_all(), 0; }();
    (void)once;
    if (const AVInputFormat* format = av_find_input_format("v4l2")) return format;
    fail("cannot be opened: libavdevice has no Video4Linux");
#else
    fail(
        "cannot be opened, since FUSE-Flow was built without libavdevice; install libavdevice-dev, and build it again");
#endif
  }

  /** \brief The next picture into frame_; false: stop() came, or the time is over. Throws InputError when it ends. */
  bool decodeNext() {
    for (;;) {
      if (interrupted(this) != 0) return false;
      const int got = avcodec_receive_frame(codec_.get(), frame_.get());
      if (got >= 0 && !isDamaged(*frame_)) return true;
      if (got >= 0 || (got != AVERROR(EAGAIN) && got != AVERROR_EOF)) {
        sayOnce("a picture is damaged; such are left out");
        if (got >= 0) continue;
      }
      const int read = av_read_frame(context_.get(), packet_.get());
      if (read == AVERROR(EAGAIN)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        continue;
      }
      if (read < 0) {
        if (interrupted(this) != 0) return false;
        fail(read == AVERROR_EOF ? "has ended" : "was unplugged, or its connection failed: " + libavReason(read));
      }
      if (packet_->stream_index == stream_->index && avcodec_send_packet(codec_.get(), packet_.get()) < 0)
        sayOnce("a picture is damaged; such are left out");
      av_packet_unref(packet_.get());
    }
  }

  void run() {
    try {
      do {
        deliver();
      } while (decodeNext());
    } catch (const std::exception& error) {
      const std::lock_guard<std::mutex> lock(mutex_);
      failure_ = error.what();
    }
    came_.notify_all();
  }

  void deliver() {
    const Intrinsics& K = camera_.intrinsics;
    if (frame_->width != K.width || frame_->height != K.height) fail("delivers pictures of another size than at first");
    const auto images = std::make_shared<LoadedView>();
    convertPicture(name() + ": a picture", formOf(*frame_), frame_->data, frame_->linesize, images->color);
    const std::lock_guard<std::mutex> lock(mutex_);
    pictures_.push_back({stamp(), images});
    if (pictures_.size() > kWaiting) pictures_.pop_front();
    came_.notify_all();
  }

  /** \brief Microseconds since the first picture, by the camera's clock where it has one. When it comes back they begin again, which the
   *  synchroniser takes for what it is. */
  std::uint64_t stamp() const {
    const auto since = [](auto time) { return std::chrono::duration_cast<std::chrono::microseconds>(time).count(); };
    const std::int64_t time = frame_->best_effort_timestamp;
    const std::int64_t passed = time == AV_NOPTS_VALUE || first_time_ == AV_NOPTS_VALUE
                                    ? since(Clock::now() - opened_)
                                    : av_rescale_q(time - first_time_, stream_->time_base, {1, 1'000'000});
    return static_cast<std::uint64_t>(std::max<std::int64_t>(0, passed));
  }

  void sayOnce(const std::string& line) {
    if (std::exchange(said_, true)) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    notice_ = name() + ": " + line;
  }

  const SilenceLibav silence_;
  std::atomic<bool> stop_{false};
  std::shared_ptr<const std::atomic<bool>> cancelled_;  ///< null: nobody cancels
  std::optional<Clock::time_point> deadline_;           ///< of opening it
  Clock::time_point opened_{Clock::now()};
  Owned<AVFormatContext> context_;
  Owned<AVCodecContext> codec_;
  Owned<AVPacket> packet_{av_packet_alloc()};
  Owned<AVFrame> frame_{av_frame_alloc()};
  AVStream* stream_{nullptr};
  std::int64_t first_time_{0};
  Camera camera_;
  bool said_{false};
  std::thread thread_;
  std::mutex mutex_;
  std::condition_variable came_;
  // The mutex guards the following members.
  std::deque<DeviceImages> pictures_;
  std::string failure_, notice_;
};

/** \brief Gives up at once what it tries to open, when it is stopped. */
class VideoSource : public DeviceSource {
 public:
  VideoSource(const std::string& id, std::chrono::seconds patience, std::shared_ptr<std::atomic<bool>> cancelled)
      : DeviceSource(std::make_unique<VideoCamera>(id, patience, cancelled),
                     [=] { return std::make_unique<VideoCamera>(id, patience, cancelled); }),
        cancelled_(std::move(cancelled)) {}
  ~VideoSource() override { *cancelled_ = true; }
  void stop() override {
    *cancelled_ = true;
    DeviceSource::stop();
  }

 private:
  std::shared_ptr<std::atomic<bool>> cancelled_;
};

std::unique_ptr<CameraSource> openVideo(const std::string& id) {
  if (id.empty()) throw InputError("video: must be followed by /dev/video0, or by an address, as rtsp://…");
  return openVideoSource(id, kVideoPatience);
}

/** \brief Those of Video4Linux. */
std::vector<ConnectedDevice> listVideo() {
  std::vector<ConnectedDevice> list;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator("/sys/class/video4linux", error)) {
    std::string model;
    std::ifstream file(entry.path() / "name");
    std::getline(file, model);
    list.push_back({"video:/dev/" + entry.path().filename().string(), model});
  }
  std::sort(list.begin(), list.end(),
            [](const ConnectedDevice& a, const ConnectedDevice& b) { return a.name < b.name; });
  return list;
}

}  // namespace

std::unique_ptr<Device> openVideoCamera(const std::string& id) {
  return std::make_unique<VideoCamera>(id, kVideoPatience, nullptr);
}

std::unique_ptr<CameraSource> openVideoSource(const std::string& id, std::chrono::seconds patience) {
  return std::make_unique<VideoSource>(id, patience, std::make_shared<std::atomic<bool>>(false));
}

DeviceKind videoKind() { return {"video", "camera of Video4Linux", "", openVideo, listVideo}; }

}  // namespace fuse_flow::io

#else

#include <fuse_flow/recordings/error.h>

namespace fuse_flow::io {

std::unique_ptr<Device> openVideoCamera(const std::string& id) {
  throw InputError("video:" + id + ": cannot be opened, since FUSE-Flow was built without libavformat");
}

std::unique_ptr<CameraSource> openVideoSource(const std::string& id, std::chrono::seconds) {
  return std::make_unique<DeviceSource>(openVideoCamera(id), DeviceSource::OpenAgain());
}

DeviceKind videoKind() {
  return {"video", "camera of Video4Linux", "libavformat; install libavformat-dev, libavcodec-dev and libswscale-dev"};
}

}  // namespace fuse_flow::io

#endif
