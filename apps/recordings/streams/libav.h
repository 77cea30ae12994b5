#pragma once

// What the files that use libav share. Included by those alone.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/error.h>
#include <libavutil/log.h>
}

#include <mutex>
#include <string>

namespace fuse_flow::io {

/** \brief Keeps libav from printing while one of these lives, in whatever thread: what matters is thrown. */
class SilenceLibav {
 public:
  SilenceLibav() {
    const std::lock_guard<std::mutex> lock(state().mutex);
    if (state().living++ > 0) return;
    state().level = av_log_get_level();
    av_log_set_level(AV_LOG_QUIET);
  }
  ~SilenceLibav() {
    const std::lock_guard<std::mutex> lock(state().mutex);
    if (--state().living == 0) av_log_set_level(state().level);
  }
  SilenceLibav(const SilenceLibav&) = delete;
  SilenceLibav& operator=(const SilenceLibav&) = delete;

 private:
  struct State {
    std::mutex mutex;
    int living{0}, level{0};
  };
  static State& state() {
    static State state;
    return state;
  }
};

/** \brief What libav says of an error. */
inline std::string libavReason(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

/** \brief The number of the video track to show, and its decoder; negative: an error of libav, AVERROR_DECODER_NOT_FOUND if nobody knows its codec.
 *  av_find_best_stream() could say both, but takes another type before FFmpeg 5. */
inline int videoTrack(AVFormatContext& context, const AVCodec*& decoder) {
  const int track = av_find_best_stream(&context, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (track < 0) return track;
  decoder = avcodec_find_decoder(context.streams[track]->codecpar->codec_id);
  return decoder ? track : AVERROR_DECODER_NOT_FOUND;
}

}  // namespace fuse_flow::io
