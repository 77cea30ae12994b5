#pragma once

#include <fuse_flow/point_traits.h>
#include <fuse_flow/stream/encoded_frame.h>

#include <pcl/point_cloud.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

namespace fuse_flow::stream {

/** \brief Bytes that are no frame, no description or no stream file. what() is one line that says what is wrong with them. */
class FormatError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/** \brief A frame as it arrived: points as arrays. Arrays of fields that the frame has not are empty. */
struct StreamedCloud {
  FrameTimes times;
  double step{0};                        ///< metres: positions are off by at most half of it
  std::uint32_t points_of_frame{0};      ///< as many has the whole frame; here are those that were asked for
  std::vector<float> positions;          ///< x, y, z of each point, metres
  std::vector<std::uint8_t> colors;      ///< r, g, b of each point
  std::vector<std::uint8_t> confidence;  ///< 255 is 1
  std::vector<std::uint8_t> view_counts;
  std::vector<float> normals;  ///< x, y, z of each; 0, 0, 0: none
  std::vector<std::uint64_t> camera_masks;

  std::size_t size() const { return positions.size() / 3; }
};

/** \brief Reads frames. It keeps memory from one frame to the next; one thread may use it at a time. */
class FrameDecoder {
 public:
  /** \param threads 0: one for each core  \param most_points a frame with more is refused before memory is taken for it */
  explicit FrameDecoder(int threads = 0, std::uint32_t most_points = 100'000'000);
  ~FrameDecoder();
  FrameDecoder(const FrameDecoder&) = delete;
  FrameDecoder& operator=(const FrameDecoder&) = delete;

  /** \brief Any bytes may come: what is no whole frame is refused. \throws FormatError */
  void decode(const std::uint8_t* data, std::size_t size, StreamedCloud& cloud);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

/** \brief As points of PCL, with the fields that both have; the stamp is when the frame was captured, in microseconds, else encoded.
 *  \tparam PointT a point type of PCL, with x, y, z */
template <typename PointT>
void toPointCloud(const StreamedCloud& from, pcl::PointCloud<PointT>& to) {
  to.clear();
  to.resize(from.size());
  to.is_dense = true;
  to.header.stamp =
      static_cast<std::uint64_t>((from.times.captured != 0 ? from.times.captured : from.times.encoded) / 1000);
  for (std::size_t i = 0; i < from.size(); ++i) {
    PointT& point = to.points[i];
    point.x = from.positions[3 * i];
    point.y = from.positions[3 * i + 1];
    point.z = from.positions[3 * i + 2];
    if constexpr (point::has_color<PointT>)
      if (!from.colors.empty()) {
        const std::uint32_t rgba = 0xff000000u | static_cast<std::uint32_t>(from.colors[3 * i]) << 16 |
                                   static_cast<std::uint32_t>(from.colors[3 * i + 1]) << 8 | from.colors[3 * i + 2];
        point::setField<point::ColorField<PointT>>(point, rgba);
      }
    if constexpr (point::has_confidence<PointT>)
      if (!from.confidence.empty())
        point::setField<pcl::fields::confidence>(point, static_cast<float>(from.confidence[i]) / 255.0f);
    if constexpr (point::has_view_count<PointT>)
      if (!from.view_counts.empty())
        point::setField<pcl::fields::view_count>(point, static_cast<std::uint32_t>(from.view_counts[i]));
    if constexpr (point::has_normal<PointT>)
      if (!from.normals.empty()) {
        point::setField<pcl::fields::normal_x>(point, from.normals[3 * i]);
        point::setField<pcl::fields::normal_y>(point, from.normals[3 * i + 1]);
        point::setField<pcl::fields::normal_z>(point, from.normals[3 * i + 2]);
      }
    if constexpr (point::has_camera_mask<PointT>)
      if (!from.camera_masks.empty()) {
        const std::uint32_t mask[2] = {static_cast<std::uint32_t>(from.camera_masks[i]),
                                       static_cast<std::uint32_t>(from.camera_masks[i] >> 32)};
        point::setField<pcl::fields::camera_mask>(point, mask);
      }
  }
}

}  // namespace fuse_flow::stream
