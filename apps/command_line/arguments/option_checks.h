#pragma once

#include <CLI/CLI.hpp>

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace fuse_flow::command_line {

// CLI11's own checks let NaN pass, and print the largest double where they mean "no limit".

/** \brief A check whose message says what was given and what must be; empty if accepts(text). */
CLI::Validator makeCheck(const std::string& expected, const std::function<bool(const std::string&)>& accepts);

CLI::Validator finiteNumber();
CLI::Validator positiveNumber();
CLI::Validator nonNegativeNumber();
CLI::Validator wholeNumber(int low, int high);
CLI::Validator positiveNumberUpTo(double high);
/** \brief A positive number of metres; who gives more means another unit. */
CLI::Validator lengthUpTo(double metres);
CLI::Validator numberFromTo(double low, double high);
CLI::Validator oneOf(const std::vector<std::string>& names);
/** \brief Or 1 or 0. */
CLI::Validator trueOrFalse();
/** \brief Any but an empty one, which would be the current folder, and the next option, where this one has no value. */
CLI::Validator path();
/** \brief More than any machine has cores. */
CLI::Validator threadCount();

/** \brief A message of the library in words of the command line: "fuse_flow::ConfidenceEstimation: threshold is 2, …" as "--tau is 2, …".
 *  \param option_of what the library calls a parameter, and its option; of noise.floor, noise_floor */
std::string withOptionNames(const std::string& message, const std::map<std::string, std::string>& option_of);

/** \brief Names of the options that were given, but for those of with_effect: to be said where the others have none. */
std::vector<std::string> givenBut(const CLI::App& app, const std::set<std::string>& with_effect);

/** \brief A list that CLI11 joined line by line, as a config file's is split at its commas: with commas again. */
std::string joinedList(std::string list);

}  // namespace fuse_flow::command_line
