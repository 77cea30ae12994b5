#pragma once

// What the files that use libav share. Included by those alone.

extern "C" {
#include <libavutil/error.h>
#include <libavutil/log.h>
#include <libswscale/swscale.h>
}

#include <string>

namespace fuse_flow::io {

/** \brief Keeps libav from printing while it lives: what matters is thrown. */
class SilenceLibav {
 public:
  SilenceLibav() : level_(av_log_get_level()) { av_log_set_level(AV_LOG_QUIET); }
  ~SilenceLibav() { av_log_set_level(level_); }
  SilenceLibav(const SilenceLibav&) = delete;
  SilenceLibav& operator=(const SilenceLibav&) = delete;

 private:
  int level_;
};

/** \brief What libav says of an error. */
inline std::string libavReason(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

/** \brief How colours become RGB: chroma in between is interpolated, sums are rounded, and each pixel has a chroma of its own. */
constexpr int kExactColor = SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT;

}  // namespace fuse_flow::io
