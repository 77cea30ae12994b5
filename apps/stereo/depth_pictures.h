#pragma once

#include <fuse_flow/recordings/recording.h>

#include <vector>

namespace fuse_flow::io {

/** \brief The depths between which a frame's pictures change their colour, metres. */
struct PictureRange {
  float nearest{0};
  float farthest{0};  ///< 0: there is no depth
};

/** \brief That of nearly all depth on which other views agree, of some views together, so that one colour is one depth in all their pictures.
 *  \param of the views that count */
PictureRange pictureRange(const LoadedFrame& frame, const std::vector<bool>& of);

/** \brief From yellow, near, to dark blue, far, in steps of inverse depth, in which stereo is equally exact; black where there is none. */
ColorImage depthPicture(const FloatImage& depth, const PictureRange& range);

/** \brief From black, 0, to white, 1. */
ColorImage confidencePicture(const FloatImage& confidence);

}  // namespace fuse_flow::io
