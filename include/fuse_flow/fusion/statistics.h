#pragma once

#include <fuse_flow/sensors/depth_out_of_range.h>

#include <cstddef>
#include <vector>

namespace fuse_flow {

/** \brief What happened in the last frame. */
struct FrameStatistics {
  std::size_t measured_points{0};  ///< pixels with a measurement in range
  /** \brief Of those, the ones with C > τ or noise within gate_noise, a given confidence of min_confidence or more, within max_noise, with
   *  min_support, inside the crop box. */
  std::size_t gated_points{0};
  std::size_t coarse_cells{0};               ///< that hold a gated point
  std::size_t fused_points{0};               ///< of the output cloud
  std::vector<std::size_t> missing_cameras;  ///< numbers of the cameras without a view
  /** \brief Cameras whose depth is out of range, probably because its unit is wrong. A camera is checked if less than a fiftieth of an
   *  image is in range. */
  std::vector<DepthOutOfRange> out_of_range;
  /** \brief The noise of each view divided by the noise that the model of its camera expects, 0.25 … 8; 1 if it is not measured. If cameras
   *  have their own models (Camera::noise), their scales cannot be compared. */
  std::vector<float> noise_scales;
  /** \brief Allocation of buffers, depth to metres, range, hole fill, noise, smoothing. On the CPU it overlaps with generate_ms; the time
   *  of both is divided in proportion to the time of the threads. On a GPU it is only the handover of the images; the following steps run
   *  asynchronously, and generate_ms includes the wait for them. */
  double preprocess_ms{0};
  double generate_ms{0};  ///< eq. 3, 8, 9 and the coarse cell of each point; on a GPU the upload and the depth maps too
  double merge_ms{0};     ///< merge of the coarse cells of all views; 0 on a GPU, which never separates them
  double fuse_ms{0};      ///< section 5: representatives, eq. 4–7, 10, 11; on the CPU colours and normals too
  /** \brief Collection of the points in the cloud. On a GPU: colours, normals and the download, without the copy into a cloud. */
  double output_ms{0};
  double total_ms{0};  ///< from the input frame to the output cloud; on a GPU the sum of the times above
};

}  // namespace fuse_flow
