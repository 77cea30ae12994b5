#pragma once

#include "../fusion/in_flight.h"

#include <pybind11/pybind11.h>

#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

namespace fuse_flow::python {

/** \brief What has threads of its own, and is closed before the interpreter ends. With the interpreter's lock. */
class OpenEnd {
 public:
  OpenEnd() { all().insert(this); }
  virtual ~OpenEnd() { all().erase(this); }
  OpenEnd(const OpenEnd&) = delete;
  OpenEnd& operator=(const OpenEnd&) = delete;

  /** \brief Also if another thread is about to use it, as the interpreter ends. */
  virtual void closeNow() = 0;

  static void closeAll() {
    const std::set<OpenEnd*> open = all();
    for (OpenEnd* end : open)
      if (all().count(end) == 1) end->closeNow();
  }

 private:
  /** \brief Never freed, as objects may outlive the module's globals. */
  static std::set<OpenEnd*>& all() {
    static auto& all = *new std::set<OpenEnd*>;
    return all;
  }
};

/** \brief A T of the library, until it is closed. */
template <typename T>
class OpenUntilClosed : public OpenEnd {
 public:
  /** \param name of the class in Python, for messages */
  OpenUntilClosed(std::unique_ptr<T> end, const char* name) : end_(std::move(end)), name_(name) {}
  ~OpenUntilClosed() override { closeNow(); }

  void close() {
    const Busy::Inside inside(busy_, name_);
    closeNow();
  }
  void closeNow() override {
    std::unique_ptr<T> closed = std::move(end_);  // with the lock: another thread may ask for it
    const pybind11::gil_scoped_release release;   // it says good-bye, and its threads end
    closed.reset();
  }
  T& get() const {
    if (!end_) {
      const NotAtTheEnd before_it_is_thrown;
      throw std::runtime_error(std::string(name_) + " is closed");
    }
    return *end_;
  }

 protected:
  const char* name() const { return name_; }
  Busy busy_;

 private:
  std::unique_ptr<T> end_;
  const char* name_;
};

/** \brief close(), and with blocks. */
template <typename Class>
void bindClosing(Class& type, const char* sentence) {
  using T = typename Class::type;
  type.def(
          "close", [](T& self) { self.close(); }, sentence)
      .def("__enter__", [](const pybind11::object& self) { return self; })
      .def("__exit__", [](T& self, const pybind11::args&) { self.close(); });
}

}  // namespace fuse_flow::python
