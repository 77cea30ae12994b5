#include "seeds.h"

#include <filesystem>
#include <fstream>
#include <iostream>

/** \brief fuse_flow_fuzz_seeds FOLDER: writes the seeds of each target into FOLDER/TARGET. */
int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: fuse_flow_fuzz_seeds FOLDER\n";
    return 2;
  }
  for (const auto& [name, inputs] : fuse_flow_fuzz::makeSeeds()) {
    const std::filesystem::path folder = std::filesystem::path(argv[1]) / name;
    std::filesystem::create_directories(folder);
    for (std::size_t k = 0; k < inputs.size(); ++k)
      std::ofstream(folder / ("seed_" + std::to_string(k)), std::ios::binary) << inputs[k];
  }
}
