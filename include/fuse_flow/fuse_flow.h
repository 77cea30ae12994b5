#pragma once

#include <fuse_flow/depth_out_of_range.h>
#include <fuse_flow/device.h>
#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/consistency.h>
#include <fuse_flow/math/smoothing.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/preprocessing.h>
#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <vector>

namespace fuse_flow {

/** \brief Everything that decides what a frame is fused into. The defaults are what measured best; see
 *  doc/parameters.md. */
struct FuseFlowParameters {
  PreprocessingParameters preprocessing;  ///< raw depth to metres
  /** \brief D^r of eq. 8. The confidence of eq. 3 and the distances of eq. 6 are taken from the measured depth, points,
   *  colours and normals from the refined one. */
  SmoothingParameters smoothing;
  ConfidenceParameters confidence;    ///< eq. 3 and 9
  ConsistencyParameters consistency;  ///< eq. 4–7
  AggregationParameters aggregation;  ///< section 5
  /** \brief Measure how noisy each view is, and scale the axial noise of the confidence parameters by it, frame by frame;
   *  off: the sensor is as noisy as those say. */
  bool adapt_noise{true};
  /** \brief Axial noise at which a measurement weighs half as much as an exact one, metres; [0, 10], 0: noise does not weigh.
   *  See noiseWeight(); C of eq. 10 is multiplied by it after the gate of eq. 9. */
  float half_weight_noise{0.025f};
  /** \brief Measurements with more axial noise than this are dropped, metres; [0, 10], 0: none is. Smoothing cannot bring them
   *  near to the surface: they are what a noisy sensor leaves beside it. */
  float max_noise{0.07f};
  /** \brief Of the eight pixels around a measurement so many must pass the gate of eq. 9 too and continue its surface, see
   *  surfaceSupport(), or it is dropped: what sensors measure beside an edge, between one surface and another, lies alone; 0 … 8, 0: none must. Up to 3 the
   *  corners of surfaces stay. Without measurement confidence none must. */
  int min_support{3};
  /** \brief Measurements to which DepthView::confidence gives less than this are dropped; [0, 1], 0: only those to which it gives none. The
   *  gate of eq. 9 looks at C of eq. 3 alone; what passes both weighs C times the given confidence. */
  float min_confidence{0.5f};
  /** \brief MF of the paper's ablation; off: C = 1 wherever there is a measurement, whatever its noise and what is around it, times the view's own
   *  confidence. */
  bool use_measurement_confidence{true};
  /** \brief DC; off: V = 1. */
  bool use_distance_consistency{true};
  /** \brief SA; off: point-wise fusion, one output point for each pixel that passes the gate. */
  bool use_spatial_hash{true};
  /** \brief Points outside are dropped, before the fusion and, where other views confirm that they lie outside, after it: no fused point
   *  lies outside; world frame, metres. */
  std::optional<Eigen::AlignedBox3f> crop_box;

  /** \brief The forms of eq. 3, 6, 7 and of the representatives as the paper prints them; doc/parameters.md says how what it leaves open is
   *  settled. */
  static FuseFlowParameters published();
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
inline void checkParameters(const FuseFlowParameters& parameters);

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
  /** \brief The noise of each camera over what the parameters say, 0.25 … 8; 1 where it is not measured. */
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

/** \brief The frame pipeline: the views of one instant to one fused cloud, with no state from frame to frame but
 *  memory.
 *
 *  \code
 *  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
 *  pcl::PointCloud<fuse_flow::PointFused> cloud;
 *  fusion.fuse(frame, cloud);
 *  \endcode
 *
 *  What PointT has a field for is filled in: rgb or rgba with the fused colour, intensity with its luminance, confidence with ω,
 *  view_count with the number of cameras that the point is from and camera_mask with their bits (see PointCameras; point-wise those
 *  whose points were averaged), and after setComputeNormals(true) the normal with the mean normal, facing the cameras, or NaN where none is
 *  known: the cloud is then not dense. The same frame gives the same bytes for any number of threads.
 *
 *  One object is for one thread at a time, which is checked: a second one gets a pcl::PCLException. Objects share nothing but helper threads: several may be used at once, by a thread each. */
template <typename PointT, typename Device = device::Host>
class FuseFlow;

namespace host {
class FramePipeline;
template <typename PointT>
class PointWriter;
}  // namespace host

/** \brief On the CPU. \copydetails FuseFlow */
template <typename PointT>
class FuseFlow<PointT, device::Host> {
 public:
  ///@{
  /** \brief As in PCL's filters. */
  using PointCloud = pcl::PointCloud<PointT>;
  using Ptr = std::shared_ptr<FuseFlow>;
  using ConstPtr = std::shared_ptr<const FuseFlow>;
  ///@}

  inline FuseFlow();
  inline ~FuseFlow();
  ///@{
  /** \brief Moves the memory along; what was moved from can only be assigned to. */
  FuseFlow(FuseFlow&&) noexcept = default;
  FuseFlow& operator=(FuseFlow&&) noexcept = default;
  ///@}

  /** \brief Throws pcl::BadArgumentException for a value out of range. */
  inline void setParameters(const FuseFlowParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  inline const FuseFlowParameters& getParameters() const;

  /** \brief Threads to use; 0, the default, is one per core. */
  inline void setNumberOfThreads(unsigned int threads);

  /** \brief Fill PointT's normal, if it has one, from the depth images; default off. */
  inline void setComputeNormals(bool compute);

  /** \brief Write ω into PointT's intensity, if it has one, in place of the luminance; default off. */
  inline void setWeightInIntensity(bool weight);

  /** \brief Fuse one frame. Of the cloud's header only the stamp is set. A missing camera is left out and named in the statistics; a frame without any view gives an
   *  empty cloud. \throws pcl::BadArgumentException if a camera or a view contradicts itself
   *  \throws pcl::PCLException if a point is too far out for the lattice of cells
   *  \throws std::bad_alloc if there is not enough memory; what was kept from frame to frame is then given back, and frames after it are fused
   *  as by a new object */
  inline void fuse(const RigFrame& frame, PointCloud& output);

  /** \brief Of the last fuse(). */
  inline const FrameStatistics& getStatistics() const;

 private:
  inline void fuseFrame(const RigFrame& frame, PointCloud& output);
  /** \brief After there was not enough: what is half laid out would be taken for whole. */
  inline void forgetMemory();

  detail::OneThread one_thread_;
  std::unique_ptr<host::FramePipeline> pipeline_;
  std::unique_ptr<host::PointWriter<PointT>> writer_;
  bool compute_normals_{false};
};

}  // namespace fuse_flow

#include <fuse_flow/impl/fuse_flow.hpp>
