#pragma once

#include "evaluation/tables/comparison.h"

#include <string>
#include <vector>

namespace fuse_flow::tables {

/** \brief What can be measured of clouds without the truth, and how far it ranks them as the truth does. */
class MeasureRanking {
 public:
  void add(const Setup& setup, const std::vector<Contender>& contenders, const std::vector<Result>& results);
  /** \brief A page in Markdown. */
  std::string text(int threads) const;

 private:
  struct Part {
    Setup setup;
    std::vector<std::string> names;
    std::vector<Result> results;
  };
  std::vector<Part> parts_;
};

}  // namespace fuse_flow::tables
