#pragma once

#include <fuse_flow/gpu/runtime/execution.h>

namespace fuse_flow {
namespace gpu {

/** \brief A stream beside that of a frame, for what may take its time while the frame goes on. */
class SideStream {
 public:
  SideStream() { run.stream = stream_.get(); }

  Execution run;

  /** \brief What comes onto it waits for what is on the frame's stream by now. */
  void leave(Stream frame) { order_.put(frame, run.stream); }
  /** \brief What comes onto the frame's stream waits for what is on it by now. */
  void join(Stream frame) { order_.put(run.stream, frame); }

 private:
  OwnStream stream_;
  StreamOrder order_;
};

}  // namespace gpu
}  // namespace fuse_flow
