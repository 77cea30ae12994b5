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

/** \brief The images of one camera at one instant. Of those that are absent, which the DepthView says, the pixels may be those of an earlier frame. Either depth16 or depth32 is filled; neither, if the camera has no
 *  depth. */
struct LoadedView {
  DepthImage depth16;      ///< as it is in the file
  FloatImage depth32;      ///< metres
  ColorImage color;        ///< of the depth image's size, or of Camera::color
  std::string color_file;  ///< the file that color was read from; empty: none
  FloatImage confidence;   ///< of the depth image's size, in [0, 1]
  /** \brief Value of one step of the confidence image's file, if it is not given and the largest value of the file's type counts as 1; else
   *  0. */
  float assumed_confidence_step{0};
};

/** \brief A view that is missing because a file of it cannot be read, or because its camera's files end before. */
struct DamagedView {
  std::size_t view{0};  ///< its position among the cameras
  std::string message;  ///< one line that names the file, or the camera
};

/** \brief One instant, with the memory of its images: rig.views point into images. Read every frame into the same object, so that the
 *  buffers are reused. */
struct LoadedFrame {
  LoadedFrame() = default;
  LoadedFrame(LoadedFrame&&) = default;             ///< rig.views go on pointing to the same images
  LoadedFrame& operator=(LoadedFrame&&) = default;  ///< the same
  LoadedFrame(const LoadedFrame&) = delete;         // the views of a copy would point into the original
  LoadedFrame& operator=(const LoadedFrame&) = delete;

  RigFrame rig;                      ///< the input of FuseFlow::fuse()
  std::vector<LoadedView> images;    ///< of the views, in their order
  std::vector<DamagedView> damaged;  ///< empty unless RecordingOptions::skip_damaged
  std::vector<DamagedView> ended;    ///< of a rig: "camera 'left' ends after 3 of 4 frames"
};

/** \brief What the numbers of a camera's depth images are, where they are not z in the camera's frame. */
struct DepthMeaning {
  /** \brief Whether they are distances from the optical centre, along the ray of the pixel: z = distance / √(1 + x² + y²) for the ray (x, y, 1). */
  bool is_distance{false};
  /** \brief Metres that are added to each measurement, before it becomes z; −10 … 10. */
  float offset{0};

  /** \brief Whether they are z. */
  bool isZ() const { return !is_distance && offset == 0; }
};

/** \brief A source of rig frames: a folder of images with a calibration, or files of recorders, see openRecording(). Only one thread may use an
 *  object, but for read(), where readsConcurrently(). */
class Recording {
 public:
  virtual ~Recording() = default;

  /** \brief "rig", "seven_scenes", "tum", "redwood", "mvsnet", "colmap", "pcd", "mkv", "bag" or "video". */
  virtual std::string kind() const = 0;
  /** \brief One more than the highest frame number. */
  virtual std::size_t frameCount() const = 0;
  /** \brief The numbers of the existing frames, ascending. In a rig, a frame exists if any camera has a depth image of it, or, if it is one
   *  without depth, a colour image. */
  virtual std::vector<std::size_t> frames() const;
  /** \brief Rate at which its frames were taken, Hz; > 0. Absent: the recording does not give it. */
  virtual std::optional<double> framesPerSecond() const { return std::nullopt; }
  /** \brief The cameras of frame 0. In a recording of one moving camera they differ from frame to frame: see
   *  LoadedFrame::rig. */
  virtual const std::vector<Camera>& cameras() const = 0;
  /** \brief Whether a camera measures depth. If not, its views have colour alone: they are missing(), and their color is set. */
  virtual bool hasDepth(std::size_t camera) const {
    (void)camera;
    return true;
  }
  /** \brief Whether some of a camera's views may have colour. */
  virtual bool hasColor(std::size_t camera) const {
    (void)camera;
    return true;
  }
  /** \brief Value of one step of a camera's confidence images, as RigCamera::confidence_scale. Absent: the recording does not give it. */
  virtual std::optional<float> confidenceScale(std::size_t camera) const {
    (void)camera;
    return std::nullopt;
  }
  /** \brief What a camera's depth images are in its files. What read() gives is always z: in LoadedView::depth32, where they are something else. */
  virtual DepthMeaning depthMeaning(std::size_t camera) const {
    (void)camera;
    return {};
  }
  /** \brief How many images of a camera are in no frame, since no other camera has one of the same time. 0 where frames are not put together by
   *  time. */
  virtual std::size_t imagesWithoutPartner(std::size_t camera) const {
    (void)camera;
    return 0;
  }
  /** \brief Name of a camera's files, for messages and reports: "frame-000060", "left". */
  std::string viewName(std::size_t view) const { return cameras()[view].name; }
  /** \brief All files of the recording, also those of frames and cameras that are not selected. If a whole folder belongs to the recording,
   *  the folder. No output of a tool may overwrite them, see InputFiles. */
  virtual std::vector<std::string> inputs() const = 0;
  /** \brief Reads a frame in [0, frameCount()) into out, and overwrites its content. A camera whose depth file is not there becomes a
   *  missing view; one without depth is a missing view with colour. Throws InputError on a damaged file or an image that does not fit its camera, unless
   *  RecordingOptions::skip_damaged. */
  virtual void read(std::size_t frame, LoadedFrame& out) = 0;

  /** \brief Whether several threads may call read() at a time, each with a frame of its own. */
  virtual bool readsConcurrently() const { return false; }

  /** \brief Assumptions and ignored inputs at opening, one line each, without a line end. */
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::vector<std::string> warnings_;  ///< see warnings()
};

/** \brief The existing frames that an option selects, in the format of parseRange(); empty: all frames. Throws OptionError if a listed
 *  number does not exist, and if no frame is left. */
std::vector<std::size_t> chooseFrames(const Recording& recording, const std::string& spec,
                                      const std::string& option = "--frames");

/** \brief The meaning of the numbers of T_world_camera, for files whose format or writer uses another convention. */
enum class PoseConvention {
  CameraToWorld,  ///< x right, y down, z forward, camera to world
  WorldToCamera,  ///< its inverse, as COLMAP and OpenCV's solvePnP() give it
  OpenGl          ///< camera to world, of axes x right, y up, z backward, as in Blender, NeRF and ARKit
};

/** \brief Options for opening a recording. */
struct RecordingOptions {
  /** \brief "0,60,120,180" or "A:B:STEP", B exclusive. In a recording of one moving camera: the frame numbers that act
   *  as the cameras of one instant, required. In a rig: the cameras to use, by position; empty means all. */
  std::string views;
  /** \brief One moving camera only: frame k uses views + k · slide, as long as all of them exist. 0: a single instant.
   */
  int slide{0};
  /** \brief Metres per depth unit; replaces the value of the recording or of its format. In photographs with estimated depth ("mvsnet",
   *  "colmap"), of positions too. */
  std::optional<float> depth_scale;
  /** \brief A file with the camera's intrinsics, for recordings of one moving camera; replaces the file beside the images, see
   *  readIntrinsicsFile(). Empty: none. */
  std::string intrinsics;
  /** \brief Convention of the recording's own poses. The poses in the file `poses` are always camera to world. */
  PoseConvention pose_convention{PoseConvention::CameraToWorld};
  /** \brief A rig.json whose poses replace the recording's own poses; empty: none. Of videos, which say neither, also the intrinsics. */
  std::string poses;
  /** \brief Of .mkv files and videos: seconds, 0 … 10⁶, that are added to the times of the images of each file, in their order. Empty: what the files say; where
   *  nothing says how their clocks relate, their first images are of the same moment. */
  std::vector<double> time_offsets;
  /** \brief True: several cameras of a recorder's files may stand nobody knows where, and begin at the world's origin, which is where their
   *  calibration begins; false: openRecording() throws. */
  bool without_poses{false};
  /** \brief False: colour images are not opened. */
  bool read_color{true};
  /** \brief A camera with a file that cannot be read is missing from that frame, see LoadedFrame::damaged; false: read()
   *  throws. PCD files, and depth of "mvsnet" and "colmap", are read as they are opened, and then it throws always. */
  bool skip_damaged{false};
  /** \brief Threads that decode the images of a frame, several cameras at a time; 0: one for each core. */
  int threads{0};
  ///@{
  /** \brief Of several processes that share a recording: of `parts` parts, counted from 0, the number of this one's. It reads the images of its
   *  cameras alone, see isInPart(); the views of all others are missing. PCD files are read whole. */
  int part{0};
  int parts{1};
  ///@}
};

/** \brief Whether a camera is of a part of several, see RecordingOptions::part: each has as many, to one, and those that follow one another.
 *  \param cameras how many there are in all */
inline bool isInPart(std::size_t camera, std::size_t cameras, int part, int parts) {
  const auto first = [&](int k) { return cameras * static_cast<std::size_t>(k) / static_cast<std::size_t>(parts); };
  return camera >= first(part) && camera < first(part + 1);
}

/** \brief Opens a recording with the reader for its format. One path: a folder, its rig.json, or a file of a recorder. Several paths:
 *  files of recorders or videos, one for each camera, or organised PCD files, each from one camera at one instant. Throws InputError. */
std::unique_ptr<Recording> openRecording(const std::vector<std::string>& inputs, const RecordingOptions& options = {});

}  // namespace fuse_flow::io
