#pragma once

#include "live/camera_source.h"
#include "recordings/pool.h"
#include "recordings/read_ahead.h"
#include "recordings/still_there.h"

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <thread>

namespace fuse_flow::io {

/** \brief How a recording is played as if it were cameras. What is random is the same in every run. */
struct PlayOptions {
  double speed{1};   ///< 1: as it was taken; > 0
  bool loop{false};  ///< from the start again after the last frame, with stamps that go on
  double jitter{0};  ///< seconds: each view arrives later by anything from 0 to this; ≥ 0
  double drop{0};    ///< share of the views that a camera loses, 0 … 1
  /** \brief A camera that delivers nothing for a while, as one that is unplugged. */
  struct Stall {
    std::size_t camera{0};  ///< its position
    double from{0};         ///< seconds after the start of playing
    double duration{0};     ///< seconds
  };
  std::vector<Stall> stalls;
  /** \brief Each camera stamps with a clock of its own, up to a minute apart, and up to 50 µs a second faster or slower. */
  bool own_clocks{false};
  /** \brief Of several processes that play one recording, as RecordingOptions has them: this one has the cameras of its part, and no others. */
  int part{0};
  int parts{1};
  /** \brief All frames are read, and kept in memory, before the first one is delivered: to measure what comes after. */
  bool preload{false};
};

/** \brief Plays a recording at the rate at which it was taken, as if its cameras ran now. If files cannot be read that fast, it plays more
 *  slowly, and says so. */
class PlayedCameras : public CameraSource {
 public:
  /** \param recording its cameras must stand: each of its frames must have the cameras of the first
   *  \param frames of it, in this order \throws InputError for a stall of a camera that is not there */
  PlayedCameras(std::unique_ptr<Recording> recording, std::vector<std::size_t> frames, const PlayOptions& options);
  ~PlayedCameras() override;
  PlayedCameras(const PlayedCameras&) = delete;
  PlayedCameras& operator=(const PlayedCameras&) = delete;

  const std::vector<Camera>& cameras() const override { return cameras_; }
  bool hasPoses() const override { return true; }
  bool hasDepth(std::size_t camera) const override { return recording_->hasDepth(first_ + camera); }
  bool hasColor(std::size_t camera) const override { return recording_->hasColor(first_ + camera); }
  ClockModel clocks() const override { return options_.own_clocks ? ClockModel::Separate : ClockModel::Shared; }
  std::vector<std::string> inputs() const override { return recording_->inputs(); }
  void start(const Receiver& receiver) override;
  void stop() override;
  bool running() const override;
  std::string failure() const override;

 private:
  using Clock = std::chrono::steady_clock;
  using Frame = std::shared_ptr<const LoadedFrame>;

  void run();
  void play();
  /** \brief The next frame, from the files or from memory. */
  Frame next();
  /** \brief Puts the frame's views into due_. \param seconds of the frame, after the first one */
  void schedule(const Frame& frame, double seconds);
  /** \brief Delivers what is due until that time, and waits for it. False: it was stopped. */
  bool deliverUntil(Clock::time_point time);
  std::uint64_t stampOf(std::size_t camera, double seconds) const;
  double random();  ///< in [0, 1)

  std::unique_ptr<Recording> recording_;
  std::size_t first_{0};         ///< of its cameras, among the recording's
  std::vector<Camera> cameras_;  ///< of its part
  const std::vector<std::size_t> frames_;
  const PlayOptions options_;
  const StillThere still_there_;
  double period_;  ///< seconds between frames whose stamps say nothing
  std::uint64_t first_stamp_{0};
  Receiver receiver_;
  Pool<LoadedFrame> pool_;
  std::optional<ReadAhead> reading_;
  std::size_t place_{0};     ///< among frames_, of the next one
  std::vector<Frame> kept_;  ///< with PlayOptions::preload
  std::multimap<Clock::time_point, CameraView> due_;
  std::vector<Clock::time_point> last_due_;  ///< of each camera: a driver delivers in order
  Clock::time_point begin_;
  std::mt19937_64 random_{1};
  mutable std::mutex mutex_;
  std::condition_variable stopped_;
  bool stopping_{false};  ///< guarded by mutex_
  bool running_{false};   ///< guarded by mutex_
  std::string failure_;   ///< guarded by mutex_
  std::thread thread_;
};

}  // namespace fuse_flow::io
