#pragma once

// What the files that use libav share. Included by those alone.

extern "C" {
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

}  // namespace fuse_flow::io
