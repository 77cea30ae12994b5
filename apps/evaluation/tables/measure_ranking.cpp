#include "evaluation/tables/measure_ranking.h"

#include "evaluation/tables/markdown.h"
#include "evaluation/tables/rank_correlation.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::tables {
namespace {

/** \brief A figure of a result; bigger is better where rises is 1, smaller where it is −1. */
struct Figure {
  const char* name;
  double rises;
  double scale;
  int decimals;
  double (*of)(const Result&);
};

const Figure kMeasures[] = {
    {"noise mm", -1, 1e3, 2, [](const Result& r) { return r.surface.noise(); }},
    {"double surfaces %", -1, 100, 2, [](const Result& r) { return r.surface.doubleSurfaces(); }},
    {"violations off silhouettes %", -1, 100, 2, [](const Result& r) { return r.surface.violationShare(); }},
    {"coverage within noise %", 1, 100, 1, [](const Result& r) { return r.surface.coverage(); }},
    {"flicker mm", -1, 1e3, 2, [](const Result& r) { return r.surface.flicker.mean(); }},
    {"E_MC mm", -1, 1, 2, [](const Result& r) { return r.multi_camera_error; }},
    {"violations at the pixel %", -1, 100, 2, [](const Result& r) { return r.violations; }},
    {"coverage in 15 mm %", 1, 100, 1, [](const Result& r) { return r.coverage; }}};

const Figure kTruth[] = {{"mean distance", -1, 1, 2, [](const Result& r) { return r.truth.accuracy_mean; }},
                         {"ghosting", -1, 100, 2, [](const Result& r) { return r.truth.ghosting; }},
                         {"completeness at 10 mm", 1, 100, 1, [](const Result& r) { return r.truth.completeness_10; }},
                         {"F at 5 mm", 1, 1, 3, [](const Result& r) { return r.truth.f_score_5; }},
                         {"true flicker", -1, 1, 2, [](const Result& r) { return r.flicker; }}};

std::vector<double> valuesOf(const Figure& figure, const std::vector<Result>& results) {
  std::vector<double> values;
  for (const Result& result : results) values.push_back(figure.rises * figure.of(result));
  return values;
}

std::string meanAndLeast(const std::vector<double>& values) {
  double sum = 0, least = 1;
  for (const double value : values) {
    sum += value;
    least = std::min(least, value);
  }
  if (values.empty()) return "–";
  return number(sum / static_cast<double>(values.size()), 2) + " (" + number(least, 2) + ")";
}

std::string sizeOf(double scale) {
  return scale < 1 ? "with images of " + number(scale, 2) + " of the size there, each way, " : "";
}

}  // namespace

void MeasureRanking::add(const Setup& setup, const std::vector<Contender>& contenders,
                         const std::vector<Result>& results) {
  Part part{setup, {}, results};
  for (const Contender& contender : contenders) part.names.push_back(contender.name);
  parts_.push_back(std::move(part));
}

std::string MeasureRanking::text(int threads) const {
  std::string text =
      "# What can be measured without the truth\n\nHow far the figures that need no truth rank methods as the truth "
      "does. The figures: [reference/formats.md](../reference/formats.md#figures-without-the-truth). How to use them: "
      "[guide/judge.md](../guide/judge.md).\n\nWritten by `./build.sh tables`, or by `fuse_flow_tables --measures "
      "FILE` alone, on " +
      std::to_string(threads) + " threads: rigs and methods of [results.md](../results.md), " +
      sizeOf(parts_.empty() ? 1 : parts_[0].setup.scale) +
      "measured by the cloud and the depth views alone "
      "(`fuse_flow/quality/surface_quality.h` defines the figures; `fuse_flow_evaluate`, `fuse_flow_fuse --report` and "
      "the viewer show them).\n\n## How far they rank methods as the truth does\n\nSpearman's rank correlation between "
      "a "
      "measure and a figure against the true surface, over the methods on one rig: the mean over the rigs, and in "
      "brackets that of the worst one. 1: the order is the truth's, 0: it has nothing to do with it, −1: it is the "
      "reverse. Each is turned so that better goes with better. Flicker is known where there are several frames.\n\n";
  std::vector<std::string> header = {""};
  for (const Figure& truth : kTruth) header.emplace_back(truth.name);
  MarkdownTable ranks(header);
  for (const Figure& measure : kMeasures) {
    std::vector<std::string> row = {measure.name};
    for (const Figure& truth : kTruth) {
      std::vector<double> correlations;
      for (const Part& part : parts_) {
        const double r = rankCorrelation(valuesOf(measure, part.results), valuesOf(truth, part.results));
        if (!std::isnan(r)) correlations.push_back(r);
      }
      row.push_back(meanAndLeast(correlations));
    }
    ranks.row(row);
  }
  text += ranks.text() + "## The figures\n\n";
  for (const Part& part : parts_) {
    text += "### " + part.setup.name() +
            (part.setup.frames > 1 ? ", " + std::to_string(part.setup.frames) + " frames" : "") + "\n\n";
    header = {"", "true mean mm", "ghosting %", "completeness %"};
    for (const Figure& measure : kMeasures) header.emplace_back(measure.name);
    MarkdownTable table(header);
    for (std::size_t k = 0; k < part.results.size(); ++k) {
      const Result& r = part.results[k];
      std::vector<std::string> row = {part.names[k], number(r.truth.accuracy_mean, 2),
                                      number(100 * r.truth.ghosting, 2), number(100 * r.truth.completeness_10, 1)};
      for (const Figure& measure : kMeasures) row.push_back(number(measure.scale * measure.of(r), measure.decimals));
      table.row(row);
    }
    text += table.text();
  }
  return text;
}

}  // namespace fuse_flow::tables
