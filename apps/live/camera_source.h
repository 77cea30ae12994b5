#pragma once

#include <fuse_flow/live/view_synchronizer.h>
#include <fuse_flow/recordings/recording.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief What a camera delivers at one instant. */
struct CameraView {
  std::size_t camera{0};   ///< its position among the source's cameras()
  std::uint64_t stamp{0};  ///< when it was exposed, microseconds of the camera's clock
  /** \brief depth16 in units of Camera::depth_scale, or depth32; colour of the depth image's size, or of Camera::color. Whoever takes the
   *  view may keep it. */
  std::shared_ptr<const LoadedView> images;
  /** \brief How long ago it came, where it was on its way since; microseconds. */
  std::chrono::microseconds age{0};
};

/** \brief One camera as it runs, or several that one driver runs. A device that is unplugged is no error: its source delivers nothing, says so
 *  once by Receiver::notice, and goes on when the device is back. */
class CameraSource {
 public:
  /** \brief What a source calls, in threads of its own. Neither may wait. */
  struct Receiver {
    std::function<void(CameraView view)> view;
    /** \brief What happened to a camera, one line: "realsense:0123: was unplugged; it is looked for again". */
    std::function<void(const std::string& line)> notice;
  };

  virtual ~CameraSource() = default;

  /** \brief Known when the source is opened: name, intrinsics, distortion, depth scale, the colour camera. T_world_camera is the identity
   *  where nobody knows where a camera stands, see hasPoses(). */
  virtual const std::vector<Camera>& cameras() const = 0;
  /** \brief Whether T_world_camera of its cameras says where they stand. */
  virtual bool hasPoses() const { return false; }
  /** \brief Whether a camera measures depth; else it has colour alone. */
  virtual bool hasDepth(std::size_t camera) const {
    (void)camera;
    return true;
  }
  /** \brief Whether cameras() has a camera's intrinsics; else only the size of its images is right. */
  virtual bool hasIntrinsics(std::size_t camera) const {
    (void)camera;
    return true;
  }
  /** \brief Whether a camera delivers colour. */
  virtual bool hasColor(std::size_t camera) const {
    (void)camera;
    return true;
  }
  /** \brief How the stamps of its cameras relate: Shared only if one clock stamps all of them. */
  virtual ClockModel clocks() const { return ClockModel::Separate; }
  /** \brief Files that no output may replace. */
  virtual std::vector<std::string> inputs() const { return {}; }

  /** \brief Begins to deliver. Called once. \throws InputError if a device cannot be started */
  virtual void start(const Receiver& receiver) = 0;
  /** \brief Nothing is delivered any more when it returns. Also before start(), and twice. */
  virtual void stop() = 0;
  /** \brief False: it will not deliver anything more, as a recording that has been played. */
  virtual bool running() const = 0;
  /** \brief Why it ended, one line, where it should have gone on; empty: it has not ended, or as it should. */
  virtual std::string failure() const { return {}; }

  /** \brief What was assumed at opening, one line each. */
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::vector<std::string> warnings_;
};

}  // namespace fuse_flow::io
