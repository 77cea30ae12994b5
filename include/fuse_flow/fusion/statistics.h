#pragma once

#include <fuse_flow/sensors/depth_out_of_range.h>

#include <cstddef>
#include <vector>

namespace fuse_flow {

/** \brief What happened in the last frame. */
struct FrameStatistics {
  std::size_t measured_points{0};  ///< pixels with a measurement in range
  /** \brief Of those, the ones with C > τ, a given confidence of min_confidence or more, within max_noise, with min_support, inside the crop
   *  box. */
  std::size_t gated_points{0};
  std::size_t coarse_cells{0};               ///< that hold a gated point
  std::size_t fused_points{0};               ///< of the output cloud
  std::vector<std::size_t> missing_cameras;  ///< numbers of the cameras without a view
  /** \brief Cameras whose depth is out of range, for a look at their unit. Looked for where less than a fiftieth of an image is in range. */
  std::vector<DepthOutOfRange> out_of_range;
  /** \brief The noise of each view over what the model of its camera says, 0.25 … 8; 1 where it is not measured. Of cameras with models of
   *  their own (Camera::noise) they cannot be compared. */
  std::vector<float> noise_scales;
  /** \brief Laying out memory, depth to metres, range, hole fill, noise, smoothing. On the CPU it overlaps with generate_ms, and what they take
   *  together is divided as the threads' time is. On a GPU handing over the images alone: what follows runs on,
   *  and is waited for in generate_ms. */
  double preprocess_ms{0};
  double generate_ms{0};  ///< eq. 3, 8, 9 and the coarse cell of each point; on a GPU the upload and the depth maps too
  double merge_ms{0};     ///< coarse cells of all views brought together; on a GPU 0: there they never lie apart
  double fuse_ms{0};      ///< section 5: representatives, eq. 4–7, 10, 11; on the CPU colours and normals too
  /** \brief Bringing the points together in the cloud. On a GPU colours, normals and the download, without a copy into a cloud. */
  double output_ms{0};
  double total_ms{0};  ///< from the frame handed in to the cloud handed out; on a GPU the sum of these
};

}  // namespace fuse_flow
