#pragma once

#include <exception>

namespace fuse_flow {
namespace gpu {

/** \brief Does something where an exception ends the block that it stands in. \tparam Action does not throw */
template <typename Action>
class OnError {
 public:
  explicit OnError(const Action& action) : action_(action) {}
  ~OnError() {
    if (std::uncaught_exceptions() > before_) action_();
  }
  OnError(const OnError&) = delete;
  OnError& operator=(const OnError&) = delete;

 private:
  Action action_;
  const int before_{std::uncaught_exceptions()};
};

}  // namespace gpu
}  // namespace fuse_flow
