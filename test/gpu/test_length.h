#pragma once

/** \file
 *  \brief How much of the same a test does. compute-sanitizer makes a launch hundreds of times slower: with the environment
 *  variable FUSE_FLOW_TEST_SHORT set, whatever to, the long tests do less and the whole binary can run under it. */

#include <cstdlib>

inline bool shortTests() { return std::getenv("FUSE_FLOW_TEST_SHORT") != nullptr; }

/** \brief How many times over a test does what it does. */
inline int timesOver(int usually, int where_short) { return shortTests() ? where_short : usually; }
