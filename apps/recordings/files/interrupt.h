#pragma once

#include <csignal>
#include <string>

namespace fuse_flow::io {

/** \brief Set by the first signal after catchInterrupts(). */
extern volatile std::sig_atomic_t interrupt_requested;

/** \brief From here on the signals that end a program (Ctrl-C and Ctrl-\\, SIGTERM, SIGHUP, SIGPIPE, SIGXCPU) leave no half-written file. */
void endCleanlyOnSignals();

/** \brief From here on the first Ctrl-C, SIGTERM or SIGHUP asks to finish the frame at hand; a second one ends the program at once. */
void catchInterrupts();

/** \brief A file that a signal which ends the program removes, while this lives. One at a time: where threads write
 *  several, it is the first. */
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::string& path);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

 private:
  bool owns_;
};

}  // namespace fuse_flow::io
