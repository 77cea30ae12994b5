#include "command_line/arguments/parameter_options.h"

#include "command_line/arguments/option_checks.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <limits>
#include <sstream>

namespace fuse_flow::command_line {
namespace {

constexpr int kTwoViewsAgreeing = 1;  // the other one

}  // namespace

/** \brief A member of given_, found again in another FuseFlowParameters by its place. */
template <typename Value>
void ParameterOptions::overrideWhenGiven(CLI::Option* option, const Value& member) {
  const std::ptrdiff_t place = reinterpret_cast<const char*>(&member) - reinterpret_cast<const char*>(&given_);
  overrides_.push_back([this, option, place](FuseFlowParameters& result) {
    if (option->count() == 0) return;
    *reinterpret_cast<Value*>(reinterpret_cast<char*>(&result) + place) =
        *reinterpret_cast<const Value*>(reinterpret_cast<const char*>(&given_) + place);
  });
}

template <typename Value>
void ParameterOptions::add(CLI::App& app, const std::string& name, Value& member, const std::string& help) {
  CLI::Option* option = app.add_option(name, member, help)->capture_default_str()->group("Parameters");
  if constexpr (std::is_same_v<Value, bool>)
    option->check(trueOrFalse())->default_str(member ? "true" : "false");
  else if constexpr (std::is_floating_point_v<Value>)
    option->check(finiteNumber());
  else
    option->check(wholeNumber(0, std::numeric_limits<int>::max()));
  std::string parameter = name == "--tau" ? "threshold" : name.substr(2);
  std::replace(parameter.begin(), parameter.end(), '-', '_');
  option_of_[parameter] = name;
  overrideWhenGiven(option, member);
}

template <typename Enum>
void ParameterOptions::addEnum(CLI::App& app, const std::string& name, Enum& member,
                               const std::map<std::string, Enum>& values, const std::string& help) {
  CLI::Option* option = app.add_option(name, member, help)->group("Parameters");
  std::string names;
  for (const auto& [value_name, value] : values) {
    names += (names.empty() ? "{" : ",") + value_name;
    if (value == member) option->default_str(value_name);
  }
  names += "}";
  const auto to_number = [values, names](std::string& given) {
    const auto found = values.find(given);
    if (found == values.end()) return given + " not in " + names;
    given = std::to_string(static_cast<int>(found->second));
    return std::string();
  };
  option->transform(CLI::Validator(to_number, names))->type_name("TEXT");
  overrideWhenGiven(option, member);
}

ParameterOptions::ParameterOptions(CLI::App& app) : app_(app) {
  CLI::Option* published =
      app.add_flag("--published", published_, "start from the paper's own forms instead of our defaults");
  app.add_option("--depth-source", depth_source_,
                 "what made the depth; stereo, network: start from what suits depth estimated from colour images; "
                 "stereo where all of it is estimated by this program")
      ->check(CLI::IsMember({"camera", "stereo", "network"}))
      ->capture_default_str()
      ->excludes(published);
  PreprocessingParameters& pre = given_.preprocessing;
  add(app, "--min-range", pre.min_range, "nearest depth, m");
  add(app, "--max-range", pre.max_range, "farthest depth, m");
  add(app, "--fill-neighbours", pre.fill_neighbours, "fill a hole with at least this many neighbours, 3-8; 0: off");
  add(app, "--fill-tolerance", pre.fill_tolerance, "largest spread of those neighbours, m");
  add(app, "--bilateral", pre.bilateral, "edge-preserving filter over the depth (true/false)");
  add(app, "--bilateral-sigma-s", pre.bilateral_sigma_s, "pixels");
  add(app, "--bilateral-sigma-r", pre.bilateral_sigma_r, "m");
  add(app, "--smoothing-passes", given_.smoothing.passes, "refined depth, 0-4; 0: the measured depth");
  add(app, "--smoothing-tolerance", given_.smoothing.tolerance, "of the refined depth, standard deviations");
  add(app, "--smoothing-shrink", given_.smoothing.shrink, "of the tolerance from pass to pass");
  add(app, "--smoothing-wide-above", given_.smoothing.wide_above,
      "noise over what is expected that doubles the spacing");
  add(app, "--smoothing-twicing", given_.smoothing.twicing, "keep curved surfaces where they are (true/false)");
  add(app, "--smoothing-twicing-above", given_.smoothing.twicing_above,
      "what it takes for curvature, standard deviations of the noise");
  add(app, "--adapt-noise", given_.adapt_noise, "measure how noisy each view is (true/false)");
  add(app, "--half-weight-noise", given_.half_weight_noise, "axial noise that halves a weight, m; 0: none does");
  add(app, "--gate-noise", given_.gate_noise, "ask for tau only above this axial noise, m; 0: everywhere");
  add(app, "--max-noise", given_.max_noise, "drop measurements of more axial noise, m; 0: none");
  add(app, "--min-confidence", given_.min_confidence,
      "drop measurements whose own confidence is less; 0: those of none");
  add(app, "--min-support", given_.min_support, "drop measurements that fewer neighbours continue, 1-8; 0: none");
  add(app, "--min-agreeing-views", given_.agreement.min_views,
      "drop measurements that fewer other views measure, too; 0: none");
  option_of_["agreement_min_views"] = "--min-agreeing-views";
  add(app, "--agreement-pixels", given_.agreement.pixels, "there and back, they come back this near, pixels");
  add(app, "--agreement-relative", given_.agreement.relative, "and differ in depth by at most this share");
  ConfidenceParameters& c = given_.confidence;
  addEnum(app, "--confidence-form", c.form,
          {{"published", ConfidenceForm::Published},
           {"slope_compensated", ConfidenceForm::SlopeCompensated},
           {"given", ConfidenceForm::Given}},
          "eq. 3, or the recording's own confidence images");
  add(app, "--alpha", c.alpha, "eq. 3");
  add(app, "--beta", c.beta, "eq. 3, per length unit");
  add(app, "--gamma", c.gamma, "eq. 3");
  add(app, "--delta", c.delta, "eq. 3, per length unit");
  add(app, "--tau", c.threshold, "eq. 9 on the scale 0-1");
  add(app, "--length-unit", c.length_unit, "of G and sigma_local, m");
  add(app, "--noise-floor", c.noise.floor, "axial noise at 0, m; where a camera names no noise of its own");
  add(app, "--noise-linear", c.noise.linear, "axial noise per z");
  add(app, "--noise-quadratic", c.noise.quadratic, "axial noise per z squared, 1/m");
  add(app, "--noise-reference", c.noise_reference, "depth at which C is scaled, m");
  add(app, "--max-incidence", c.max_incidence, "steepest surface, rad");
  ConsistencyParameters& v = given_.consistency;
  addEnum(app, "--occlusion-form", v.occlusion,
          {{"published", OcclusionForm::Published}, {"occlusion_aware", OcclusionForm::OcclusionAware}}, "eq. 7");
  addEnum(app, "--distance-form", v.distance,
          {{"euclidean", DistanceForm::Euclidean}, {"along_ray", DistanceForm::AlongRay}}, "eq. 6");
  add(app, "--sigma", v.sigma, "eq. 7, m");
  add(app, "--sigma-per-noise", v.sigma_per_noise, "sigma is at least this times the axial noise");
  add(app, "--margin", v.margin, "occlusion and free space, in sigmas");
  add(app, "--free-space-penalty", v.free_space_penalty, "factor on V for each view that sees through the point");
  add(app, "--weigh-contradictions", v.weigh_contradictions,
      "such a view counts by the confidence of its pixel (true/false)");
  add(app, "--min-facing", v.min_facing, "ask only views that the surface faces, least cosine; -1: all");
  add(app, "--silhouette-radius", v.silhouette_radius,
      "a view sees through a point only if it has not measured it this near, pixels");
  add(app, "--max-views", v.max_views, "K of eq. 7");
  add(app, "--max-candidates", v.max_candidates, "views looked into at most");
  AggregationParameters& a = given_.aggregation;
  addEnum(app, "--representatives", a.representatives,
          {{"highest_confidence", Representatives::HighestConfidence},
           {"different_cameras", Representatives::DifferentCameras},
           {"camera_means", Representatives::CameraMeans}},
          "section 5 (2) a");
  addEnum(app, "--consistency-at", a.consistency_at,
          {{"representatives", ConsistencyAt::Representatives}, {"cell_mean", ConsistencyAt::CellMean}},
          "section 5 (2) b");
  add(app, "--cell-size", a.cell_size, "coarse cell, m; 0.0001 or more");
  add(app, "--min-cell-size", a.min_cell_size, "smallest cell, m");
  add(app, "--points-per-cell", a.points_per_cell, "wanted in a refined cell");
  add(app, "--min-weight", a.min_weight, "drop fused points of less weight");
  add(app, "--weak-weight", a.weak_weight, "thin out fused points of less weight");
  add(app, "--confirmation-reach", a.confirmation_reach, "move fused points to what views this near confirm, m");
  add(app, "--reach-per-noise", a.reach_per_noise,
      "--confirmation-reach is at least this times the deviation of depth, up to twice itself");
  add(app, "--measurement-confidence", given_.use_measurement_confidence, "MF of the ablation (true/false)");
  add(app, "--distance-consistency", given_.use_distance_consistency, "DC of the ablation (true/false)");
  add(app, "--spatial-hash", given_.use_spatial_hash, "SA of the ablation (true/false)");
  app.add_option("--crop-box", crop_box_, "min_x min_y min_z max_x max_y max_z, world frame, m")
      ->expected(6)
      ->check(finiteNumber())
      ->group("Parameters");
}

bool ParameterOptions::given(const char* option) const { return app_.get_option(option)->count() > 0; }

std::string ParameterOptions::assumeStereo(std::size_t views) {
  if (published_ || (given("--depth-source") && depth_source_ == "camera")) return "";
  std::ostringstream options;
  const auto assume = [&](const char* option, const auto& value) {
    if (given(option)) return false;
    options << (options.str().empty() ? "" : " ") << option << ' ' << value;
    return true;
  };
  assume("--depth-source", "stereo");
  depth_source_ = "stereo";
  of_two_views_ = views == 2;
  if (!of_two_views_) return options.str();
  if (assume("--min-agreeing-views", kTwoViewsAgreeing)) options << ", as two views can agree with one another alone";
  return options.str();
}

FuseFlowParameters ParameterOptions::parameters() const {
  FuseFlowParameters result = published_                  ? FuseFlowParameters::published()
                              : depth_source_ == "camera" ? FuseFlowParameters()
                                                          : FuseFlowParameters::estimatedDepth();
  if (of_two_views_) result.agreement.min_views = kTwoViewsAgreeing;
  for (const auto& apply : overrides_) apply(result);
  if (crop_box_.size() == 6) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (crop_box_[axis] > crop_box_[axis + 3])
        throw io::OptionError("--crop-box: a minimum exceeds its maximum, must be min_x min_y min_z max_x max_y max_z");
    result.crop_box = Eigen::AlignedBox3f(Eigen::Vector3f(crop_box_[0], crop_box_[1], crop_box_[2]),
                                          Eigen::Vector3f(crop_box_[3], crop_box_[4], crop_box_[5]));
  }
  try {
    checkParameters(result);
  } catch (const pcl::PCLException& error) {
    throw io::OptionError(withOptionNames(error.what(), option_of_));
  }
  // Cells have numbers of 20 bits: a room would not fit.
  if (result.aggregation.cell_size < 1e-4f) {
    std::ostringstream message;
    message << "--cell-size is " << result.aggregation.cell_size << ", must be 0.0001 m or more";
    throw io::OptionError(message.str());
  }
  return result;
}

std::vector<std::string> ParameterOptions::advice() const {
  const FuseFlowParameters p = parameters();
  std::vector<std::string> lines;
  for (const auto& [option, metres] : {std::pair{"--max-range", p.preprocessing.max_range},
                                       {"--length-unit", p.confidence.length_unit},
                                       {"--noise-reference", p.confidence.noise_reference}}) {
    constexpr float farther_than_any = 300;  // of the sensors that there are
    if (!given(option) || !(metres > farther_than_any)) continue;
    std::ostringstream line;
    line << option << ' ' << metres << " is in metres; " << metres << " mm are " << metres / 1000;
    lines.push_back(line.str());
  }
  const bool asked_of_all =
      !(p.gate_noise > 0) || !p.use_measurement_confidence || p.confidence.form == ConfidenceForm::Given;
  if (asked_of_all || !given("--tau") || given("--gate-noise")) return lines;
  std::ostringstream line;
  line << "--tau " << p.confidence.threshold << " is asked only of measurements with more than " << 1000 * p.gate_noise
       << " mm of axial noise, and of views with a confidence of their own; --gate-noise 0 asks it of all";
  lines.push_back(line.str());
  return lines;
}

}  // namespace fuse_flow::command_line
