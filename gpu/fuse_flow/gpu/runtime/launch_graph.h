#pragma once

#include <fuse_flow/gpu/runtime/execution.h>

#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief Launches that are the same frame after frame, replayed as one CUDA graph: a driver call in place of some dozens.
 *
 *  What is launched is first written down, kernels with all their arguments; that costs a microsecond. If the note reads as
 *  that of the frame before, the graph captured then is launched, so nothing can change unnoticed: a buffer that has grown, an
 *  image of another size, a parameter. Memory that arguments point to may change. */
class LaunchGraph {
 public:
  LaunchGraph() = default;
  LaunchGraph(const LaunchGraph&) = delete;
  ~LaunchGraph() {
#if FUSE_FLOW_CUDA
    release();
#endif
  }

  /** \brief \param launches launches on \p run and nothing else but grow buffers; may be called twice. Not on the default stream,
   *  which cannot be captured: there it is called as it is. */
  template <typename Launches>
  void operator()(Execution& run, const Launches& launches) {
#if FUSE_FLOW_CUDA
    if (run.stream == nullptr) {
      launches();
      return;
    }
    writeDown(run, launches);
    if (graph_ != nullptr && note_ == captured_) {
      check(cudaGraphLaunch(graph_, run.stream), "cudaGraphLaunch");
      ++replays_;
      return;
    }
    if (note_ == last_) {
      capture(run, launches);
      check(cudaGraphLaunch(graph_, run.stream), "cudaGraphLaunch");
    } else {
      launches();  // captured when it comes again: frames whose sizes keep changing would capture for nothing
    }
    last_.swap(note_);
#else
    (void)run;
    launches();
#endif
  }

  /** \brief How often a captured graph was launched again. */
  std::size_t replays() const { return replays_; }

 private:
#if FUSE_FLOW_CUDA
  template <typename Launches>
  void writeDown(Execution& run, const Launches& launches) {
    struct Note {
      Execution& run;
      ~Note() { run.note(nullptr); }
    } const note{run};
    run.note(&note_);
    launches();
  }

  template <typename Launches>
  void capture(Execution& run, const Launches& launches) {
    release();
    check(cudaStreamBeginCapture(run.stream, cudaStreamCaptureModeThreadLocal), "cudaStreamBeginCapture");
    cudaGraph_t graph = nullptr;
    try {
      launches();
    } catch (...) {
      (void)cudaStreamEndCapture(run.stream, &graph);
      if (graph) (void)cudaGraphDestroy(graph);
      throw;
    }
    check(cudaStreamEndCapture(run.stream, &graph), "cudaStreamEndCapture");
    const cudaError_t error = cudaGraphInstantiate(&graph_, graph, 0);
    (void)cudaGraphDestroy(graph);
    check(error, "cudaGraphInstantiate");
    captured_ = note_;
  }

  void release() {
    if (graph_ != nullptr) (void)cudaGraphExecDestroy(graph_);
    graph_ = nullptr;
  }

  cudaGraphExec_t graph_{nullptr};
  std::vector<char> note_, last_, captured_;
#endif
  std::size_t replays_{0};
};

}  // namespace gpu
}  // namespace fuse_flow
