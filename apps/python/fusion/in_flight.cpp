#include "in_flight.h"

#include <pcl/exceptions.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace fuse_flow::python {
namespace {

struct State {
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t count{0};
  std::vector<void (*)()> last;           ///< what is done before the interpreter ends
  std::optional<std::thread::id> ending;  ///< the thread that ends the interpreter, which may still fuse
};

// Never freed: threads may outlive the module's globals.
State& state() {
  static State& state = *new State;
  return state;
}

void waitForAll() {
  {
    const pybind11::gil_scoped_release release;
    std::unique_lock<std::mutex> lock(state().mutex);
    state().ending = std::this_thread::get_id();
    state().changed.wait(lock, [] { return state().count == 0; });
  }
  for (void (*work)() : state().last) work();
}

}  // namespace

void stayHere() {
  const pybind11::gil_scoped_release release;
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

NotAtTheEnd::NotAtTheEnd() {
  const std::lock_guard<std::mutex> lock(state().mutex);
  if (state().ending && *state().ending != std::this_thread::get_id()) throw InterpreterEnds();
  ++state().count;
}

NotAtTheEnd::~NotAtTheEnd() {
  const std::lock_guard<std::mutex> lock(state().mutex);
  --state().count;
  state().changed.notify_all();
}

void finishBeforeExit() { pybind11::module_::import("atexit").attr("register")(pybind11::cpp_function(waitForAll)); }

void beforeExit(void (*work)()) { state().last.push_back(work); }

Busy::Inside::Inside(Busy& busy, const char* what) : busy_(busy) {
  if (busy.busy_)
    throw pcl::PCLException(std::string(what) + " is in use by another thread: each thread needs an object of its own");
  busy.busy_ = true;
}

}  // namespace fuse_flow::python
