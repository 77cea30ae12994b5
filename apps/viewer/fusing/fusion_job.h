#pragma once

#include "methods/instances.h"
#include "methods/method.h"
#include "viewer/fusing/coloring.h"

#include <fuse_flow/calibration/pose_filter.h>
#include <fuse_flow/recordings/image.h>

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief What makes one cloud of a frame. Not changed once it is asked for: another setting is another object, which is
 *  how a change is known. */
struct FusionSetting {
  std::string title;   ///< what the view is headed with
  std::string method;  ///< as io::makeMethod() names it
  io::MethodOptions options;
};
using FusionSettingPtr = std::shared_ptr<const FusionSetting>;

/** \brief The views beside each other: the fused cloud, and what it is compared with. */
constexpr std::size_t kPanes = 2;

/** \brief What the window wants to show next. */
struct FusionRequest {
  std::uint64_t number{0};  ///< comes back with the result
  std::size_t frame{0};
  std::array<FusionSettingPtr, kPanes> settings;  ///< null: that view is not shown; the first always is
  ColorBy color_by{ColorBy::Rgb};
  bool refine_extrinsics{false};  ///< with poses that follow what the cameras see, on the first setting's device
  bool measure_quality{true};     ///< E_MC and the distance to the truth take time of their own
};

/** \brief One cloud, ready to be drawn. */
struct FusedCloud {
  FusionSettingPtr setting;
  std::shared_ptr<const Cloud> cloud;
  FrameStatistics statistics;
  std::optional<ReprojectionQuality> quality;
  std::optional<SurfaceQuality> surface;  ///< with flicker if the frame before was shown with the same setting
  std::optional<double> truth_distance;   ///< mean, metres; absent: not known
  std::string why_empty;                  ///< see io::whyEmpty(); empty: there are points
  PointAttributes attributes;
  std::vector<vtkSmartPointer<vtkPolyData>> slices;  ///< see slicesOf()
};

/** \brief What became of the poses that were given. */
struct RefinedExtrinsics {
  std::vector<CameraMotion>
      corrections;                  ///< of each camera: from its given pose to that which the frame was fused with
  std::vector<CameraMotion> moved;  ///< the latest of each camera that was found to have moved as it played
};

/** \brief The name of a frame for users: "frame 3 (000002)", counted from 1, and as its files are numbered. */
std::string frameName(std::size_t frame);
/** \brief "frame 3 of 12 (000002)" */
std::string frameName(std::size_t frame, std::size_t frames);

/** \brief The answer to a request. */
struct FusedFrame {
  std::uint64_t number{0};
  std::size_t frame{0};
  std::string error;                 ///< one line; then the clouds are null, and what was shown stays
  std::vector<std::string> damaged;  ///< files that could not be read: a camera is missing, or the truth; one line each
  std::vector<std::string> ended;    ///< cameras whose files end before this frame; one line each
  std::vector<std::string> source_status;  ///< see FrameSource::status()
  std::vector<Camera> cameras;
  std::optional<RefinedExtrinsics> refined;  ///< absent: the poses are as given
  std::vector<io::ColorImage> thumbnails;    ///< empty: the camera is missing
  double read_ms{0};
  ColorBy color_by{ColorBy::Rgb};
  std::array<std::shared_ptr<const FusedCloud>, kPanes> clouds;
};

}  // namespace fuse_flow::viewing
