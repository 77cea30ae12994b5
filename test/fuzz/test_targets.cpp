#include "fuzz_target.h"
#include "mutate.h"
#include "seeds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iomanip>
#include <sstream>

namespace {

using namespace fuse_flow_fuzz;

/** \brief As a test of its own can have it. */
std::string inHex(const std::string& bytes) {
  std::ostringstream text;
  for (const char byte : bytes)
    text << std::hex << std::setw(2) << std::setfill('0') << int{static_cast<std::uint8_t>(byte)};
  return text.str();
}

/** \brief Whether an input is read or refused, and that in its memory. */
testing::AssertionResult isTaken(const Target& target, const std::string& input) {
  try {
    runInput(target, input);
  } catch (const Finding& finding) {
    return testing::AssertionFailure() << finding.what() << "; the input in hex: " << inHex(input);
  }
  return testing::AssertionSuccess();
}

const Seeds& seeds() {
  static const Seeds all = makeSeeds();
  return all;
}

std::vector<Target> sortedTargets() {
  std::vector<Target> all = targets();
  std::sort(all.begin(), all.end(), [](const Target& a, const Target& b) { return std::string(a.name) < b.name; });
  return all;
}

class Fuzz : public testing::TestWithParam<Target> {};

TEST_P(Fuzz, SeedsAndTheirMutantsAreReadOrRefused) {
  const Target& target = GetParam();
  const auto found = seeds().find(target.name);
  ASSERT_NE(found, seeds().end()) << "no seeds for " << target.name;
  EXPECT_TRUE(isTaken(target, ""));
  const long before = acceptedInputs();
  for (const std::string& seed : found->second) ASSERT_TRUE(isTaken(target, seed));
  // Not the first one: where a seed is what random choices are made of, it changes with them what it stands for.
  EXPECT_GT(acceptedInputs(), before) << "all seeds are refused";
  Mutator mutator(1);
  for (int run = 0; run < target.test_runs; ++run)
    ASSERT_TRUE(isTaken(target, mutator.mutant(found->second))) << "mutant " << run;
}

std::string nameOf(const testing::TestParamInfo<Target>& tested) { return tested.param.name; }

// Targets register themselves as the program starts, in no certain order; GoogleTest asks for them later.
INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, testing::ValuesIn(sortedTargets()), nameOf);

}  // namespace
