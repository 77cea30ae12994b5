#pragma once

#include <string>
#include <vector>

namespace instruction_sets {

/** \brief Those that Embree can be limited to, by its names. */
inline std::vector<std::string> all() { return {"sse2", "sse4.2", "avx", "avx2", "avx512"}; }

/** \brief Whether this processor has one of them; others than x86 have none. */
inline bool here([[maybe_unused]] const std::string& name) {
#if defined(__x86_64__) || defined(__i386__)
  if (name == "sse2") return __builtin_cpu_supports("sse2");
  if (name == "sse4.2") return __builtin_cpu_supports("sse4.2");
  if (name == "avx") return __builtin_cpu_supports("avx");
  if (name == "avx2") return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (name == "avx512")
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
#endif
  return false;
}

}  // namespace instruction_sets
