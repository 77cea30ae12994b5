#pragma once

#include <cstddef>
#include <optional>

namespace fuse_flow::viewing {

/** \brief The current frame: a clock that plays, pauses, steps, seeks and loops. It does not read the time; its owner passes the elapsed
 *  time. */
class Playback {
 public:
  static constexpr double kSlowest = 1.0 / 64, kFastest = 64;  ///< of speed()

  /** \param frames absent: the source has no end, as live cameras  \param frames_per_second at speed 1; > 0 */
  Playback(std::optional<std::size_t> frames, double frames_per_second)
      : frames_(frames), frames_per_second_(frames_per_second) {}

  /** \brief While playing, moves on by that many seconds of the viewer's time. At the end it starts again, or pauses on
   *  the last frame. */
  void advance(double seconds);

  void play();
  void pause() { playing_ = false; }
  void toggle() { playing_ ? pause() : play(); }
  /** \brief Pauses, and moves by whole frames; around the ends where it loops. */
  void step(long frames);
  /** \brief The frame, or the last one if there are fewer. Goes on playing if it was. */
  void seek(std::size_t frame);
  void seekEnd();
  /** \brief Kept within kSlowest and kFastest. */
  void setSpeed(double speed);
  void setLoop(bool loop) { loop_ = loop; }

  std::size_t frame() const;
  std::optional<std::size_t> frames() const { return frames_; }
  bool playing() const { return playing_; }
  bool loop() const { return loop_; }
  double speed() const { return speed_; }
  /** \brief At speed 1. */
  double framesPerSecond() const { return frames_per_second_; }

 private:
  double last() const { return static_cast<double>(*frames_ - 1); }

  std::optional<std::size_t> frames_;
  double frames_per_second_;
  double position_{0};  ///< in frames; its whole part is the frame
  double speed_{1};
  bool playing_{false};
  bool loop_{true};
};

}  // namespace fuse_flow::viewing
