#pragma once

#include <fuse_flow/recordings/recording.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace fuse_flow::io {

/** \brief Where one camera's images of one instant are; a path may be empty, and its file may not exist. */
struct ViewFiles {
  std::string depth;
  std::string color;
  std::string confidence;
  bool color_alone{false};      ///< the camera has no depth; a path of colour was there when the recording was opened
  bool depth_was_there{false};  ///< when the recording was opened: if it is not any more, no camera has missed a frame
};

/** \brief How a rig recording names the files of a frame, without the extension: "000042". */
std::string frameStem(std::size_t frame);

/** \brief folder/stem.png, .jpg or .jpeg, also in capitals, whichever exists; else "". */
std::string findImage(const std::string& folder, const std::string& stem);

/** \brief Whether a file is named as findImage() looks for them. */
bool isImage(const std::string& name);

/** \brief Whether a file is named like an image of depth: .png, isFloatImage() or isTiff(). */
bool isDepthImage(const std::string& name);

/** \brief Whether a file is named as findConfidence() looks for them. */
bool isConfidenceImage(const std::string& name);

/** \brief folder/stem.pfm, .npy or .exr, also in capitals, whichever exists; else "". */
std::string findFloatImage(const std::string& folder, const std::string& stem);

/** \brief The same, or .png. */
std::string findConfidence(const std::string& folder, const std::string& stem);

/** \brief A camera's folder of colour images: color, or, where there is none, rgb or image; "" if it has neither. */
std::string colorFolder(const std::string& folder);

/** \brief Reads what is there into images and points view at it. Depth is a 16-bit PNG or TIFF, or a float TIFF or a file of readFloatImage() in units that the caller makes
 *  metres of. Confidence is a PNG, or such a file of numbers from 0 to 1. Without a depth file the view is missing, whatever
 *  else exists, but for the colour of a camera without depth. Throws InputError on a damaged file, on an image whose size is not its camera's, and where the depth file is gone.
 *  \param confidence_scale confidence per step of its image; absent: the largest value of the file's type is 1 */
void loadView(const ViewFiles& files, const Camera& camera, std::optional<float> confidence_scale, LoadedView& images,
              DepthView& view);

/** \brief Loads the views of a frame, several at a time, as RecordingOptions ask for it. */
class ViewLoading {
 public:
  /** \brief By skip_damaged, threads, part and parts. */
  explicit ViewLoading(const RecordingOptions& options)
      : skip_damaged_(options.skip_damaged), threads_(options.threads), part_(options.part), parts_(options.parts) {}

  bool skipsDamaged() const { return skip_damaged_; }
  /** \brief Whether the images of a camera are read; or its view is missing. */
  bool reads(std::size_t camera, std::size_t cameras) const { return isInPart(camera, cameras, part_, parts_); }

  /** \brief out.rig.views and out.images must be as many as the views. \param load of a view, by its number; may throw InputError: that is
   *  added to out.damaged, and the view is missing, or the first view's is thrown */
  void load(std::size_t views, const std::function<void(std::size_t)>& load, LoadedFrame& out) const;

 private:
  bool skip_damaged_;
  int threads_, part_, parts_;
};

}  // namespace fuse_flow::io
