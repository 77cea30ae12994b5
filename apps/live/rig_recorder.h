#pragma once

#include "live/live_rig.h"
#include "recordings/messages/rig_messages.h"

#include <fuse_flow/recordings/recording.h>

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace fuse_flow::io {

/** \brief Writes the views of cameras into an MCAP file as they come, see RigMessages: several threads compress, another one writes. A program
 *  that is killed loses at most the last second. Any number of threads may use one object, but for finish(). */
class RigRecorder {
 public:
  struct Options {
    RigMessages::Options messages;
    unsigned int threads{0};  ///< that compress; 0: one for each core
    /** \brief Images that may wait, bytes. If more come than are compressed and written, take() waits, or the view is lost. */
    std::size_t most_waiting{std::size_t{1} << 30};
    bool waits{false};  ///< take() waits, so that nothing is lost: for what comes from files
  };

  /** \brief See RigMessages. */
  RigRecorder(const std::string& path, const std::vector<Camera>& cameras, const std::vector<bool>& has_color,
              const Options& options);
  /** \brief Of cameras that run: takes each view as it comes, by the clock of frames. \param rig not started yet; must stop before this goes */
  RigRecorder(const std::string& path, LiveRig& rig, const Options& options);
  /** \brief Without finish(): what waits is not written. */
  ~RigRecorder();
  RigRecorder(const RigRecorder&) = delete;
  RigRecorder& operator=(const RigRecorder&) = delete;

  /** \brief See RigMessages::warnings(). */
  const std::vector<std::string>& warnings() const { return messages_.warnings(); }

  /** \brief What of the views has no place in the file and was left out, a line each. */
  std::vector<std::string> leftOut() const;

  /** \brief One view. In the file they are in the order of these calls. \param time nanoseconds, of its header */
  void take(std::size_t camera, Nanoseconds time, std::shared_ptr<const LoadedView> images);
  /** \throws OutputError if the disk has not taken what was written; then nothing more is */
  void check() const;
  /** \brief Waits for what was taken, and ends the file. \throws as check() */
  void finish();

  /** \brief Size of the file, after finish(). */
  std::uint64_t bytes() const { return messages_.bytes(); }
  /** \brief Views that are in the file. */
  std::uint64_t written() const;
  /** \brief Views that came faster than they could be compressed and written. */
  std::uint64_t lost() const;

 private:
  struct Job {
    std::uint64_t number{0};
    std::size_t camera{0};
    Nanoseconds time{0};
    std::shared_ptr<const LoadedView> images;
  };

  void compress();
  void write();
  void abandon();
  static std::size_t bytesOf(const LoadedView& images);

  const Options options_;
  RigMessages messages_;  // encode() by those that compress; else the one that writes
  mutable std::mutex mutex_;
  std::condition_variable taken_, compressed_, written_to_disk_;
  // The mutex guards the following members.
  std::deque<Job> jobs_;
  struct Ready {
    std::vector<RigMessages::Encoded> messages;
    std::size_t bytes{0};  ///< of the images
  };
  std::map<std::uint64_t, Ready> ready_;
  std::uint64_t next_number_{0}, next_written_{0};
  std::uint64_t lost_{0};
  bool confidence_{false};  ///< a view had some
  std::size_t waiting_{0};  ///< bytes
  bool ending_{false};      ///< after what is there
  bool abandoned_{false};   ///< at once
  std::exception_ptr error_;
  std::vector<std::thread> compressing_;
  std::thread writing_;
};

}  // namespace fuse_flow::io
