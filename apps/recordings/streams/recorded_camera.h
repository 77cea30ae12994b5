#pragma once

#include "recordings/streams/frame_sets.h"

#include <fuse_flow/recordings/recording.h>

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief The images of one sensor, as a recorder wrote them. */
class ImageTrack {
 public:
  virtual ~ImageTrack() = default;

  /** \brief When they were taken, strictly ascending. */
  virtual const std::vector<Nanoseconds>& stamps() const = 0;
  /** \brief The bytes of an image as they are in the file. Fastest in the order of the numbers. Only one thread may use the tracks of a file.
   *  Throws InputError, naming file and image. */
  virtual void fetch(std::size_t image, std::string& bytes) = 0;
  /** \brief Decodes them into depth16 or depth32 of into, and empties the other; or into its color. Many threads may do that at a time. Throws
   *  InputError, naming file and image. */
  virtual void decode(std::size_t image, const std::string& bytes, LoadedView& into) const = 0;
};

/** \brief One camera of a recorder's file. */
struct RecordedCamera {
  Camera camera;
  bool posed{false};  ///< the file says where it stands
  std::string world;  ///< in which frame, as the file calls it
  std::string frame;  ///< what the file calls the camera's own frame
  std::string file;   ///< for messages
  /** \brief Cameras of the same clock are put together by their stamps. */
  std::string clock;
  std::unique_ptr<ImageTrack> depth;  ///< null: it has none
  std::unique_ptr<ImageTrack> color;  ///< null: it has none
  Nanoseconds depth_delay{0};         ///< from a colour image to the depth image that belongs to it
};

/** \brief Cameras of one or several files as a recording. Throws InputError if there is none; if several stand nobody knows where, and RecordingOptions::poses is empty; and for a camera that checkCameraInput() refuses.
 *  \param kind see Recording::kind()  \param files all that was opened  \param warnings of opening them */
std::unique_ptr<Recording> openRecordedCameras(std::string kind, std::vector<RecordedCamera> cameras,
                                               std::vector<std::string> files, std::vector<std::string> warnings,
                                               const RecordingOptions& options);

/** \brief What a camera is called whose file is one of several: the file's name, or where two have the same, the folder's. */
std::string cameraName(const std::string& path, const std::vector<std::string>& paths);

}  // namespace fuse_flow::io
