#pragma once

#include <cstring>
#include <type_traits>
#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief Appends the bytes of a value. The padding between its members is uninitialised. It becomes 0 if the compiler can find it: equal
 *  values then have equal bytes. */
template <typename Value>
void appendBytes(const Value& value, std::vector<char>& bytes) {
  alignas(Value) char copy[sizeof(Value)];
  std::memcpy(copy, static_cast<const void*>(&value), sizeof(Value));
#if defined(__has_builtin)
#if __has_builtin(__builtin_clear_padding)
  if constexpr (std::is_trivially_copyable_v<Value>) __builtin_clear_padding(reinterpret_cast<Value*>(copy));
#endif
#endif
  bytes.insert(bytes.end(), copy, copy + sizeof(Value));
}

}  // namespace gpu
}  // namespace fuse_flow
