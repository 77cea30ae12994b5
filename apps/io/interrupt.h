#pragma once

#include <csignal>

namespace fuse_flow::io {

inline volatile std::sig_atomic_t interrupt_requested = 0;

/** \brief Ctrl-C finishes the frame at hand; a second one ends the program at once. */
inline void catchInterrupts() {
  std::signal(SIGINT, [](int) {
    interrupt_requested = 1;
    std::signal(SIGINT, SIG_DFL);
  });
}

}  // namespace fuse_flow::io
