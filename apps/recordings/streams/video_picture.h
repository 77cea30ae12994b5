#pragma once

// Pictures of libavcodec's. Included by those alone that are built with it.

#include <fuse_flow/recordings/image.h>

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixfmt.h>
}

#include <cstdint>
#include <string>

namespace fuse_flow::io {

/** \brief How the samples of a picture become colours. */
struct PictureForm {
  AVPixelFormat format{AV_PIX_FMT_NONE};
  int width{0}, height{0};
  int matrix{0};           ///< SWS_CS_…
  bool full_range{false};  ///< of luma: 0 … 255, not 16 … 235
};

/** \brief By the matrix and the range that a picture names; where it names none, BT.709 from 720 rows on, else BT.601, of limited range. */
PictureForm formOf(const AVFrame& frame);

/** \brief The picture as RGB. Throws InputError, beginning with name. \param planes of the samples \param strides bytes from row to row of each */
void convertPicture(const std::string& name, const PictureForm& form, const std::uint8_t* const planes[4],
                    const int strides[4], ColorImage& image);

/** \brief Whether a part of it could not be decoded. */
bool isDamaged(const AVFrame& frame);

}  // namespace fuse_flow::io
