#pragma once

#include <fuse_flow/recordings/recording.h>

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

namespace fuse_flow::io {

/** \brief Reads the frames of a recording on threads of its own, while the caller works on those before; several frames at a time, where
 *  Recording::readsConcurrently(). What comes is the same, and in the same order, as with Recording::read(); so is what is thrown. Nobody else may
 *  use the recording meanwhile, but for what does not change. */
class ReadAhead {
 public:
  /** \param recording must stay  \param frames to read, in this order  \param ahead how many are read, or being read, that nobody has asked for;
   *  ≥ 1 */
  ReadAhead(Recording& recording, std::vector<std::size_t> frames, std::size_t ahead);
  /** \brief Ends after the frames at hand. */
  ~ReadAhead();
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;

  /** \brief The next frame. Must be called no more often than there are frames, and not again after it has thrown.
   *  \param frame gives its memory for one of the frames to come \throws what reading it threw */
  void next(LoadedFrame& frame);

 private:
  struct Read {
    LoadedFrame frame;
    std::exception_ptr error;
  };

  void run();
  void end();

  Recording& recording_;
  const std::vector<std::size_t> frames_;
  const std::size_t ahead_;
  std::mutex mutex_;
  std::condition_variable changed_;
  // The mutex guards the following members.
  std::map<std::size_t, Read> ready_;  // by their place among the frames
  std::size_t begun_{0};               // how many are read, or being read
  std::size_t taken_{0};
  std::vector<LoadedFrame> spare_;  // memory
  bool ending_{false};
  std::vector<std::thread> threads_;
};

}  // namespace fuse_flow::io
