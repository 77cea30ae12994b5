#include "../seeds.h"

#include <random>

namespace fuse_flow_fuzz {

void addStructuredSeeds(Seeds& seeds) {
  std::mt19937 random(1);
  for (const char* target : {"synchronizer", "same_devices", "call_sequence"})
    for (const std::size_t size : {40, 200, 600}) {
      std::string input;
      while (input.size() < size) input += static_cast<char>(random());
      seeds[target].push_back(input);
      input[0] = static_cast<char>(input[0] ^ 1);  // the other half of the synchroniser's
      seeds[target].push_back(input);
    }
}

}  // namespace fuse_flow_fuzz
