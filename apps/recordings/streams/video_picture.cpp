#ifdef FUSE_FLOW_WITH_LIBAV

#include "recordings/streams/video_picture.h"

#include "recordings/streams/libav.h"

#include <fuse_flow/recordings/error.h>

extern "C" {
#include <libswscale/swscale.h>
}

#include <memory>

namespace fuse_flow::io {
namespace {

/** \brief How colours become RGB: chroma in between is interpolated, sums are rounded, and each pixel has a chroma of its own. */
constexpr int kExactColor = SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT;

struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

/** \brief Formats whose name says "full range" are the others of that range. */
AVPixelFormat plainFormat(int format) {
  switch (format) {
    case AV_PIX_FMT_YUVJ420P:
      return AV_PIX_FMT_YUV420P;
    case AV_PIX_FMT_YUVJ422P:
      return AV_PIX_FMT_YUV422P;
    case AV_PIX_FMT_YUVJ444P:
      return AV_PIX_FMT_YUV444P;
    case AV_PIX_FMT_YUVJ440P:
      return AV_PIX_FMT_YUV440P;
    default:
      return static_cast<AVPixelFormat>(format);
  }
}

int matrixOf(const AVFrame& frame) {
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
      return SWS_CS_ITU709;
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
      return SWS_CS_ITU601;
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL:
      return SWS_CS_BT2020;
    case AVCOL_SPC_SMPTE240M:
      return SWS_CS_SMPTE240M;
    case AVCOL_SPC_FCC:
      return SWS_CS_FCC;
    default:
      return frame.height >= 720 ? SWS_CS_ITU709 : SWS_CS_ITU601;
  }
}

}  // namespace

PictureForm formOf(const AVFrame& frame) {
  const AVPixelFormat format = plainFormat(frame.format);
  return {format, frame.width, frame.height, matrixOf(frame),
          format != frame.format || frame.color_range == AVCOL_RANGE_JPEG};
}

bool isDamaged(const AVFrame& frame) {
  return frame.decode_error_flags != 0 || (frame.flags & AV_FRAME_FLAG_CORRUPT) != 0;
}

void convertPicture(const std::string& name, const PictureForm& form, const std::uint8_t* const planes[4],
                    const int strides[4], ColorImage& image) {
  const SilenceLibav silence;
  const std::unique_ptr<SwsContext, FreeScaler> scaler(sws_getContext(form.width, form.height, form.format, form.width,
                                                                      form.height, AV_PIX_FMT_RGB24, kExactColor,
                                                                      nullptr, nullptr, nullptr));
  if (!scaler) throw InputError(name + ": cannot be converted to RGB");
  const int* matrix = sws_getCoefficients(form.matrix);
  constexpr int one = 1 << 16;
  sws_setColorspaceDetails(scaler.get(), matrix, form.full_range ? 1 : 0, matrix, 1, 0, one, one);
  image.resize(form.width, form.height);
  std::uint8_t* const to[4] = {reinterpret_cast<std::uint8_t*>(image.data.data())};
  const int to_strides[4] = {3 * form.width};
  sws_scale(scaler.get(), planes, strides, 0, form.height, to, to_strides);
}

}  // namespace fuse_flow::io

#endif  // FUSE_FLOW_WITH_LIBAV
