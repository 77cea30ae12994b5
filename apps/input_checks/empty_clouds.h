#pragma once

#include "methods/method.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::io {

/** \brief Counts frames that gave no point, and finds out why the first one did. */
class EmptyClouds {
 public:
  /** \param method as makeMethod() names it */
  EmptyClouds(std::string method, MethodOptions options) : method_(std::move(method)), options_(std::move(options)) {}

  /** \brief After a frame was fused. For the first empty cloud it is fused again, several times.
   *  \param whole whether \p frame has the images of all cameras; else no reason is looked for */
  void look(std::size_t number, const RigFrame& frame, std::size_t points, bool whole = true);

  /** \brief One line, if any frame was empty. */
  std::vector<std::string> complaints() const;

 private:
  std::string method_;
  MethodOptions options_;
  std::size_t frames_{0}, empty_{0};
  std::string first_;  ///< of the first empty one: its number, and why
};

}  // namespace fuse_flow::io
