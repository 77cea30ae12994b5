#pragma once

/** \file
 *  \brief Loops over pixels and points in the widest vectors of the processor that they run on, in programs compiled for any.
 *  What eight lanes at once compute is what four do: the bytes stay the same, since nothing is contracted. */

namespace fuse_flow {
namespace host {

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__AVX2__)

/** \brief A loop, and all that it calls, compiled for AVX2. */
template <typename Loop>
__attribute__((target("avx2"), flatten, noinline)) void runWide(const Loop& loop) {
  loop();
}

inline bool hasWideVectors() {
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}

/** \brief Calls loop(), in wide vectors where the processor has them. */
template <typename Loop>
void inWideVectors(const Loop& loop) {
  if (hasWideVectors()) {
    runWide(loop);
  } else {
    loop();
  }
}

#else

/** \brief Calls loop(). */
template <typename Loop>
void inWideVectors(const Loop& loop) {
  loop();
}

#endif

}  // namespace host
}  // namespace fuse_flow
