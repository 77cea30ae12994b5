#ifdef FUSE_FLOW_WITH_LIBAV

#include "recordings/streams/video_file.h"

#include "recordings/files/file_io.h"
#include "recordings/streams/libav.h"
#include "recordings/streams/video_picture.h"

#include <fuse_flow/recordings/error.h>

extern "C" {
#include <libavformat/avformat.h>
#include <libavutil/dict.h>
#include <libavutil/imgutils.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace fuse_flow::io {
namespace {

constexpr const char* kMatroska = "\x1a\x45\xdf\xa3";  // begins a file

std::map<std::string, std::string> tagsOf(const AVDictionary* dictionary) {
  std::map<std::string, std::string> tags;
  const AVDictionaryEntry* entry = nullptr;
  while ((entry = av_dict_get(dictionary, "", entry, AV_DICT_IGNORE_SUFFIX))) tags[entry->key] = entry->value;
  return tags;
}

VideoCodec codecOf(const AVCodecParameters& parameters) {
  if (parameters.codec_id == AV_CODEC_ID_MJPEG) return VideoCodec::Mjpeg;
  if (parameters.codec_id != AV_CODEC_ID_RAWVIDEO) return VideoCodec::Other;
  switch (parameters.codec_tag) {
    case MKTAG('b', '1', '6', 'g'):
      return VideoCodec::Grey16BigEndian;
    case MKTAG('N', 'V', '1', '2'):
      return VideoCodec::Nv12;
    case MKTAG('Y', 'U', 'Y', '2'):
      return VideoCodec::Yuy2;
    case MKTAG('B', 'G', 'R', 'A'):
      return VideoCodec::Bgra;
    default:
      return VideoCodec::Other;
  }
}

/** \brief kLatestTime for a packet without one. */
Nanoseconds stampOf(const AVPacket& packet, const AVStream& stream) {
  const std::int64_t time = packet.pts != AV_NOPTS_VALUE ? packet.pts : packet.dts;
  if (time == AV_NOPTS_VALUE) return kLatestTime;
  return std::clamp(av_rescale_q(time, stream.time_base, {1, 1'000'000'000}), -kLatestTime, kLatestTime);
}

}  // namespace

/** \brief The open file, and what has been read of it that nobody has asked for yet. */
struct VideoFile::Demuxer {
  struct FreePacket {
    void operator()(AVPacket* read) const { av_packet_free(&read); }
  };

  Demuxer() = default;
  ~Demuxer() { avformat_close_input(&context); }
  Demuxer(const Demuxer&) = delete;
  Demuxer& operator=(const Demuxer&) = delete;

  AVFormatContext* context{nullptr};
  std::unique_ptr<AVPacket, FreePacket> packet{av_packet_alloc()};
  std::vector<int> streams;  ///< of each track
  /** \brief Of each track, packets that were read, by their number: a recorder writes colour and depth in turns. */
  std::vector<std::map<std::size_t, std::string>> waiting;
  std::vector<std::size_t> next;  ///< of each track, the number of the packet that comes
  std::string current;
};

VideoFile::VideoFile(const std::string& path, const std::vector<std::string>& titles)
    : path_(path), demuxer_(std::make_unique<Demuxer>()) {
  const SilenceLibav silence;
  if (readFileStart(path, 4) != kMatroska) throw InputError(path + ": is not a Matroska file");
  const std::string url = "file:" + path;  // so that no name is taken for a protocol
  if (const int error = avformat_open_input(&demuxer_->context, url.c_str(), nullptr, nullptr); error < 0)
    throw InputError(path + ": cannot be opened: " + libavReason(error) + "; must be a Matroska file of a recorder");
  const AVFormatContext& context = *demuxer_->context;
  tags_ = tagsOf(context.metadata);
  for (unsigned k = 0; k < context.nb_streams; ++k) {
    AVStream& stream = *context.streams[k];
    const std::map<std::string, std::string> tags = tagsOf(stream.metadata);
    const auto title = tags.find("title");
    const bool wanted = stream.codecpar->codec_type == AVMEDIA_TYPE_VIDEO && title != tags.end() &&
                        std::find(titles.begin(), titles.end(), title->second) != titles.end() && !track(title->second);
    if (!wanted) {
      stream.discard = AVDISCARD_ALL;
      continue;
    }
    VideoTrack found;
    found.title = title->second;
    found.tags = tags;
    found.codec = codecOf(*stream.codecpar);
    found.codec_name = avcodec_get_name(stream.codecpar->codec_id);
    found.width = stream.codecpar->width;
    found.height = stream.codecpar->height;
    tracks_.push_back(std::move(found));
    demuxer_->streams.push_back(static_cast<int>(k));
  }
  demuxer_->waiting.resize(tracks_.size());
  demuxer_->next.assign(tracks_.size(), 0);

  std::vector<std::size_t> back(tracks_.size(), 0);
  int error = 0;
  AVPacket* packet = demuxer_->packet.get();
  while ((error = av_read_frame(demuxer_->context, packet)) >= 0) {
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      if (packet->stream_index != demuxer_->streams[t]) continue;
      const Nanoseconds stamp = stampOf(*packet, *context.streams[packet->stream_index]);
      std::vector<Nanoseconds>& stamps = tracks_[t].stamps;
      if (std::abs(stamp) <= kLatestTime / 2 && (stamps.empty() || stamp > stamps.back()))
        stamps.push_back(stamp);
      else
        ++back[t];
    }
    av_packet_unref(packet);
  }
  if (error != AVERROR_EOF)
    warnings_.push_back(path + ": is damaged or cut short (" + libavReason(error) + "); what is before that is used");
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    if (back[t] > 0)
      warnings_.push_back(path + ": " + std::to_string(back[t]) + " images of the track " + tracks_[t].title +
                          " have a time stamp that is not later than those before, and are left out");
    demuxer_->next[t] = tracks_[t].stamps.size();
  }
}

VideoFile::~VideoFile() = default;

bool isPlainVideo(const std::string& path) {
  const SilenceLibav silence;
  AVFormatContext* context = nullptr;
  try {
    if (readFileStart(path, 4) != kMatroska) return false;
  } catch (const InputError&) {  // said where it is opened
    return false;
  }
  if (avformat_open_input(&context, ("file:" + path).c_str(), nullptr, nullptr) < 0) return false;
  const auto tag = [](const AVStream& stream, const char* key) {
    const AVDictionaryEntry* entry = av_dict_get(stream.metadata, key, nullptr, 0);
    return std::string(entry ? entry->value : "");
  };
  bool plain = true;
  for (unsigned k = 0; k < context->nb_streams; ++k) {
    const AVStream& stream = *context->streams[k];
    plain = plain && tag(stream, "filename") != "calibration.json" && tag(stream, "title") != "DEPTH";
  }
  avformat_close_input(&context);
  return plain;
}

std::string VideoFile::attachment(const std::string& name) const {
  const AVFormatContext& context = *demuxer_->context;
  for (unsigned k = 0; k < context.nb_streams; ++k) {
    const AVStream& stream = *context.streams[k];
    if (stream.codecpar->codec_type != AVMEDIA_TYPE_ATTACHMENT) continue;
    const std::map<std::string, std::string> tags = tagsOf(stream.metadata);
    const auto file = tags.find("filename");
    if (file == tags.end() || file->second != name) continue;
    return std::string(reinterpret_cast<const char*>(stream.codecpar->extradata),
                       static_cast<std::size_t>(stream.codecpar->extradata_size));
  }
  return "";
}

const VideoTrack* VideoFile::track(const std::string& title) const {
  const auto found =
      std::find_if(tracks_.begin(), tracks_.end(), [&](const VideoTrack& t) { return t.title == title; });
  return found == tracks_.end() ? nullptr : &*found;
}

const std::string& VideoFile::packet(const VideoTrack& track, std::size_t number) {
  const SilenceLibav silence;
  constexpr std::size_t most_ahead = 64;    // packets; reading through these is faster than jumping over them
  constexpr std::size_t most_waiting = 16;  // packets; a recorder writes those of one time side by side
  const auto t = static_cast<std::size_t>(&track - tracks_.data());
  Demuxer& demuxer = *demuxer_;
  const std::string what = path_ + ": image " + std::to_string(number) + " of the track " + track.title;
  auto& waiting = demuxer.waiting[t];
  bool jumped = false;
  bool jump = number < demuxer.next[t] || number > demuxer.next[t] + most_ahead;
  for (;;) {
    if (const auto found = waiting.find(number); found != waiting.end()) {
      demuxer.current = std::move(found->second);
      waiting.erase(found);  // those before it may be asked for by another thread
      return demuxer.current;
    }
    if (jump) {
      if (jumped) throw InputError(what + " is not found again; the file must not change while it is read");
      const AVStream& stream = *demuxer.context->streams[demuxer.streams[t]];
      const std::int64_t time = av_rescale_q(track.stamps[number], {1, 1'000'000'000}, stream.time_base);
      if (const int error = av_seek_frame(demuxer.context, demuxer.streams[t], time, AVSEEK_FLAG_BACKWARD); error < 0)
        throw InputError(what + " cannot be reached: " + libavReason(error));
      for (auto& packets : demuxer.waiting) packets.clear();
      jump = false;
      jumped = true;
    }
    AVPacket* packet = demuxer.packet.get();
    if (const int error = av_read_frame(demuxer.context, packet); error < 0) {
      if (jumped) throw InputError(what + " cannot be read: " + libavReason(error));
      jump = true;
      continue;
    }
    for (std::size_t k = 0; k < tracks_.size(); ++k) {
      if (packet->stream_index != demuxer.streams[k]) continue;
      const std::vector<Nanoseconds>& stamps = tracks_[k].stamps;
      const Nanoseconds stamp = stampOf(*packet, *demuxer.context->streams[packet->stream_index]);
      const auto position = std::lower_bound(stamps.begin(), stamps.end(), stamp);
      if (position == stamps.end() || *position != stamp) continue;  // one that went back
      const auto came = static_cast<std::size_t>(position - stamps.begin());
      demuxer.next[k] = came + 1;
      jump = jump || (k == t && came > number);
      auto& kept = demuxer.waiting[k];
      kept.emplace(came,
                   std::string(reinterpret_cast<const char*>(packet->data), static_cast<std::size_t>(packet->size)));
      if (kept.size() > most_waiting) kept.erase(kept.begin());
    }
    av_packet_unref(packet);
  }
}

void convertColor(const std::string& name, VideoCodec codec, int width, int height, const std::string& bytes,
                  ColorImage& image) {
  const AVPixelFormat format = codec == VideoCodec::Nv12   ? AV_PIX_FMT_NV12
                               : codec == VideoCodec::Yuy2 ? AV_PIX_FMT_YUYV422
                                                           : AV_PIX_FMT_BGRA;
  std::uint8_t* planes[4] = {};
  int strides[4] = {};
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  const int size = av_image_fill_arrays(planes, strides, data, format, width, height, 1);
  if (size < 0 || static_cast<std::size_t>(size) != bytes.size())
    throw InputError(name + ": has " + std::to_string(bytes.size()) + " bytes, must have " + std::to_string(size));
  convertPicture(name, {format, width, height, SWS_CS_ITU601, false}, planes, strides, image);
}

}  // namespace fuse_flow::io

#endif  // FUSE_FLOW_WITH_LIBAV
