#pragma once

#include <fuse_flow/recordings/error.h>
#include <fuse_flow/recordings/image.h>
#include <fuse_flow/rig_frame.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief The images of one camera at one instant; an absent one is empty. Either depth16 or depth32 is filled. */
struct LoadedView {
  DepthImage depth16;     ///< as it is in the file
  FloatImage depth32;     ///< metres
  ColorImage color;       ///< of the depth image's size, or of Camera::color
  FloatImage confidence;  ///< of the depth image's size, in [0, 1]
  /** \brief What one step of the confidence image's file stands for, where nobody has said it and the largest value of its type is
   *  taken for 1; else 0. */
  float assumed_confidence_step{0};
};

/** \brief A view that is missing because a file of it cannot be read, or because its camera's files end before. */
struct DamagedView {
  std::size_t view{0};  ///< its position among the cameras
  std::string message;  ///< one line that names the file, or the camera
};

/** \brief One instant with the memory behind it: rig.views point into images. Read every frame into the same one: the
 *  buffers are reused. */
struct LoadedFrame {
  LoadedFrame() = default;
  LoadedFrame(LoadedFrame&&) = default;
  LoadedFrame& operator=(LoadedFrame&&) = default;
  LoadedFrame(const LoadedFrame&) = delete;  // the views of a copy would point into the original
  LoadedFrame& operator=(const LoadedFrame&) = delete;

  RigFrame rig;                      ///< what FuseFlow::fuse() takes
  std::vector<LoadedView> images;    ///< of the views, in their order
  std::vector<DamagedView> damaged;  ///< empty unless RecordingOptions::skip_damaged
  std::vector<DamagedView> ended;    ///< of a rig: "camera 'left' ends after 3 of 4 frames"
};

/** \brief A source of rig frames: a folder of images with a calibration, see openRecording(). An object is for one thread. */
class Recording {
 public:
  virtual ~Recording() = default;

  /** \brief "rig", "seven_scenes", "tum", "redwood" or "pcd". */
  virtual std::string kind() const = 0;
  /** \brief One more than the highest frame number. */
  virtual std::size_t frameCount() const = 0;
  /** \brief The numbers of the frames that there are, ascending: of a rig those of which any camera has a depth image. */
  virtual std::vector<std::size_t> frames() const;
  /** \brief At which its frames were taken, Hz; > 0. Absent: it does not say. */
  virtual std::optional<double> framesPerSecond() const { return std::nullopt; }
  /** \brief The cameras of frame 0. In a recording of one moving camera they differ from frame to frame: see
   *  LoadedFrame::rig. */
  virtual const std::vector<Camera>& cameras() const = 0;
  /** \brief What a step of a camera's confidence images is worth, as RigCamera::confidence_scale; absent: it does not say. */
  virtual std::optional<float> confidenceScale(std::size_t camera) const {
    (void)camera;
    return std::nullopt;
  }
  /** \brief What one camera's files are called, for messages and reports: "frame-000060", "left". */
  std::string viewName(std::size_t view) const { return cameras()[view].name; }
  /** \brief The files that it is made of, read or not: those of frames and cameras that were not chosen, too; of a folder all of
   *  which belongs to it, the folder. Nothing that a tool writes may take their place, see InputFiles. */
  virtual std::vector<std::string> inputs() const = 0;
  /** \brief Replaces what out holds by a frame in [0, frameCount()). A camera whose depth file is not there becomes a
   *  missing view. Throws InputError on a damaged file or an image that does not fit its camera, unless
   *  RecordingOptions::skip_damaged. */
  virtual void read(std::size_t frame, LoadedFrame& out) = 0;

  /** \brief What was assumed, left out or not used as it was opened, a line each, without a line end. */
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::vector<std::string> warnings_;
};

/** \brief The frames that an option names, as parseRange() reads it, of those that there are; empty: all. Throws OptionError for a single
 *  number, or a list of some, that is not there, and where none is left. */
std::vector<std::size_t> chooseFrames(const Recording& recording, const std::string& spec,
                                      const std::string& option = "--frames");

/** \brief What T_world_camera's numbers mean in a file whose format leaves it open, or whose writer took it otherwise. */
enum class PoseConvention {
  CameraToWorld,  ///< x right, y down, z forward, camera to world
  WorldToCamera,  ///< its inverse, as COLMAP and OpenCV's solvePnP() give it
  OpenGl          ///< camera to world, of axes x right, y up, z backward, as in Blender, NeRF and ARKit
};

/** \brief How to look at a recording. */
struct RecordingOptions {
  /** \brief "0,60,120,180" or "A:B:STEP", B exclusive. In a recording of one moving camera: the frame numbers that act
   *  as the cameras of one instant, required. In a rig: the cameras to use, by position; empty means all. */
  std::string views;
  /** \brief One moving camera only: frame k uses views + k · slide, as long as all of them exist. 0: a single instant.
   */
  int slide{0};
  /** \brief Metres per depth unit, in place of what the recording says or its format implies. */
  std::optional<float> depth_scale;
  /** \brief A file of the camera's intrinsics, in place of what lies beside the images, see readIntrinsicsFile(); of a recording of one
   *  moving camera. Empty: none. */
  std::string intrinsics;
  /** \brief What the recording's own poses mean; those of poses are camera to world always. */
  PoseConvention pose_convention{PoseConvention::CameraToWorld};
  /** \brief A rig.json whose poses stand in for the recording's own; empty: none. */
  std::string poses;
  /** \brief False: colour images are not opened. */
  bool read_color{true};
  /** \brief A camera with a file that cannot be read is missing from that frame, see LoadedFrame::damaged; false: read()
   *  throws. PCD files are read as they are opened, and then it throws always. */
  bool skip_damaged{false};
};

/** \brief Looks at what it is given and picks the reader. One path: a folder, or its rig.json; several: organised PCD
 *  files, each a camera of one instant. Throws InputError. */
std::unique_ptr<Recording> openRecording(const std::vector<std::string>& inputs, const RecordingOptions& options = {});

}  // namespace fuse_flow::io
