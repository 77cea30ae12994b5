#pragma once

#include <cstddef>

namespace fuse_flow_fuzz {

/** \brief The most memory that malloc() and operator new have given out at a time since its construction, on all threads, over what they had before. One
 *  at a time. */
class PeakMemory {
 public:
  PeakMemory();
  ~PeakMemory();
  PeakMemory(const PeakMemory&) = delete;
  PeakMemory& operator=(const PeakMemory&) = delete;

  /** \brief Bytes; 0 where nothing counts them. */
  std::size_t peak() const;
};

}  // namespace fuse_flow_fuzz
