#pragma once

#include "stream/codec/placement.h"

#include <fuse_flow/stream/cloud_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow::stream {

/** \brief The points of a cloud in the order of their Morton codes; equal codes in the order of their other fields, so that the order in
 *  which they came does not matter. */
class SortedPoints {
 public:
  struct Entry {
    std::uint64_t code;
    std::uint32_t point;  ///< its number in the cloud
  };

  /** \throws std::length_error beyond 2³² points */
  void sort(const CloudView& cloud, double step, int threads);

  const std::vector<Entry>& entries() const { return entries_; }
  /** \brief Metres; a multiple of the step, so that a point has the same error in each frame. */
  const std::array<double, 3>& origin() const { return origin_; }
  std::size_t leftOut() const { return left_out_; }
  /** \brief Of these, those whose coordinates are finite. */
  std::size_t tooFar() const { return finite_ - entries_.size(); }

 private:
  void findOrigin(const CloudView& cloud, double step, int threads);

  std::vector<Entry> entries_, scratch_;
  std::array<double, 3> origin_{};
  Few<double, 3> first_{};  ///< the origin in steps
  std::size_t left_out_{0};
  std::size_t finite_{0};
  std::vector<std::size_t> counts_;  ///< of a block of points and a bucket
};

}  // namespace fuse_flow::stream
