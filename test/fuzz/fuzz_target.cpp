#include "fuzz_target.h"

#include "peak_memory.h"

#include <new>

namespace fuse_flow_fuzz {
namespace {

std::size_t allowed = 0;

}  // namespace

std::vector<Target>& targets() {
  static std::vector<Target> all;
  return all;
}

void allowMemory(std::size_t bytes) { allowed += bytes; }

void runInput(const Target& target, std::string_view input) {
  allowed = target.bound.fixed + target.bound.per_byte * input.size();
  const PeakMemory memory;
  try {
    target.run(input);
  } catch (const Finding&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Finding("more memory was asked for than there is");
  } catch (const std::exception& error) {
    throw Finding(std::string("an exception that nobody expects: ") + error.what());
  }
  if (memory.peak() > allowed)
    throw Finding("took " + std::to_string(memory.peak()) + " bytes for an input of " + std::to_string(input.size()) +
                  ", may take " + std::to_string(allowed));
}

}  // namespace fuse_flow_fuzz
