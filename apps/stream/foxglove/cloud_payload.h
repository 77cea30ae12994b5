#pragma once

#include <fuse_flow/stream/encoded_frame.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fuse_flow::stream::foxglove {

/** \brief A frame as foxglove.PointCloud, for all who want it. Its points come layer after layer, so that fewer of them are the beginning of
 *  all: clients of any density share the same memory. */
struct CloudPayload {
  std::uint64_t sequence{0};         ///< see PublishedFrame
  std::uint64_t time{0};             ///< captured, else encoded, nanoseconds since 1970
  std::string head;                  ///< the fields before the points
  std::size_t stride{0};             ///< bytes of a point
  std::vector<std::uint8_t> points;  ///< of all layers
  std::vector<std::uint32_t> up_to;  ///< points of the first layer, of the first two, …; one entry at least
  std::size_t bytes(std::size_t layers) const { return head.size() + stride * up_to[layers - 1]; }
  /** \brief What comes before the points, of which the first stride · up_to[layers − 1] bytes follow. */
  std::string beginning(std::size_t layers) const;
};

/** \brief Makes payloads; one thread may use it at a time. */
class CloudPayloads {
 public:
  /** \param threads 0: one for each core */
  explicit CloudPayloads(int threads) : decoder_(threads) {}

  /** \param frame its name: where the points are  \throws FormatError if the bytes of the frame are none */
  CloudPayload make(const std::shared_ptr<const EncodedFrame>& encoded, const std::string& frame);

 private:
  FrameDecoder decoder_;
  StreamedCloud cloud_;
};

}  // namespace fuse_flow::stream::foxglove
