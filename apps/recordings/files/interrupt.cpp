#include "recordings/files/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <climits>
#include <cstring>

namespace fuse_flow::io {

volatile std::sig_atomic_t interrupt_requested = 0;

namespace {

// What a signal handler may look at: no memory that is allocated, no locks.
volatile std::sig_atomic_t finishes_frame = 0;
std::atomic<bool> taken{false}, unfinished{false}, signalled{false};
char unfinished_path[PATH_MAX];
static_assert(std::atomic<bool>::is_always_lock_free);

/** \brief The program ends, and leaves nothing half-written. */
void onFatalSignal(int signal) {
  if (unfinished) unlink(unfinished_path);
  std::signal(signal, SIG_DFL);
  raise(signal);
}

void onSignal(int signal) {
  if (finishes_frame && !signalled.exchange(true)) {  // of two signals at once, on two threads, one is the second
    interrupt_requested = 1;
    return;
  }
  onFatalSignal(signal);
}

void handle(int signal, void (*handler)(int)) {
  if (std::signal(signal, handler) == SIG_IGN) std::signal(signal, SIG_IGN);  // as nohup has it
}

}  // namespace

void endCleanlyOnSignals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) handle(signal, onSignal);
  for (const int signal : {SIGQUIT, SIGPIPE, SIGXCPU}) handle(signal, onFatalSignal);
}

void catchInterrupts() {
  finishes_frame = 1;
  endCleanlyOnSignals();
}

UnfinishedFile::UnfinishedFile(const std::string& path) : owns_(path.size() < PATH_MAX && !taken.exchange(true)) {
  if (!owns_) return;
  std::memcpy(unfinished_path, path.c_str(), path.size() + 1);
  unfinished = true;
}

UnfinishedFile::~UnfinishedFile() {
  if (!owns_) return;
  unfinished = false;
  taken = false;
}

}  // namespace fuse_flow::io
