#pragma once

#include <fuse_flow/stream/cloud_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace fuse_flow::stream {

/** \brief How a cloud becomes bytes. */
struct EncodingOptions {
  /** \brief Metres between the positions that a point can have; > 0. Each coordinate is off by at most half of it. */
  double step{0.001};
  /** \brief 0: colours are exact. Else the step of two of their three parts, of 255; 1 … 64: fewer bytes, and tints that differ. */
  int chroma_step{0};
  /** \brief Steps of density, each of twice as many points, that a client can get; 1 … 8. */
  int layers{4};
  /** \brief Points that are encoded together, and are sent to a client or not; 64 … 65536. */
  int chunk_points{32768};
  bool confidence{true};     ///< if the points have it
  bool view_count{true};     ///< likewise
  bool normals{true};        ///< likewise
  bool camera_masks{false};  ///< likewise
  int threads{0};            ///< 0: one for each core
};

/** \brief What is known of a frame beside its points. */
struct FrameTimes {
  std::uint64_t number{0};
  std::int64_t captured{0};  ///< when its last image was taken, nanoseconds since 1970; 0: not known
  std::int64_t encoded{0};   ///< when it became bytes, likewise
};

/** \brief What a frame has beside positions, see the format: doc/reference/stream_format.md. */
enum Field : std::uint32_t { kColor = 1, kConfidence = 2, kViewCount = 4, kNormal = 8, kCameras = 16 };

/** \brief A part of the points, near one another. */
struct EncodedChunk {
  std::uint32_t points{0};
  std::array<std::uint32_t, 3> least{}, greatest{};  ///< in steps from the origin
  /** \brief The bytes of each layer; one array for a chunk, in order. */
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint32_t> layer_bytes;   ///< size of each layer in bytes
  std::vector<std::uint32_t> layer_points;  ///< points of each layer
};

/** \brief A cloud as bytes, whole. Nothing changes it, so that any number of clients share it. */
struct EncodedFrame {
  FrameTimes times;
  std::array<double, 3> origin{};  ///< metres
  double step{0};                  ///< metres
  std::uint32_t fields{0};         ///< of Field
  int chroma_step{0};
  int layers{1};
  int mask_bytes{0};
  std::uint32_t points{0};
  std::vector<EncodedChunk> chunks;
  /** \brief Points that are not in it: coordinates that are not finite, or more than 2²¹ steps from the others. */
  std::size_t left_out{0};
  /** \brief Those of them that are somewhere, and too far from the others. */
  std::size_t too_far{0};

  std::size_t bytes() const;  ///< of a message with all of it
};

/** \brief What a client wants of frames. */
struct Wishes {
  std::optional<std::uint64_t> points;  ///< at most, a frame
  std::optional<std::uint64_t> bytes_per_second;
  struct Box {
    std::array<double, 3> least, greatest;  ///< metres
  };
  std::optional<Box> region;
  std::optional<std::array<double, 3>> viewpoint;  ///< metres: nearer points are denser
  std::optional<double> step;                      ///< metres; coarser than the server's
};

/** \brief Which layers of which chunks a message has. */
struct Selection {
  std::vector<std::uint8_t> layers;  ///< of each chunk, how many; 0: the chunk is not there
  std::uint32_t points{0};
  std::size_t bytes{0};  ///< of the message
};

/** \brief Chooses what fits: without a viewpoint, the same density everywhere, as far as layers allow. \param bytes at most; 0: any number */
Selection select(const EncodedFrame& frame, const Wishes& wishes, std::size_t bytes = 0);

/** \brief A message as pieces of memory, in order: its header, and then parts of the frame, which are not copied. */
struct Message {
  Message() = default;
  Message(Message&&) = default;
  Message& operator=(Message&&) = default;
  Message(const Message&) = delete;  // the pieces of a copy would point into the original
  Message& operator=(const Message&) = delete;

  std::shared_ptr<const EncodedFrame> frame;
  std::vector<std::uint8_t> header;
  struct Piece {
    const std::uint8_t* data;
    std::size_t size;
  };
  std::vector<Piece> pieces;  ///< the header is the first

  std::size_t size() const;
  std::vector<std::uint8_t> joined() const;
};

Message messageOf(std::shared_ptr<const EncodedFrame> frame, const Selection& selection);
/** \brief With all points. */
Message messageOf(std::shared_ptr<const EncodedFrame> frame);

/** \brief Back from the bytes of a message, which may have a part of a frame: what is not there cannot be selected. Layers are not unpacked.
 *  \throws FormatError, see streamed_cloud.h */
std::shared_ptr<const EncodedFrame> frameOf(const std::uint8_t* data, std::size_t size);

/** \brief Makes frames out of clouds. It keeps memory from one frame to the next; one thread may use it at a time. */
class FrameEncoder {
 public:
  /** \throws std::invalid_argument naming the option that is out of its range */
  explicit FrameEncoder(const EncodingOptions& options = {});
  ~FrameEncoder();
  FrameEncoder(const FrameEncoder&) = delete;
  FrameEncoder& operator=(const FrameEncoder&) = delete;

  /** \brief The same bytes for the same points, in any order, on any number of threads. */
  std::shared_ptr<const EncodedFrame> encode(const CloudView& cloud, const FrameTimes& times);
  template <typename PointT>
  std::shared_ptr<const EncodedFrame> encode(const pcl::PointCloud<PointT>& cloud, const FrameTimes& times) {
    return encode(viewOf(cloud), times);
  }
  const EncodingOptions& options() const;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace fuse_flow::stream
