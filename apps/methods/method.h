#pragma once

#include "methods/point_fused_normal.h"

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <functional>
#include <memory>
#include <string>

namespace fuse_flow::stream {
struct EncodedFrame;
struct EncodingOptions;
struct FrameTimes;
}  // namespace fuse_flow::stream

namespace fuse_flow::io {

/** \brief One way to make a cloud of a frame: ours, or what people use without it. */
class Method {
 public:
  using Cloud = pcl::PointCloud<PointFused>;

  virtual ~Method() = default;
  virtual void fuse(const RigFrame& frame, Cloud& output) = 0;
  /** \brief A frame as the bytes of a stream that are made on the GPU: its cloud stays there, and withNormals() is that of an earlier one.
   *  \returns null if this method cannot, or MethodOptions::encoding is null: fuse() it */
  virtual std::shared_ptr<const stream::EncodedFrame> fuseEncoded(const RigFrame& frame,
                                                                  const stream::FrameTimes& times) {
    (void)frame;
    (void)times;
    return nullptr;
  }
  /** \brief Of the last frame; the peers back-project (generate), thin (fuse) and write the cloud (output). */
  virtual const FrameStatistics& statistics() const { return statistics_; }
  /** \brief The last frame's cloud with normals, which mean nothing unless MethodOptions::normals, and cameras; empty unless MethodOptions::morePerPoint(). */
  virtual const pcl::PointCloud<PointFusedNormal>& withNormals() const { return with_normals_; }

 protected:
  FrameStatistics statistics_;
  pcl::PointCloud<PointFusedNormal> with_normals_;
};

struct MethodOptions {
  FuseFlowParameters parameters;
  unsigned int threads{0};
  float leaf_size{0.01f};  ///< of the voxel grids, metres
  /** \brief "cpu"; "gpu"; "auto": the GPU where there is one that can do what is asked; where it fails and warn is set, the CPU from
   *  then on. The peers run on the CPU. */
  std::string device{"auto"};
  bool normals{false};                                      ///< ours only
  bool camera_mask{false};                                  ///< of each point, ours only
  std::shared_ptr<const stream::EncodingOptions> encoding;  ///< for Method::fuseEncoded()
  std::function<void(const std::string&)> warn;  ///< gets what is to be said while frames are fused, a line at a time

  bool morePerPoint() const { return normals || camera_mask; }
};

/** \brief Whether a method's clouds have a confidence: the peers' points have the field, and 0 in it. */
inline bool knowsConfidence(const std::string& method) { return method == "fuse_flow"; }
/** \brief Whether a method counts the cameras of a point; a voxel grid of PCL's averages points of several, and does not. */
inline bool countsViews(const std::string& method) { return method == "fuse_flow" || method == "concatenate"; }

/** \brief "fuse_flow", "concatenate", "voxel_grid", "approximate_voxel_grid" or "outlier_removal", which is
 *  pcl::StatisticalOutlierRemoval (16 neighbours, 1 standard deviation) before the voxel grid. */
std::unique_ptr<Method> makeMethod(const std::string& name, const MethodOptions& options);

}  // namespace fuse_flow::io
