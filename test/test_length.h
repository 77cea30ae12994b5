#pragma once

/** \file
 *  \brief How much of the same a test does. compute-sanitizer makes a launch hundreds of times slower: if the environment variable
 *  FUSE_FLOW_TEST_SHORT is set, to any value, the long tests do less, and the whole binary can run under it. So they do under the
 *  compiler's sanitizers, which see the same code. */

#include "sanitized.h"

#include <cstddef>
#include <cstdlib>

inline bool shortTests() {
#if defined(FUSE_FLOW_TEST_SANITIZED)
  return true;
#else
  return std::getenv("FUSE_FLOW_TEST_SHORT") != nullptr;
#endif
}

/** \brief How many times over a test does what it does. */
inline int timesOver(int usually, int where_short) { return shortTests() ? where_short : usually; }

/** \brief Whether frames meet memory that has grown before there are several in flight: as the environment variable
 *  FUSE_FLOW_TEST_WARM says, for compute-sanitizer's racecheck. That needs the driver's lock to empty its records, and a thread
 *  that frees memory holds the lock until all kernels, which wait for room in the records, have ended. */
inline bool warmFirst() { return std::getenv("FUSE_FLOW_TEST_WARM") != nullptr; }

/** \brief How many points there must be for a comparison of them to say something. */
inline std::size_t enough(std::size_t usually) { return shortTests() ? usually / 50 : usually; }
