#pragma once

#include "recordings/readers/view_files.h"

#include <fuse_flow/recordings/recording.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief One image pair of a moving camera. */
struct SequenceFrame {
  ViewFiles files;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  /** \brief Microseconds; 0 where the format has no time. */
  std::uint64_t stamp{0};
  std::string name;
};

/** \brief A recording of one moving camera in a static scene: frames taken at different times act as the cameras of one
 *  instant. The formats differ in how they list their frames; this is what they share. */
struct Sequence {
  std::string kind;
  std::string path;
  /** \brief Files and folders beside those of the frames, see Recording::inputs(). */
  std::vector<std::string> inputs;
  /** \brief By the number that --views uses. */
  std::map<std::size_t, SequenceFrame> frames;
  /** \brief Frames that have a depth image but no pose, with the message for a user who selects one. */
  std::map<std::size_t, std::string> unposed;
  /** \brief Of the camera that took the format's own dataset, for where no file beside the images says them; width 0: there is none. */
  Intrinsics usual_intrinsics;
  std::string usual_camera;   ///< what messages call that camera
  bool usual_certain{false};  ///< the folder's name says that it is the one
  float depth_scale{0.001f};
  std::string color_expected;  ///< where colour must be, for a folder in which none was found: "listed in rgb.txt"
  /** \brief What was assumed or left out as it was read, a line each. */
  std::vector<std::string> warnings;
};

/** \brief The intrinsics come from the file of RecordingOptions::intrinsics, else from one that lies beside the images, else they are
 *  those of the format's own dataset, where the images have their size. Throws OptionError if options name no views or views that do not exist, InputError if one has
 *  no pose, and where nothing says the intrinsics. */
std::unique_ptr<Recording> openSequence(Sequence sequence, const RecordingOptions& options);

}  // namespace fuse_flow::io
