#include "live/played_cameras.h"

#include "recordings/absent_images.h"
#include "recordings/files/interrupt.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace fuse_flow::io {
namespace {

constexpr double kAssumedRate = 30;  // Hz, of a recording that says nothing of it

std::chrono::steady_clock::duration durationOf(double seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

PlayedCameras::PlayedCameras(std::unique_ptr<Recording> recording, std::vector<std::size_t> frames,
                             const PlayOptions& options)
    : recording_(std::move(recording)),
      frames_(std::move(frames)),
      options_(options),
      still_there_(*recording_),
      period_(1 / recording_->framesPerSecond().value_or(kAssumedRate)) {
  const std::vector<Camera>& all = recording_->cameras();
  for (const PlayOptions::Stall& stall : options_.stalls)
    if (stall.camera >= all.size())
      throw InputError("a camera that stalls has the number " + std::to_string(stall.camera) + ", must be under " +
                       std::to_string(all.size()));
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (!isInPart(k, all.size(), options_.part, options_.parts)) continue;
    if (cameras_.empty()) first_ = k;
    cameras_.push_back(all[k]);
  }
  if (!recording_->framesPerSecond())
    warnings_.push_back("the recording does not say at which rate it was taken; it is played at 30 frames a second");
  last_due_.resize(all.size());
}

PlayedCameras::~PlayedCameras() { stop(); }

void PlayedCameras::start(const Receiver& receiver) {
  receiver_ = receiver;
  if (options_.preload) {
    ReadAhead reading(*recording_, frames_, 2);
    while (kept_.size() < frames_.size()) {
      if (interrupt_requested) return;
      const std::shared_ptr<LoadedFrame> frame = pool_.next();
      reading.next(*frame);
      clearAbsentImages(*frame);
      kept_.push_back(frame);
    }
  }
  running_ = true;
  thread_ = std::thread(&PlayedCameras::run, this);
}

void PlayedCameras::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  stopped_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool PlayedCameras::running() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return running_;
}

std::string PlayedCameras::failure() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return failure_;
}

void PlayedCameras::run() {
  std::string failure;
  try {
    play();
  } catch (const std::exception& error) {
    failure = error.what();
  }
  reading_.reset();
  const std::lock_guard<std::mutex> lock(mutex_);
  failure_ = failure;
  running_ = false;
}

void PlayedCameras::play() {
  begin_ = Clock::now();
  Clock::duration behind{0};  // in all, for which files were waited
  double seconds = 0, pass = 0;
  std::uint64_t first_of_pass = 0, before = 0;
  do {
    for (place_ = 0; place_ < frames_.size(); ++place_) {
      const Frame frame = next();
      const std::vector<Camera>& first = recording_->cameras();
      for (std::size_t k = 0; k < first.size(); ++k)
        if (!sameCalibration(frame->rig.cameras[k], first[k]))
          throw InputError("camera '" + first[k].name +
                           "' is elsewhere than in the first frame, as with --slide; its cameras must stand");
      for (const DamagedView& view : frame->damaged) receiver_.notice(view.message);
      const std::uint64_t stamp = frame->rig.stamp;
      if (place_ == 0) {
        first_of_pass = stamp;
        if (pass == 0) first_stamp_ = stamp;
        seconds = pass;
      } else if (stamp > before) {
        seconds = pass + 1e-6 * static_cast<double>(stamp - first_of_pass);
      } else {
        seconds += period_;  // it has no stamps
      }
      before = stamp;
      if (!deliverUntil(begin_ + durationOf(seconds / options_.speed))) return;
      const Clock::duration late = Clock::now() - (begin_ + durationOf(seconds / options_.speed));
      if (late > std::chrono::milliseconds(20)) {  // no scheduler's doing
        // Other parts of the recording do not wait, so this one catches up.
        if (options_.parts > 1) {
          behind = std::max(behind, late);
        } else {
          begin_ += late;
          behind += late;
        }
      }
      schedule(frame, seconds);
      if (!deliverUntil(Clock::now())) return;  // before the next frame is waited for
    }
    pass = seconds + period_;
  } while (options_.loop && !frames_.empty());
  if (!due_.empty() && !deliverUntil(std::prev(due_.end())->first)) return;
  const double played = seconds / options_.speed, waited = std::chrono::duration<double>(behind).count();
  if (waited > 0.05 * played + 0.1) {
    char line[160];
    std::snprintf(line, sizeof line,
                  "it was played at %.2f of its rate: its files cannot be read, nor its views be taken, faster",
                  played / (played + waited));
    receiver_.notice(line);
  }
}

PlayedCameras::Frame PlayedCameras::next() {
  if (options_.preload) return kept_[place_];
  if (place_ == 0) {
    reading_.reset();
    reading_.emplace(*recording_, frames_, 2);
  }
  const std::shared_ptr<LoadedFrame> frame = pool_.next();
  reading_->next(*frame);
  clearAbsentImages(*frame);
  still_there_.check(*frame);
  return frame;
}

double PlayedCameras::random() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

std::uint64_t PlayedCameras::stampOf(std::size_t camera, double seconds) const {
  const double time = seconds / options_.speed * 1e6;
  if (!options_.own_clocks) return first_stamp_ + static_cast<std::uint64_t>(std::llround(time));
  // Apart by the golden ratio: no two alike, however many.
  const double share = std::fmod(0.618 * static_cast<double>(camera + 1), 1.0);
  return static_cast<std::uint64_t>(std::llround(60e6 * share + time * (1 + 50e-6 * (2 * share - 1))));
}

void PlayedCameras::schedule(const Frame& frame, double seconds) {
  const double at = seconds / options_.speed;
  for (std::size_t camera = 0; camera < frame->images.size(); ++camera) {
    const LoadedView& images = frame->images[camera];
    // As many random numbers for each view, so that what one camera loses changes nothing for another.
    const double late = options_.jitter * random();
    const bool lost = random() < options_.drop;
    if (lost || (images.depth16.empty() && images.depth32.empty() && images.color.empty())) continue;
    const auto stalls = [&](const PlayOptions::Stall& stall) {
      return stall.camera == camera && at >= stall.from && at < stall.from + stall.duration;
    };
    if (std::any_of(options_.stalls.begin(), options_.stalls.end(), stalls)) continue;
    if (camera < first_ || camera >= first_ + cameras_.size())
      continue;  // another part's; random numbers are drawn for all
    const Clock::time_point due = std::max(last_due_[camera], begin_ + durationOf(at + late));
    last_due_[camera] = due;
    // It shares the frame's ownership.
    due_.emplace(
        due, CameraView{camera - first_, stampOf(camera, seconds), std::shared_ptr<const LoadedView>(frame, &images)});
  }
}

bool PlayedCameras::deliverUntil(Clock::time_point time) {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    const bool earlier = !due_.empty() && due_.begin()->first <= time;
    const Clock::time_point next = earlier ? due_.begin()->first : time;
    if (stopped_.wait_until(lock, next, [this] { return stopping_; })) return false;
    if (!earlier) return true;
    CameraView view = std::move(due_.begin()->second);
    due_.erase(due_.begin());
    lock.unlock();
    receiver_.view(std::move(view));
    lock.lock();
  }
}

}  // namespace fuse_flow::io
