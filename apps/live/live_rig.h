#pragma once

#include "live/camera_source.h"

#include <fuse_flow/live/view_synchronizer.h>
#include <fuse_flow/recordings/rig_json.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief How a camera does. */
struct CameraStatus {
  std::string name;
  double rate{0};             ///< views a second, over the last two seconds
  std::uint64_t received{0};  ///< views
  std::uint64_t lost{0};      ///< views that the camera has not delivered, by the gaps between its stamps
  std::uint64_t used{0};      ///< views that are in a frame
  std::uint64_t unused{
      0};  ///< views that are in no frame: late, without a partner, or nobody had time for their instant
  /** \brief How far its clock is behind that of the first camera; 0 if they share one. As the arrival of their views tells it. */
  std::chrono::microseconds clock_offset{0};
  /** \brief Seconds since it delivered something, or since the start; absent while it delivers. */
  std::optional<double> silent;
};

/** \brief The views of one instant. */
struct LiveInstant {
  RigFrame rig;  ///< its views point into held
  /** \brief Of each camera, its images; null: the camera is missing, or another rank has them. */
  std::vector<std::shared_ptr<const LoadedView>> held;
  std::vector<std::optional<std::uint64_t>>
      stamps;  ///< of each camera, its view's CameraView::stamp; absent: the camera is missing
  std::chrono::microseconds arrived{0};  ///< when its last view came, by the host's clock
  /** \brief What rig points into beside held, of cameras whose depth was estimated; null: none was. */
  std::shared_ptr<const LoadedFrame> estimated;

  /** \brief Gives a camera its images, and its view of them. */
  void setView(std::size_t camera, std::shared_ptr<const LoadedView> images);
};

/** \brief Cameras that run, as one rig: their views are put together by time into frames that FuseFlow can fuse. next() is for one thread;
 *  everything else for any. */
class LiveRig {
 public:
  struct Options {
    /** \brief clocks is chosen: Shared if there is one source, or one clock, and every source says so. */
    SynchronizerParameters synchronizer;
    /** \brief Whether the sources have one clock, as the parts of one recording that is played have. */
    bool one_clock{false};
    /** \brief Seconds without a view after which a camera is said to have stopped; of one that is slow, three of its periods. */
    double silent_after{1};
    /** \brief The host's time; default: that of day when the rig was made, and from then on steady. */
    std::function<std::chrono::microseconds()> clock;
  };
  /** \brief A view as it came. \param camera its position in the rig \param time when it was exposed, microseconds of the clock of sets */
  using Listener = std::function<void(std::size_t camera, std::uint64_t time, const CameraView& view)>;

  /** \param sources their cameras, one after the other, are the rig's; names that are there twice get a number
   *  \throws InputError if there is no camera */
  LiveRig(std::vector<std::unique_ptr<CameraSource>> sources, const Options& options);
  ~LiveRig();
  LiveRig(const LiveRig&) = delete;
  LiveRig& operator=(const LiveRig&) = delete;

  const std::vector<Camera>& cameras() const { return cameras_; }
  /** \brief Of each camera, whether it delivers colour. */
  const std::vector<bool>& colored() const { return has_color_; }
  /** \brief Of each camera, whether it measures no depth. */
  const std::vector<bool>& lacksDepth() const { return lacks_depth_; }
  /** \brief Before start(): where the cameras stand, their depth and multipath corrections, and noise, and the intrinsics of those that do not know them:
   *  of each, the entry of its name; where no
   *  name fits, that of its place, which is warned of. \param file its name, for messages \throws InputError if one has none */
  void setPoses(const std::string& file, const std::vector<RigCamera>& calibrated);
  /** \brief The cameras of which nobody has said where they stand, while another camera is there. */
  std::vector<std::string> withoutPoses() const;
  /** \brief The cameras of which nobody has said what lens they have: their intrinsics are not to be used. */
  std::vector<std::string> withoutIntrinsics() const;
  /** \brief See CameraSource::inputs(). */
  std::vector<std::string> inputs() const;
  /** \brief What was assumed at opening, one line each. */
  std::vector<std::string> warnings() const;

  /** \brief Before start(): hears of each view, in the thread of its camera, before it is put together with others; must not wait. */
  void setListener(Listener listener) { listener_ = std::move(listener); }
  /** \throws InputError if a source cannot be started */
  void start();
  /** \brief No view comes any more. */
  void stop();
  /** \brief False: no source will deliver anything more. \throws InputError if one ended where it should have gone on */
  bool running() const;

  /** \brief The latest instant. False: none came in that time. */
  bool next(std::chrono::milliseconds timeout, LiveInstant& instant);
  /** \brief The host's time, as in LiveInstant::arrived. */
  std::chrono::microseconds now() const { return options_.clock(); }

  std::vector<CameraStatus> status() const;
  SynchronizerStatistics statistics() const { return synchronizer_->getStatistics(); }
  /** \brief What happened since the last call, one line each: cameras that stopped, that deliver again, and what sources said. */
  std::vector<std::string> takeNotices();

 private:
  using Microseconds = std::chrono::microseconds;

  struct Payload {
    std::shared_ptr<const LoadedView> images;
    Microseconds arrival{0};
  };
  /** \brief What is counted of a camera as its views arrive. */
  struct Stream {
    std::deque<Microseconds> arrivals;  ///< of the last two seconds
    std::optional<Microseconds> last;   ///< arrival
    Microseconds usual_gap{0};          ///< between arrivals
    std::optional<std::uint64_t> stamp;
    std::uint64_t heard{0};  ///< what its listener was told last
    detail::FramePeriod period;
    std::uint64_t received{0}, lost{0};
    bool silent{false};
  };

  /** \param view its camera is the rig's */
  void receive(CameraView view);
  void notice(const std::string& line);
  /** \brief How long a camera may deliver nothing. */
  Microseconds patience(const Stream& stream) const;

  std::vector<std::unique_ptr<CameraSource>> sources_;
  Options options_;
  std::vector<Camera> cameras_;
  std::vector<bool> posed_;
  std::vector<bool> has_color_, lacks_depth_, has_intrinsics_;
  std::vector<const CameraSource*> source_of_;
  std::vector<std::string> warnings_;
  std::unique_ptr<ViewSynchronizer<Payload>> synchronizer_;
  Listener listener_;
  mutable std::mutex mutex_;
  // The mutex guards the following members.
  Microseconds started_{0};
  std::vector<Stream> streams_;
  std::vector<std::string> notices_;
};

/** \brief "left:  29.9 a second, 12 lost, 3 unused, clock +1.2 ms", for people. */
std::string describe(const CameraStatus& status);

}  // namespace fuse_flow::io
