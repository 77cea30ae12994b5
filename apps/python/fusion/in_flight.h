#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <stdexcept>

namespace fuse_flow::python {

/** \brief Thrown in a thread that begins something while the interpreter ends: translated, it goes no further, see stayHere(). */
class InterpreterEnds : public std::runtime_error {
 public:
  InterpreterEnds() : std::runtime_error("fuse_flow: the interpreter is ending") {}
};

/** \brief Gives the lock away and never comes back, as a thread does that waits for the lock from Python 3.14 on. An exception would be printed,
 *  and older ones abort where a thread prints while they end. */
[[noreturn]] void stayHere();

/** \brief The interpreter does not end before all of these are gone: a thread that waits for its lock then is torn down, in the middle of
 *  C++ if it is there. To be made and destroyed with the lock, which may be given away in between. */
class NotAtTheEnd {
 public:
  /** \throws InterpreterEnds */
  NotAtTheEnd();
  ~NotAtTheEnd();
  NotAtTheEnd(const NotAtTheEnd&) = delete;
  NotAtTheEnd& operator=(const NotAtTheEnd&) = delete;
};

/** \brief Work without the interpreter's lock (GIL), so that other threads of Python run meanwhile. The interpreter does not end before all
 *  such work is done. */
class InFlight {
 public:
  /** \brief Needs the lock, and gives it away. \throws InterpreterEnds */
  InFlight() { release_.emplace(); }
  InFlight(const InFlight&) = delete;
  InFlight& operator=(const InFlight&) = delete;

 private:
  NotAtTheEnd not_at_the_end_;  // until the lock is back
  std::optional<pybind11::gil_scoped_release> release_;
};

/** \brief Has the interpreter wait for what is in flight, as it ends. */
void finishBeforeExit();
/** \brief Has it then do this, with its lock, while nothing is in flight any more. */
void beforeExit(void (*work)());

/** \brief Whether a thread uses an object: objects are for one thread at a time. Read and written with the interpreter's lock. */
class Busy {
 public:
  /** \brief For as long as an object is used. \throws pcl::PCLException if another thread uses it */
  class Inside {
   public:
    Inside(Busy& busy, const char* what);
    ~Inside() { busy_.busy_ = false; }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

   private:
    const NotAtTheEnd not_at_the_end_;  // what is made of the results is Python's, too
    Busy& busy_;
  };

 private:
  bool busy_{false};
};

}  // namespace fuse_flow::python
