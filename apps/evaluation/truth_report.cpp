#include "evaluation/truth_report.h"

#include <cmath>
#include <iomanip>
#include <sstream>
#include <utility>

namespace fuse_flow::simulation {
namespace {

using Member = double TruthQuality::*;

constexpr std::pair<const char*, Member> kFigures[] = {
    {"accuracy_mean_mm", &TruthQuality::accuracy_mean},    {"accuracy_median_mm", &TruthQuality::accuracy_median},
    {"accuracy_p95_mm", &TruthQuality::accuracy_p95},      {"precision_5mm", &TruthQuality::precision_5},
    {"precision_10mm", &TruthQuality::precision_10},       {"completeness_5mm", &TruthQuality::completeness_5},
    {"completeness_10mm", &TruthQuality::completeness_10}, {"f_score_5mm", &TruthQuality::f_score_5},
    {"f_score_10mm", &TruthQuality::f_score_10},           {"ghosting", &TruthQuality::ghosting},
    {"normal_error_deg", &TruthQuality::normal_error},     {"color_error", &TruthQuality::color_error}};

/** \brief A column of the table: what is shown is the figure times scale. */
struct Column {
  const char* title;
  Member figure;
  double scale;
  int decimals;
};

constexpr Column kColumns[] = {
    {"mean [mm]", &TruthQuality::accuracy_mean, 1, 2},     {"median [mm]", &TruthQuality::accuracy_median, 1, 2},
    {"p95 [mm]", &TruthQuality::accuracy_p95, 1, 1},       {"compl. 5 mm [%]", &TruthQuality::completeness_5, 100, 1},
    {"10 mm [%]", &TruthQuality::completeness_10, 100, 1}, {"F 5 mm", &TruthQuality::f_score_5, 1, 3},
    {"F 10 mm", &TruthQuality::f_score_10, 1, 3},          {"ghosting [%]", &TruthQuality::ghosting, 100, 2},
    {"normals [deg]", &TruthQuality::normal_error, 1, 1},  {"colour", &TruthQuality::color_error, 1, 1}};

constexpr const char* kFlicker = "flicker [mm]";

struct PartColumn {
  const char* title;
  const char* name;
  double (PartQuality::*figure)() const;
  double scale;
  int decimals;
};

constexpr PartColumn kPartColumns[] = {{"mean [mm]", "accuracy_mean_mm", &PartQuality::accuracyMean, 1, 2},
                                       {"signed [mm]", "signed_mean_mm", &PartQuality::signedMean, 1, 2},
                                       {"over 30 mm [%]", "ghosting", &PartQuality::ghosting, 100, 2},
                                       {"compl. 10 mm [%]", "completeness_10mm", &PartQuality::completeness10, 100, 1},
                                       {"F 5 mm", "f_score_5mm", &PartQuality::fScore5, 1, 3}};

int widthOf(const char* title) { return static_cast<int>(std::string(title).size()) + 2; }

void print(std::ostream& out, double value, int decimals, int width) {
  if (std::isnan(value))
    out << std::setw(width) << '-';
  else
    out << std::setw(width) << std::fixed << std::setprecision(decimals) << value;
}

}  // namespace

TruthQuality meanOf(const std::vector<TruthQuality>& frames) {
  TruthQuality mean;
  if (frames.empty()) return mean;
  for (const auto& [name, figure] : kFigures) {
    double sum = 0, n = 0;
    for (const TruthQuality& frame : frames)
      if (!std::isnan(frame.*figure)) sum += frame.*figure, ++n;
    if (n > 0) mean.*figure = sum / n;
  }
  for (const TruthQuality& frame : frames) {
    mean.points += frame.points;
    mean.surface_samples += frame.surface_samples;
  }
  mean.points = (mean.points + frames.size() / 2) / frames.size();
  mean.surface_samples = (mean.surface_samples + frames.size() / 2) / frames.size();
  return mean;
}

nlohmann::json truthJson(const TruthQuality& quality) {
  nlohmann::json json = {{"points", quality.points}, {"surface_samples", quality.surface_samples}};
  for (const auto& [name, figure] : kFigures)
    json[name] = std::isnan(quality.*figure) ? nlohmann::json() : nlohmann::json(quality.*figure);
  return json;
}

std::string truthHeader(std::size_t name_width) {
  std::ostringstream out;
  out << std::left << std::setw(static_cast<int>(name_width)) << "cloud" << std::right << std::setw(10) << "points";
  for (const Column& column : kColumns) out << std::setw(widthOf(column.title)) << column.title;
  out << std::setw(widthOf(kFlicker)) << kFlicker;
  return out.str();
}

std::string truthRow(const std::string& name, std::size_t name_width, const TruthQuality& quality, double flicker) {
  std::ostringstream out;
  out << std::left << std::setw(static_cast<int>(name_width)) << name << std::right << std::setw(10) << quality.points;
  for (const Column& column : kColumns)
    print(out, column.scale * (quality.*column.figure), column.decimals, widthOf(column.title));
  print(out, flicker, 2, widthOf(kFlicker));
  return out.str();
}

nlohmann::json partsJson(const std::vector<PartQuality>& parts) {
  nlohmann::json json = nlohmann::json::object();
  for (const PartQuality& part : parts) {
    if (part.surfaceSamples() == 0) continue;
    nlohmann::json& of = json[part.name()] = {{"points", part.points()}, {"surface_samples", part.surfaceSamples()}};
    for (const PartColumn& column : kPartColumns) {
      const double value = (part.*column.figure)();
      of[column.name] = std::isnan(value) ? nlohmann::json() : nlohmann::json(value);
    }
    of["completeness_5mm"] = part.completeness5();
  }
  return json;
}

std::string partsTable(const std::vector<std::string>& clouds, std::size_t name_width,
                       const std::vector<std::vector<PartQuality>>& parts) {
  constexpr int part_width = 23, count_width = 10;
  std::ostringstream out;
  out << std::left << std::setw(part_width) << "part" << std::setw(static_cast<int>(name_width)) << "cloud"
      << std::right << std::setw(count_width) << "points" << std::setw(count_width) << "samples";
  for (const PartColumn& column : kPartColumns) out << std::setw(widthOf(column.title)) << column.title;
  out << '\n';
  for (std::size_t part = 0; !parts.empty() && part < parts[0].size(); ++part)
    for (std::size_t k = 0; k < clouds.size(); ++k) {
      const PartQuality& of = parts[k][part];
      if (of.surfaceSamples() == 0) continue;
      out << std::left << std::setw(part_width) << of.name() << std::setw(static_cast<int>(name_width)) << clouds[k]
          << std::right << std::setw(count_width) << of.points() << std::setw(count_width) << of.surfaceSamples();
      for (const PartColumn& column : kPartColumns)
        print(out, column.scale * (of.*column.figure)(), column.decimals, widthOf(column.title));
      out << '\n';
    }
  return out.str();
}

}  // namespace fuse_flow::simulation
