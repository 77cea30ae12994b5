#ifdef FUSE_FLOW_WITH_LIBAV

#include "recordings/streams/decoded_video.h"

#include "recordings/streams/libav.h"
#include "recordings/streams/video_picture.h"

#include <fuse_flow/recordings/error.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/imgutils.h>
}

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

namespace fuse_flow::io {
namespace {

constexpr int kThreads = 2;  // of a decoder, beside the cameras'

/** \brief What a picture in memory begins with; the planes behind it are as aligned. */
struct alignas(16) PictureHeader {
  PictureForm form;
  bool damaged{false};
};

std::optional<Nanoseconds> nanoseconds(std::int64_t time, const AVStream& stream) {
  if (time == AV_NOPTS_VALUE) return {};
  const Nanoseconds stamp =
      std::clamp(av_rescale_q(time, stream.time_base, {1, 1'000'000'000}), -kLatestTime, kLatestTime);
  return std::abs(stamp) <= kLatestTime / 2 ? std::optional(stamp) : std::nullopt;
}

/** \brief How its pictures are to be turned, or nullptr. */
const std::int32_t* displayMatrix(const AVStream& stream) {
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(60, 31, 0)  // since FFmpeg 6.1
  const AVCodecParameters& parameters = *stream.codecpar;
  const AVPacketSideData* const data =
      av_packet_side_data_get(parameters.coded_side_data, parameters.nb_coded_side_data, AV_PKT_DATA_DISPLAYMATRIX);
  return data == nullptr ? nullptr : reinterpret_cast<const std::int32_t*>(data->data);
#else
  return reinterpret_cast<const std::int32_t*>(av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr));
#endif
}

}  // namespace

struct DecodedVideo::Decoder {
  struct FreePacket {
    void operator()(AVPacket* held) const { av_packet_free(&held); }
  };
  struct FreeFrame {
    void operator()(AVFrame* held) const { av_frame_free(&held); }
  };
  struct FreeCodec {
    void operator()(AVCodecContext* held) const { avcodec_free_context(&held); }
  };
  struct CloseInput {
    void operator()(AVFormatContext* held) const { avformat_close_input(&held); }
  };

  std::unique_ptr<AVFormatContext, CloseInput> context;
  std::unique_ptr<AVCodecContext, FreeCodec> codec;
  std::unique_ptr<AVPacket, FreePacket> packet{av_packet_alloc()};
  std::unique_ptr<AVFrame, FreeFrame> frame{av_frame_alloc()};
  AVStream* stream{nullptr};
  bool drained{false};    ///< the file has ended, and the codec knows
  std::size_t coming{0};  ///< the number of the picture that next() gives, as far as is known
};

DecodedVideo::DecodedVideo(const std::string& path) : path_(path), decoder_(std::make_unique<Decoder>()) {
  const SilenceLibav silence;
  AVFormatContext* context = nullptr;
  const std::string url = "file:" + path;  // so that no name is taken for a protocol
  // Nothing that names other files, as a list of them does.
  AVDictionary* allowed = nullptr;
  av_dict_set(&allowed, "protocol_whitelist", "file", 0);
  av_dict_set(&allowed, "format_whitelist", "mov,mp4,matroska,webm,avi,mpegts,mpeg,ogg", 0);
  const int error = avformat_open_input(&context, url.c_str(), nullptr, &allowed);
  av_dict_free(&allowed);
  if (error < 0) throw InputError(path + ": cannot be opened: " + libavReason(error) + "; must be a video");
  decoder_->context.reset(context);
  (void)avformat_find_stream_info(context, nullptr);  // what it does not find is seen below
  const AVCodec* codec = nullptr;
  const int track = videoTrack(*context, codec);
  if (track == AVERROR_DECODER_NOT_FOUND) throw InputError(path + ": its codec is not known here; must be another");
  if (track < 0) throw InputError(path + ": has no video");
  std::size_t videos = 0;
  for (unsigned k = 0; k < context->nb_streams; ++k) {
    const bool cover = (context->streams[k]->disposition & AV_DISPOSITION_ATTACHED_PIC) != 0;
    videos += context->streams[k]->codecpar->codec_type == AVMEDIA_TYPE_VIDEO && !cover ? 1 : 0;
    if (static_cast<int>(k) != track) context->streams[k]->discard = AVDISCARD_ALL;
  }
  if (videos > 1) warnings_.push_back(path + ": has " + std::to_string(videos) + " video tracks, of which one is used");
  decoder_->stream = context->streams[track];
  const AVCodecParameters& parameters = *decoder_->stream->codecpar;
  constexpr int largest = 65536;  // pixels, of other images, too
  if (parameters.width <= 0 || parameters.height <= 0 || parameters.width > largest || parameters.height > largest)
    throw InputError(path + ": its pictures are " + std::to_string(parameters.width) + "x" +
                     std::to_string(parameters.height) + " pixels, must be 1x1 to 65536x65536");
  width_ = parameters.width;
  height_ = parameters.height;
  decoder_->codec.reset(avcodec_alloc_context3(codec));
  AVCodecContext& decoding = *decoder_->codec;
  avcodec_parameters_to_context(&decoding, &parameters);
  decoding.thread_count = kThreads;
  // A damaged file may name any size in the middle. Codecs add margins.
  constexpr std::int64_t margin = 256;
  decoding.max_pixels = 2 * (width_ + margin) * (height_ + margin);
  decoding.pkt_timebase = decoder_->stream->time_base;
  decoding.apply_cropping = 1;
  if (const int opened = avcodec_open2(&decoding, codec, nullptr); opened < 0)
    throw InputError(path + ": cannot be decoded: " + libavReason(opened));
  if (const std::int32_t* const matrix = displayMatrix(*decoder_->stream)) {
    const double degrees = av_display_rotation_get(matrix);
    if (std::isfinite(degrees) && std::lround(degrees) % 360 != 0)
      warnings_.push_back(path + ": is to be shown turned by " + std::to_string(std::lround(-degrees)) +
                          " degrees; its pictures are taken as they are stored, " + std::to_string(width_) + "x" +
                          std::to_string(height_) + " pixels, to which the intrinsics must belong");
  }
  if (parameters.field_order != AV_FIELD_UNKNOWN && parameters.field_order != AV_FIELD_PROGRESSIVE)
    warnings_.push_back(path +
                        ": is interlaced: the two halves of a picture are of different moments, so that what moves is "
                        "wrong; must be progressive");
  if (parameters.color_trc == AVCOL_TRC_SMPTE2084 || parameters.color_trc == AVCOL_TRC_ARIB_STD_B67)
    warnings_.push_back(path + ": is of high dynamic range; its colours are taken as they are coded, and look pale");
  readThrough();
  if (stamps_.empty()) throw InputError(path + ": has no picture with a time");
}

DecodedVideo::~DecodedVideo() = default;

std::string DecodedVideo::nameOf(std::size_t number) const { return path_ + ": picture " + std::to_string(number); }

void DecodedVideo::readThrough() {
  AVPacket* packet = decoder_->packet.get();
  std::size_t without_time = 0;
  bool order_of_decoding = false;
  int error = 0;
  while ((error = av_read_frame(decoder_->context.get(), packet)) >= 0) {
    if (packet->stream_index == decoder_->stream->index && (packet->flags & AV_PKT_FLAG_DISCARD) == 0) {
      order_of_decoding = order_of_decoding || packet->pts == AV_NOPTS_VALUE;
      const auto stamp = nanoseconds(packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts, *decoder_->stream);
      if (stamp)
        stamps_.push_back(*stamp);
      else
        ++without_time;
    }
    av_packet_unref(packet);
  }
  if (order_of_decoding && decoder_->stream->codecpar->video_delay > 0)
    throw InputError(path_ +
                     ": its pictures are stored in another order than they are shown in, without times of their "
                     "own, as AVI does; must be .mp4, .mov or .mkv");
  if (error != AVERROR_EOF)
    warnings_.push_back(path_ + ": is damaged or cut short (" + libavReason(error) + "); what is before that is used");
  std::sort(stamps_.begin(), stamps_.end());  // they are stored in the order in which they are decoded
  const std::size_t all = stamps_.size();
  stamps_.erase(std::unique(stamps_.begin(), stamps_.end()), stamps_.end());
  if (const std::size_t lost = without_time + all - stamps_.size(); lost > 0)
    warnings_.push_back(path_ + ": " + std::to_string(lost) +
                        " pictures have no time, or that of another, and are left out");
  if (!stamps_.empty()) jumpBefore(0);
}

/** \brief To a key picture well before the one of that number: pictures are stored in another order than they are shown in. */
void DecodedVideo::jumpBefore(std::size_t number) {
  constexpr std::size_t reordered = 16;  // pictures, as many as H.264 and HEVC allow
  const Nanoseconds time = stamps_.empty() || number < reordered ? 0 : stamps_[number - reordered];
  AVFormatContext* context = decoder_->context.get();
  const std::int64_t target = av_rescale_q(time, {1, 1'000'000'000}, decoder_->stream->time_base);
  const bool to_begin = number < reordered;
  int error = to_begin ? avformat_seek_file(context, decoder_->stream->index, INT64_MIN, INT64_MIN / 2, 0, 0)
                       : av_seek_frame(context, decoder_->stream->index, target, AVSEEK_FLAG_BACKWARD);
  if (error < 0) error = av_seek_frame(context, -1, 0, AVSEEK_FLAG_BYTE);
  if (error < 0) throw InputError(nameOf(number) + " cannot be reached: " + libavReason(error));
  avcodec_flush_buffers(decoder_->codec.get());
  decoder_->drained = false;
}

/** \brief Decodes the next picture into frame; false: there is no more. */
bool DecodedVideo::next() {
  constexpr int most_errors = 1000;
  Decoder& d = *decoder_;
  for (int errors = 0;;) {
    const int got = avcodec_receive_frame(d.codec.get(), d.frame.get());
    if (got >= 0) return true;
    if (got == AVERROR_EOF) return false;
    if (got != AVERROR(EAGAIN)) {  // a picture that cannot be decoded; those behind it may be
      if (++errors > most_errors) return false;
      continue;
    }
    if (d.drained) return false;
    const int read = av_read_frame(d.context.get(), d.packet.get());
    if (read < 0) {
      d.drained = true;
      avcodec_send_packet(d.codec.get(), nullptr);
      continue;
    }
    if (d.packet->stream_index == d.stream->index) avcodec_send_packet(d.codec.get(), d.packet.get());
    av_packet_unref(d.packet.get());
  }
}

void DecodedVideo::decode(std::size_t number, std::string& bytes) {
  const SilenceLibav silence;
  constexpr std::size_t most_passed = 8;
  constexpr std::size_t most_ahead = 32;  // pictures; decoding these is mostly faster than to begin at a key picture
  Decoder& d = *decoder_;
  enum class Jumped { No, Before, ToBegin } jumped = Jumped::No;
  bool came_before = false;  // a picture that is not later than the one that is asked for
  const auto jump = [&] {
    if (jumped == Jumped::ToBegin || (jumped == Jumped::Before && came_before))
      throw InputError(nameOf(number) + " cannot be decoded; the file may be damaged");
    jumped = jumped == Jumped::No ? Jumped::Before : Jumped::ToBegin;
    came_before = false;
    passed_.clear();
    jumpBefore(jumped == Jumped::Before ? number : 0);
  };
  if (const auto found = passed_.find(number); found != passed_.end()) {
    bytes = std::move(found->second);
    passed_.erase(found);
    return;
  }
  if (number < d.coming || number > d.coming + most_ahead) jump();
  for (;;) {
    if (!next()) {
      jump();
      continue;
    }
    const std::optional<Nanoseconds> stamp = stampOfFrame();
    if (!stamp) continue;
    d.coming = static_cast<std::size_t>(std::upper_bound(stamps_.begin(), stamps_.end(), *stamp) - stamps_.begin());
    if (*stamp == stamps_[number]) break;
    came_before = came_before || *stamp < stamps_[number];
    if (*stamp > stamps_[number]) {
      jump();
    } else if (d.coming > 0 && d.coming + most_passed > number && stamps_[d.coming - 1] == *stamp) {
      std::string picture;
      copyPicture(d.coming - 1, picture);
      passed_[d.coming - 1] = std::move(picture);
      if (passed_.size() > most_passed) passed_.erase(passed_.begin());
    }
  }
  copyPicture(number, bytes);
}

/** \brief That which the file has: libav's best guess, or what the codec says, which differ where times are repeated. */
std::optional<Nanoseconds> DecodedVideo::stampOfFrame() const {
  const AVFrame& frame = *decoder_->frame;
  const auto guess = nanoseconds(frame.best_effort_timestamp, *decoder_->stream);
  const auto said = nanoseconds(frame.pts, *decoder_->stream);
  const auto isOfFile = [&](const std::optional<Nanoseconds>& stamp) {
    return stamp && std::binary_search(stamps_.begin(), stamps_.end(), *stamp);
  };
  return isOfFile(guess) || !isOfFile(said) ? guess : said;
}

void DecodedVideo::copyPicture(std::size_t number, std::string& bytes) const {
  const AVFrame& frame = *decoder_->frame;
  const PictureHeader header{formOf(frame), isDamaged(frame)};
  const bool fits = frame.width == width_ && frame.height == height_;  // else what it is will do to say so
  const int size = !fits ? 0 : av_image_get_buffer_size(header.form.format, frame.width, frame.height, 1);
  if (size < 0) throw InputError(nameOf(number) + " cannot be decoded: " + libavReason(size));
  bytes.resize(sizeof header + static_cast<std::size_t>(size));
  std::memcpy(&bytes[0], &header, sizeof header);
  if (fits)
    av_image_copy_to_buffer(reinterpret_cast<std::uint8_t*>(&bytes[sizeof header]), size, frame.data, frame.linesize,
                            header.form.format, frame.width, frame.height, 1);
}

void DecodedVideo::convert(std::size_t number, const std::string& bytes, ColorImage& image) const {
  PictureHeader header;
  if (bytes.size() < sizeof header) throw InputError(nameOf(number) + " cannot be decoded");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.damaged) throw InputError(nameOf(number) + " is damaged");
  const PictureForm& form = header.form;
  if (form.width != width_ || form.height != height_)
    throw InputError(nameOf(number) + ": is " + std::to_string(form.width) + "x" + std::to_string(form.height) +
                     " pixels, the video is " + std::to_string(width_) + "x" + std::to_string(height_));
  std::uint8_t* planes[4] = {};
  int strides[4] = {};
  av_image_fill_arrays(planes, strides, reinterpret_cast<const std::uint8_t*>(bytes.data() + sizeof header),
                       form.format, form.width, form.height, 1);
  convertPicture(nameOf(number), form, planes, strides, image);
}

}  // namespace fuse_flow::io

#endif  // FUSE_FLOW_WITH_LIBAV
