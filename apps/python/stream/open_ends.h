#pragma once

#include <set>

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

}  // namespace fuse_flow::python
