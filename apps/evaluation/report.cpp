#include "evaluation/report.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace fuse_flow::io {
namespace {

/** \brief JSON has no NaN: what could not be measured is null. */
nlohmann::json number(double value) { return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr); }

/** \brief Between two values in proportion, so that the median of an even number lies in the middle of its middle two.
 */
double percentile(std::vector<double> values, double p) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const double place = p * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

double peakMemoryMebibytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

struct Stage {
  const char* name;
  double FrameStatistics::*milliseconds;
};
constexpr Stage kStages[] = {
    {"preprocess", &FrameStatistics::preprocess_ms}, {"generate", &FrameStatistics::generate_ms},
    {"merge", &FrameStatistics::merge_ms},           {"fuse", &FrameStatistics::fuse_ms},
    {"output", &FrameStatistics::output_ms},         {"total", &FrameStatistics::total_ms}};

constexpr const char* kSurfaceFigures[] = {"surface_noise_mm", "double_surfaces",
                                           "free_space_violations_off_silhouettes", "coverage_within_noise",
                                           "flicker_mm"};
constexpr const char* kQualityFigures[] = {"e_mc_mm", "e_mc_multi_view_mm", "free_space_violations", "coverage"};

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), pattern, value);
  return text;
}

std::string padded(std::string name, std::size_t width) {
  name.resize(std::max(width, name.size()), ' ');
  return name;
}

/** \brief A figure as far right as its column goes. */
std::string column(const nlohmann::json& figures, const char* key, double scale, std::size_t width) {
  const std::string text = figures[key].is_number() ? format("%.2f", scale * figures[key].get<double>()) : "-";
  return std::string(width - std::min(width, text.size()), ' ') + text;
}

}  // namespace

std::string jsonText(const nlohmann::json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

nlohmann::json qualityJson(const ReprojectionQuality& q) {
  return {{"points", q.points},
          {"multi_view_points", q.multi_view_points},
          {"e_mc_mm", number(1e3 * q.error)},
          {"e_mc_multi_view_mm", number(1e3 * q.multi_view_error)},
          {"free_space_violations", q.points ? nlohmann::json(q.violationShare()) : nlohmann::json(nullptr)},
          {"coverage", q.pixels ? nlohmann::json(q.coverage()) : nlohmann::json(nullptr)}};
}

nlohmann::json surfaceJson(const SurfaceQuality& q) {
  return {{"surface_noise_mm", number(1e3 * q.noise())},
          {"double_surfaces", number(q.doubleSurfaces())},
          {"free_space_violations_off_silhouettes", number(q.violationShare())},
          {"coverage_within_noise", number(q.coverage())},
          {"flicker_mm", number(1e3 * q.flicker.mean())}};
}

// In the order in which they can be trusted to rank methods as the truth does: doc/notes/quality_measures.md.
std::string surfaceHeader(std::size_t name_width) {
  return padded("cloud", name_width) +
         "    points  violations off silhouettes [%]  flicker [mm]  double surfaces [%]  noise [mm]  "
         "coverage within noise [%]";
}

std::string surfaceRow(const std::string& name, std::size_t name_width, const SurfaceQuality& q) {
  const nlohmann::json figures = surfaceJson(q);
  return padded(name, name_width) + format("%10.0f", static_cast<double>(q.points)) +
         column(figures, "free_space_violations_off_silhouettes", 100, 32) + column(figures, "flicker_mm", 1, 14) +
         column(figures, "double_surfaces", 100, 21) + column(figures, "surface_noise_mm", 1, 12) +
         column(figures, "coverage_within_noise", 100, 27);
}

std::string qualityHeader(std::size_t name_width) {
  return padded("cloud", name_width) + "    points   E_MC [mm]  E_MC, 2+ views [mm]  violations [%]  coverage [%]";
}

std::string qualityRow(const std::string& name, std::size_t name_width, const ReprojectionQuality& q) {
  const nlohmann::json figures = qualityJson(q);
  return padded(name, name_width) + format("%10.0f", static_cast<double>(q.points)) +
         column(figures, "e_mc_mm", 1, 12) + column(figures, "e_mc_multi_view_mm", 1, 21) +
         column(figures, "free_space_violations", 100, 16) + column(figures, "coverage", 100, 14);
}

void QualityOfSequence::add(const ReprojectionQuality& q) {
  if (q.seen_points > 0) error_ += q.error * static_cast<double>(q.seen_points);
  if (q.multi_view_points > 0) multi_view_error_ += q.multi_view_error * static_cast<double>(q.multi_view_points);
  sum_.points += q.points;
  sum_.seen_points += q.seen_points;
  sum_.multi_view_points += q.multi_view_points;
  sum_.violating_points += q.violating_points;
  sum_.pixels += q.pixels;
  sum_.covered_pixels += q.covered_pixels;
}

ReprojectionQuality QualityOfSequence::result() const {
  ReprojectionQuality q = sum_;  // 0 / 0 is NaN
  q.error = error_ / static_cast<double>(q.seen_points);
  q.multi_view_error = multi_view_error_ / static_cast<double>(q.multi_view_points);
  return q;
}

void Report::addFrame(std::size_t frame, const FrameStatistics& statistics,
                      const std::optional<ReprojectionQuality>& quality, const std::optional<SurfaceQuality>& surface) {
  frames_.push_back({frame, statistics, quality, surface, peakMemoryMebibytes()});
}

nlohmann::json Report::json() const {
  nlohmann::json frames = nlohmann::json::array();
  std::vector<double> times[std::size(kStages)];
  double points_in = 0, points_out = 0;
  QualityOfSequence quality;
  SurfaceQuality surface;
  for (const Frame& f : frames_) {
    nlohmann::json entry;
    if (f.quality) {
      entry = qualityJson(*f.quality);
      quality.add(*f.quality);
    }
    if (f.surface) {
      entry.update(surfaceJson(*f.surface));
      surface += *f.surface;
    }
    for (const char* figure : kQualityFigures)
      if (!entry.contains(figure)) entry[figure] = nullptr;
    for (const char* figure : kSurfaceFigures)
      if (!entry.contains(figure)) entry[figure] = nullptr;
    entry["frame"] = f.number;
    entry["points_in"] = f.statistics.measured_points;
    entry["points_gated"] = f.statistics.gated_points;
    entry["points_out"] = f.statistics.fused_points;
    entry["frames_per_second"] = number(1e3 / f.statistics.total_ms);
    entry["peak_memory_mib"] = f.peak_memory_mib;
    entry["missing_cameras"] = f.statistics.missing_cameras;
    entry["noise_scales"] = f.statistics.noise_scales;
    for (std::size_t s = 0; s < std::size(kStages); ++s) {
      const double ms = f.statistics.*kStages[s].milliseconds;
      entry["milliseconds"][kStages[s].name] = ms;
      times[s].push_back(ms);
    }
    frames.push_back(entry);
    const double n = static_cast<double>(frames_.size());
    points_in += static_cast<double>(f.statistics.measured_points) / n;
    points_out += static_cast<double>(f.statistics.fused_points) / n;
  }
  nlohmann::json total = {{"frames", frames_.size()},
                          {"points_in", points_in},
                          {"points_out", points_out},
                          {"frames_per_second", number(1e3 / percentile(times[std::size(kStages) - 1], 0.5))},
                          {"peak_memory_mib", peakMemoryMebibytes()}};
  total.update(surfaceJson(surface));
  const nlohmann::json figures = qualityJson(quality.result());
  for (const char* figure : kQualityFigures) total[figure] = figures[figure];
  for (std::size_t s = 0; s < std::size(kStages); ++s)
    total["milliseconds"][kStages[s].name] = {{"median", number(percentile(times[s], 0.5))},
                                              {"p95", number(percentile(times[s], 0.95))}};
  nlohmann::json result = {{"method", method_}, {"total", total}, {"frames", frames}};
  result.update(notes_);
  return result;
}

std::string Report::summary() const {
  const nlohmann::json total = json()["total"];
  const auto value = [](const nlohmann::json& v) { return v.is_number() ? v.get<double>() : std::nan(""); };
  std::string text = method_ + ": " + format("%.0f frames, ", value(total["frames"])) +
                     format("%.1f frames per second ", value(total["frames_per_second"])) +
                     format("(median %.1f ms, ", value(total["milliseconds"]["total"]["median"])) +
                     format("p95 %.1f ms), ", value(total["milliseconds"]["total"]["p95"])) +
                     format("%.0f points in, ", value(total["points_in"])) +
                     format("%.0f out a frame\n", value(total["points_out"]));
  const auto figure = [&](const char* what, const char* key, double scale, const char* unit) {
    return total[key].is_number() ? what + format(" %.2f ", scale * value(total[key])) + unit + ", " : std::string();
  };
  const std::string surface = figure("violations off silhouettes", "free_space_violations_off_silhouettes", 100, "%") +
                              figure("flicker", "flicker_mm", 1, "mm") +
                              figure("double surfaces", "double_surfaces", 100, "%") +
                              figure("noise of the surface", "surface_noise_mm", 1, "mm") +
                              figure("coverage within the sensor's noise", "coverage_within_noise", 100, "%");
  if (!surface.empty()) text += "  " + surface.substr(0, surface.size() - 2) + "\n";
  const std::string against =
      figure("E_MC", "e_mc_mm", 1, "mm") + figure("over points with two or more views", "e_mc_multi_view_mm", 1, "mm") +
      figure("free-space violations", "free_space_violations", 100, "%") + figure("coverage", "coverage", 100, "%");
  // Points left as they were measured look best in these: nobody is to judge by them alone.
  text += (against.empty() ? "  " : "  against what was measured, noise and all: ") + against +
          format("peak memory %.0f MiB\n", value(total["peak_memory_mib"]));
  std::map<std::size_t, std::size_t> missed;
  for (const Frame& f : frames_)
    for (const std::size_t camera : f.statistics.missing_cameras) ++missed[camera];
  for (const auto& [camera, count] : missed)
    text += "  camera " + (camera < cameras_.size() ? cameras_[camera] : std::to_string(camera)) + " missed " +
            std::to_string(count) + " of " + std::to_string(frames_.size()) + " frames\n";
  return text;
}

}  // namespace fuse_flow::io
