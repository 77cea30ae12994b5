#pragma once

#include <fuse_flow/math/host_device.h>

#include <cstddef>
#include <cstdint>

namespace fuse_flow {

/** \brief A non-owning image: rows of width pixels, row_stride bytes apart. A null data pointer means "no image". */
template <typename Pixel>
struct ImageView {
  const Pixel* data{nullptr};  ///< the first row; owned by the creator of the view
  int width{0};                ///< pixels
  int height{0};               ///< rows
  /** \brief Bytes from one row to the next; at least width · sizeof(Pixel). */
  std::size_t row_stride{0};

  ImageView() = default;
  /** \brief Points to pixels; their owner keeps them.
   *  \param pixels the first row  \param w pixels in a row  \param h rows
   *  \param stride bytes from row to row; 0: rows follow each other without padding */
  ImageView(const Pixel* pixels, int w, int h, std::size_t stride = 0)
      : data(pixels), width(w), height(h), row_stride(stride ? stride : sizeof(Pixel) * static_cast<std::size_t>(w)) {}

  /** \brief Whether there is an image. */
  FUSE_FLOW_HD explicit operator bool() const { return data != nullptr; }
  /** \brief The pixels of row v, 0 … height − 1, not checked. */
  FUSE_FLOW_HD const Pixel* row(int v) const {
    return reinterpret_cast<const Pixel*>(reinterpret_cast<const char*>(data) +
                                          row_stride * static_cast<std::size_t>(v));
  }
};

/** \brief 8-bit colour, in the order in which PNG, JPEG and capture SDKs deliver it. */
struct Rgb8 {
  ///@{
  /** \brief 0 … 255. */
  std::uint8_t r{0}, g{0}, b{0};
  ///@}
};

/** \brief What one camera measured at one instant. Owns nothing: the images must outlive the call that reads them.
 *
 *  Depth comes either as 16-bit integers in units of Camera::depth_scale, or as float metres; set one of the two. 0, 65535, NaN and ±inf
 *  mean "no measurement". If neither is set, the camera is missing from this frame, which is not an error. Thread safety: many threads may
 *  read it while none writes. */
struct DepthView {
  /** \brief Depth in units of Camera::depth_scale. */
  ImageView<std::uint16_t> depth16;
  /** \brief Depth in metres. */
  ImageView<float> depth32;
  /** \brief Optional; has the size of the depth image, or of the colour camera if the Camera has one. */
  ImageView<Rgb8> color;
  /** \brief Optional; has the size of the depth image; in [0, 1], for depth that comes with its own confidence. FuseFlow multiplies C by
   *  it, or uses it as C (ConfidenceForm::Given). Among the filters, DepthBackprojection writes it to the points. */
  ImageView<float> confidence;

  /** \brief Whether the camera measured nothing in this frame. */
  bool missing() const { return !depth16 && !depth32; }
  /** \brief Width of the depth image, pixels; 0 if missing. */
  int width() const { return depth16 ? depth16.width : depth32.width; }
  /** \brief Height of the depth image, rows; 0 if missing. */
  int height() const { return depth16 ? depth16.height : depth32.height; }
};

}  // namespace fuse_flow
