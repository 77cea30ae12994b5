#pragma once

/** \file
 *  \brief What a fuzzer is here: a parser of this project, and the memory that it may take. With libFuzzer each is a program; without, all of them are in one
 *  GoogleTest binary, which replays the seeds and some mutations of them. */

#include <cstddef>
#include <cstdint>
#include <exception>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace fuse_flow_fuzz {

/** \brief A fault of the code under test: an exception that no caller expects, too much memory, or a wrong result. Under libFuzzer nothing catches it. */
struct Finding : std::logic_error {
  using std::logic_error::logic_error;
};

inline void require(bool holds, const std::string& what) {
  if (!holds) throw Finding(what);
}

/** \brief How much memory one input may take at a time, over what was taken before: `fixed` + `per_byte` · its size, bytes, and what allowMemory() adds. */
struct MemoryBound {
  std::size_t fixed;
  std::size_t per_byte;
};

struct Target {
  const char* name;
  MemoryBound bound;
  int test_runs;  ///< mutations in the tests
  void (*run)(std::string_view input);
};

/** \brief As GoogleTest prints it. */
inline std::ostream& operator<<(std::ostream& out, const Target& target) { return out << target.name; }

/** \brief Adds to the bound of the input that runs: for images, of which a few bytes may hold many pixels, once their size is known and checked. */
void allowMemory(std::size_t bytes);

/** \brief Runs one input. \throws Finding */
void runInput(const Target& target, std::string_view input);

/** \brief How often accepts() has returned true. */
inline long& acceptedInputs() {
  static long count = 0;
  return count;
}

/** \brief Runs what may refuse an input by an exception of these types; any other is a finding. \returns whether it was accepted */
template <typename... Refusals, typename Action>
bool accepts(const Action& action) {
  try {
    action();
    ++acceptedInputs();
    return true;
  } catch (const Finding&) {
    throw;
  } catch (const std::exception& error) {
    const bool refused = ((dynamic_cast<const Refusals*>(&error) != nullptr) || ...);
    if (!refused) throw Finding(std::string("an exception that nobody expects: ") + error.what());
    return false;
  }
}

/** \brief All that are linked into the program. */
std::vector<Target>& targets();

struct Registration {
  explicit Registration(const Target& target) { targets().push_back(target); }
};

}  // namespace fuse_flow_fuzz

#ifdef FUSE_FLOW_WITH_LIBFUZZER
#define FUSE_FLOW_FUZZ_ENTRY(NAME)                                                             \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);           \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {          \
    fuse_flow_fuzz::runInput(fuzz_target_##NAME, {reinterpret_cast<const char*>(data), size}); \
    return 0;                                                                                  \
  }
#else
#define FUSE_FLOW_FUZZ_ENTRY(NAME) \
  static const fuse_flow_fuzz::Registration fuzz_registration_##NAME(fuzz_target_##NAME);
#endif

/** \brief FUSE_FLOW_FUZZ_TARGET(png, 1 << 20, 8, 300) { … input … }: name, fixed and per_byte of the bound, test_runs. In the global namespace. */
#define FUSE_FLOW_FUZZ_TARGET(NAME, FIXED, PER_BYTE, TEST_RUNS)                                                 \
  static void fuzz_run_##NAME(std::string_view input);                                                          \
  static const fuse_flow_fuzz::Target fuzz_target_##NAME{#NAME, {FIXED, PER_BYTE}, TEST_RUNS, fuzz_run_##NAME}; \
  FUSE_FLOW_FUZZ_ENTRY(NAME)                                                                                    \
  static void fuzz_run_##NAME(std::string_view input)
