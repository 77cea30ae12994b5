#pragma once

#include "io/image_io.h"
#include "io/method.h"
#include "viewer/coloring.h"

#include <fuse_flow/multi_camera_consistency.h>

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
  std::array<FusionSettingPtr, kPanes> settings;  ///< null: that view is not shown
  ColorBy color_by{ColorBy::Rgb};
  bool measure_quality{true};         ///< E_MC takes time of its own
  std::size_t coarse_points{100000};  ///< of FusedCloud::coarse, about
};

/** \brief One cloud, ready to be drawn. */
struct FusedCloud {
  FusionSettingPtr setting;
  std::shared_ptr<const Cloud> cloud;
  FrameStatistics statistics;
  std::optional<Quality> quality;
  PointAttributes attributes;
  vtkSmartPointer<vtkPolyData> points;  ///< all of them
  vtkSmartPointer<vtkPolyData> coarse;  ///< every n-th, for while the view moves; the same object if that is all
};

/** \brief The answer to a request. */
struct FusedFrame {
  std::uint64_t number{0};
  std::size_t frame{0};
  std::string error;  ///< one line; then the clouds are null, and what was shown stays
  bool ended{false};  ///< the error: this frame could not be read
  std::vector<Camera> cameras;
  std::vector<io::ColorImage> thumbnails;  ///< empty: the camera is missing
  double read_ms{0};
  std::array<std::shared_ptr<const FusedCloud>, kPanes> clouds;
};

}  // namespace fuse_flow::viewing
