#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace fuse_flow {
namespace gpu {

/** \brief memcpy() that writes past the caches. An ordinary store first fetches the line that it is going to replace: a third of
 *  the traffic of a copy that is too large for the caches, and that limits frames a second from pageable images and into clouds. */
inline void streamCopy(void* to, const void* from, std::size_t bytes) {
#if defined(__SSE2__)
  constexpr std::size_t line = 64;
  auto* out = static_cast<char*>(to);
  const auto* in = static_cast<const char*>(from);
  std::size_t head = (line - reinterpret_cast<std::uintptr_t>(out) % line) % line;
  if (head > bytes) head = bytes;
  std::memcpy(out, in, head);
  out += head, in += head, bytes -= head;
  for (; bytes >= line; out += line, in += line, bytes -= line) {
    __m128i words[4];
    std::memcpy(words, in, line);
    for (int k = 0; k < 4; ++k) _mm_stream_si128(reinterpret_cast<__m128i*>(out) + k, words[k]);
  }
  std::memcpy(out, in, bytes);
  _mm_sfence();  // before another thread learns that the copy is done
#else
  std::memcpy(to, from, bytes);
#endif
}

}  // namespace gpu
}  // namespace fuse_flow
