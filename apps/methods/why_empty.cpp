#include "methods/why_empty.h"

#include <algorithm>
#include <functional>
#include <sstream>
#include <vector>

namespace fuse_flow::io {
namespace {

/** \brief A setting that drops points. */
struct Gate {
  std::string name;
  std::function<void(FuseFlowParameters&)> open;
};

/** \param confidence whether any view gives one */
std::vector<Gate> gatesOf(const FuseFlowParameters& p, bool confidence, SettingNames names) {
  std::vector<Gate> gates;
  const bool sliders = names == SettingNames::Sliders;
  const auto add = [&](const char* slider, const char* option, double value, const auto& open, double scale = 1) {
    std::ostringstream text;
    if (sliders) {
      text << slider << " = " << scale * value;
    } else {
      text << option << ' ' << value;
    }
    gates.push_back({text.str(), open});
  };
  if (p.crop_box)
    gates.push_back({sliders ? "the crop box" : "--crop-box", [](FuseFlowParameters& q) { q.crop_box.reset(); }});
  add("tau", "--tau", static_cast<double>(p.confidence.threshold),
      [](FuseFlowParameters& q) { q.confidence.threshold = 0; });
  if (confidence && p.min_confidence > 0)
    add("smallest confidence of the images", "--min-confidence", static_cast<double>(p.min_confidence),
        [](FuseFlowParameters& q) { q.min_confidence = 0; });
  if (p.use_spatial_hash)
    add("smallest weight", "--min-weight", static_cast<double>(p.aggregation.min_weight),
        [](FuseFlowParameters& q) { q.aggregation.min_weight = 0; });
  if (p.max_noise > 0)
    add(
        "largest noise, mm", "--max-noise", static_cast<double>(p.max_noise),
        [](FuseFlowParameters& q) { q.max_noise = 0; }, 1000);
  if (p.min_support > 0)
    add("smallest support", "--min-support", p.min_support, [](FuseFlowParameters& q) { q.min_support = 0; });
  if (p.agreement.min_views > 0)
    add("other views that measure the same", "--min-agreeing-views", p.agreement.min_views,
        [](FuseFlowParameters& q) { q.agreement.min_views = 0; });
  return gates;
}

bool givesPoints(const std::string& name, MethodOptions options, const RigFrame& frame,
                 const std::function<void(FuseFlowParameters&)>& open, std::size_t& measured) {
  open(options.parameters);
  const std::unique_ptr<Method> method = makeMethod(name, options);
  Method::Cloud cloud;
  method->fuse(frame, cloud);
  measured = method->statistics().measured_points;
  return !cloud.empty();
}

}  // namespace

std::string whyEmpty(const std::string& method, const MethodOptions& options, const RigFrame& frame,
                     SettingNames names) {
  if (std::all_of(frame.views.begin(), frame.views.end(), [](const DepthView& view) { return view.missing(); }))
    return "no camera has an image";
  std::size_t measured = 0;
  const bool confidence =
      std::any_of(frame.views.begin(), frame.views.end(), [](const DepthView& view) { return bool(view.confidence); });
  const std::vector<Gate> gates = gatesOf(options.parameters, confidence, names);
  std::string all;
  for (const Gate& gate : gates) {
    if (givesPoints(method, options, frame, gate.open, measured)) return "no point passes " + gate.name;
    if (measured == 0) return "no camera measured anything within its range";
    all += (all.empty() ? "" : ", ") + gate.name;
  }
  return "no point passes " + all;
}

}  // namespace fuse_flow::io
