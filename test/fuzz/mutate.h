#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace fuse_flow_fuzz {

/** \brief Changes inputs at random, the same way on every machine. */
class Mutator {
 public:
  explicit Mutator(std::uint32_t seed) : engine_(seed) {}

  /** \brief One to eight changes of one of these: bits, numbers that parsers stumble over, bytes more or less, pieces of others. */
  std::string mutant(const std::vector<std::string>& seeds);

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : engine_() % n; }
  void change(std::string& input, const std::vector<std::string>& seeds);

  std::mt19937 engine_;
};

}  // namespace fuse_flow_fuzz
