#include "viewer/controls/status_text.h"

#include "calibration/live_extrinsics.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <vector>

namespace fuse_flow::viewing {
namespace {

constexpr std::size_t kCorrections = 3;  // cameras that the overlay has a line for

std::ostringstream fixedPoint(int decimals) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals);
  return text;
}

std::string millimetres(double metres) {
  std::ostringstream text = fixedPoint(1);
  if (std::isnan(metres)) return "-";
  text << 1000 * metres << " mm";
  return text.str();
}

std::string percent(double share) {
  std::ostringstream text = fixedPoint(1);
  if (std::isnan(share)) return "-";
  text << 100 * share << " %";
  return text.str();
}

std::string rate(double frames_per_second) {
  std::ostringstream text;
  text << std::setprecision(3) << frames_per_second << " frames/s";
  return text.str();
}

}  // namespace

std::string refinementText(const RefinedExtrinsics& refined, const std::vector<Camera>& cameras) {
  std::vector<CameraMotion> corrections = refined.corrections;
  std::sort(corrections.begin(), corrections.end(),
            [](const CameraMotion& a, const CameraMotion& b) { return a.translation > b.translation; });
  std::ostringstream text = fixedPoint(1);
  for (std::size_t k = 0; k < corrections.size() && k < kCorrections; ++k)
    text << (k == 0 ? "\n  " : ", ") << cameras[corrections[k].camera].name << " by "
         << 1000 * corrections[k].translation << " mm, " << std::setprecision(2) << corrections[k].rotation * 180 / M_PI
         << std::setprecision(1) << " deg";
  if (corrections.size() > kCorrections) {
    const std::size_t others = corrections.size() - kCorrections;
    text << ", " << others << (others == 1 ? " other" : " others") << " by less";
  }
  for (const CameraMotion& motion : refined.moved) text << "\n" << io::describe(motion, cameras);
  return text.str();
}

std::string cloudText(const FusedCloud& cloud) {
  std::ostringstream text = fixedPoint(1);
  text << cloud.setting->title << ": " << cloud.cloud->size() << " points";
  if (!cloud.why_empty.empty()) text << ", " << cloud.why_empty;
  if (cloud.truth_distance && !cloud.cloud->empty()) text << ", " << millimetres(*cloud.truth_distance) << " off truth";
  if (cloud.surface && !cloud.cloud->empty()) {
    text << ", violations off silhouettes " << percent(cloud.surface->violationShare()) << ",\n  double surfaces "
         << percent(cloud.surface->doubleSurfaces()) << ", noise " << millimetres(cloud.surface->noise());
    if (cloud.surface->flicker.points > 0) text << ", flicker " << millimetres(cloud.surface->flicker.mean());
    text << ", covers " << percent(cloud.surface->coverage()) << " within noise";
  }
  if (cloud.quality && !cloud.cloud->empty())
    text << "; off noisy depth: E_MC " << millimetres(cloud.quality->error) << " (2+ views "
         << millimetres(cloud.quality->multi_view_error) << ")";
  if (cloud.setting->method == kStreamed) return text.str();
  const FrameStatistics& s = cloud.statistics;
  text << "\n  total " << s.total_ms << " ms";
  if (cloud.setting->method != "fuse_flow")
    text << " = back-projection " << s.generate_ms << ", thinning " << s.fuse_ms << ", output " << s.output_ms;
  else if (s.preprocess_ms + s.generate_ms + s.merge_ms + s.fuse_ms + s.output_ms > 0)
    text << " = prepare " << s.preprocess_ms << ", generate " << s.generate_ms << ", merge " << s.merge_ms << ", fuse "
         << s.fuse_ms << ", output " << s.output_ms;
  return text.str();
}

std::string statusText(const Playback& playback, const Rates& rates, const FusedFrame& shown, bool awaited) {
  std::ostringstream text = fixedPoint(1);
  text << (playback.frames() ? frameName(shown.frame, *playback.frames()) : frameName(shown.frame));
  text << (playback.playing() ? ", playing" : ", paused") << " at " << std::setprecision(playback.speed() < 1 ? 3 : 1)
       << playback.speed() << "x (" << rate(playback.speed() * playback.framesPerSecond()) << ")"
       << (playback.loop() && playback.frames() ? ", looping" : "") << std::setprecision(1)
       << (awaited ? "; the next picture is being fused ..." : "") << "\n";
  if (rates.pictures > 0)
    text << (playback.playing() ? "" : "played at ") << rates.clouds << " clouds/s, " << rates.pictures
         << " pictures/s, ";
  text << "reading " << shown.read_ms << " ms\n";
  const auto state = [&](Component component) {
    return uses(shown.clouds[0]->setting->options.parameters, component) ? "on" : "OFF";
  };
  const bool streamed = shown.clouds[0]->setting->method == kStreamed;
  if (!streamed)
    text << "1 MF " << state(Component::MeasurementConfidence) << "  2 DC " << state(Component::DistanceConsistency)
         << "  3 SA " << state(Component::SpatialHash);
  if (!streamed) text << "  0 poses " << (shown.refined ? "refined" : "given");
  if (shown.refined) text << refinementText(*shown.refined, shown.cameras);
  for (const auto& cloud : shown.clouds)
    if (cloud) text << "\n" << cloudText(*cloud);
  for (const auto* lines : {&shown.source_status, &shown.damaged, &shown.ended})
    for (const std::string& line : *lines) text << "\n" << line;
  return text.str();
}

std::string headingOf(const FusedCloud& cloud, ColorBy color_by, bool comparing) {
  std::string note = cloud.why_empty;
  const PointAttributes& attributes = cloud.attributes;
  if (note.empty() && color_by == ColorBy::Confidence && !attributes.confidence_known) note = "has no confidence, grey";
  if (note.empty() && color_by == ColorBy::Views && !attributes.views_known) note = "counts no cameras, grey";
  if (!comparing) return note;
  return cloud.setting->title + (note.empty() ? "" : ": " + note);
}

}  // namespace fuse_flow::viewing
