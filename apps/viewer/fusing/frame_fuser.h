#pragma once

#include "calibration/live_extrinsics.h"
#include "viewer/frame_source.h"
#include "viewer/fusing/fusion_job.h"

#include <atomic>
#include <memory>
#include <optional>

namespace fuse_flow::viewing {

/** \brief Does what a request asks, and keeps what the next one can use again: a frame that is read, a cloud that is fused
 *  are not made again to be coloured differently. For one thread. */
class FrameFuser {
 public:
  explicit FrameFuser(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  /** \brief Null if stop came true on the way. Never throws: what went wrong is in the answer. */
  std::shared_ptr<const FusedFrame> fuse(const FusionRequest& request, const std::atomic<bool>& stop);

 private:
  /** \brief A cloud of the frame before: how much a cloud flickers is measured against it. */
  struct Earlier {
    FusionSettingPtr setting;
    std::shared_ptr<const Cloud> cloud;
  };
  struct Pane {
    FusionSettingPtr setting;  ///< of the method, and of the cloud
    std::unique_ptr<io::Method> method;
    std::optional<std::size_t> frame;  ///< that the cloud was made from
    std::optional<Earlier> before;     ///< of the frame in before_
    FusedCloud fused;
    std::optional<ColorBy> colored_by;
    std::shared_ptr<const FusedCloud> published;
  };

  void readFrame(std::size_t frame);
  void placeCameras(const FusionRequest& request);
  void fuseCloud(const FusionRequest& request, Pane& pane, const FusionSettingPtr& setting);
  /** \brief Null if it is not known, or cannot be read. */
  const simulation::RayScene* truth();
  void measure(const FusionRequest& request, Pane& pane);
  bool canFlicker(const Pane& pane) const;
  void color(const FusionRequest& request, Pane& pane);

  std::unique_ptr<FrameSource> source_;
  io::LoadedFrame loaded_;
  std::optional<std::size_t> loaded_frame_;
  io::LoadedFrame before_;  ///< the frame that was loaded before, with the poses that it was fused with
  std::optional<std::size_t> before_frame_;
  std::string truth_error_;    ///< of the loaded frame
  std::vector<Camera> given_;  ///< as the loaded frame came
  bool placed_{false};         ///< the loaded frame's cameras are where the last request wanted them
  std::optional<RefinedExtrinsics> refined_;
  std::unique_ptr<io::LiveExtrinsics> extrinsics_;
  double read_ms_{0};
  std::vector<io::ColorImage> thumbnails_;
  std::array<Pane, kPanes> panes_;
};

}  // namespace fuse_flow::viewing
