// Reproduces the paper's tables on simulated rigs, against the truth and beside what people use, and writes them with plots
// as one Markdown page.

#include "command_line/arguments/option_checks.h"
#include "command_line/tool.h"
#include "drawing/charts.h"
#include "drawing/clouds.h"
#include "drawing/display.h"
#include "evaluation/tables/comparison.h"
#include "evaluation/tables/markdown.h"
#include "evaluation/tables/measure_ranking.h"
#include "evaluation/tables/open3d_methods.h"
#include "evaluation/tables/place_means.h"
#include "recordings/files/file_io.h"
#include "recordings/images/image_io.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/recordings/input_files.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace {

namespace fs = std::filesystem;
using namespace fuse_flow;
using tables::Contender;
using tables::MarkdownTable;
using tables::number;
using tables::Result;
using tables::Setup;
using tables::Thinning;

struct Options {
  std::string output;
  std::string reading;
  std::string measures;
  std::string surround;
  bool quick{false};
  double scale{1};
  int threads{0};
};

/** \brief What tuning has looked at, and what it has not. */
const std::vector<Setup> kTuning = {{"room", "ring-4", "structured_light"},
                                    {"room", "walls-8", "time_of_flight"},
                                    {"table", "ring-8", "structured_light"},
                                    {"table", "ring-4", "active_stereo"}};
const std::vector<Setup> kHeldOut = {{"thin", "ring-6", "structured_light"},
                                     {"thin", "ring-6", "time_of_flight_multipath"},
                                     {"thin", "ring-6", "active_stereo"},
                                     {"person", "ring-6", "structured_light", 5},
                                     {"person", "ring-6", "time_of_flight_multipath", 3},
                                     {"person", "walls-16", "active_stereo"}};

/** \brief Cameras that look outward, with little overlap, while somebody passes. */
const std::vector<Setup> kSurround = {{"passerby", "surround-8", "time_of_flight", 3},
                                      {"passerby", "surround-6", "time_of_flight", 3},
                                      {"passerby", "surround-5", "active_stereo", 3},
                                      {"passerby", "surround-6", "active_stereo", 3}};

class Page {
 public:
  explicit Page(const Options& options) : options_(options) {}

  void write() {
    text_ << "# Results\n\nWritten by `./build.sh tables`, all in one run on " << options_.threads
          << " threads. Simulated rigs, calibrated to 2 mm and 0.1°, measured "
             "against the true surface; the peers are thinned to the number of points that FUSE-Flow gives, but for "
             "the last row. "
             "[defaults.md](notes/defaults.md) says how the defaults were chosen.\n\n";
    if (tables::open3dPeers().empty()) text_ << "Without Open3D, which was not found when this was built.\n\n";
    addReading();
    text_ << "Columns: mean distance of the points to the true surface and its ratio to VoxelGrid's; 95th percentile; "
             "F-score at 5 and "
             "10 mm; completeness, the share of the surface that a camera saw with a point within 10 mm; ghosting, the "
             "share of "
             "points over 30 mm from any surface; flicker, the jump of the cloud from frame to frame where nothing "
             "moves; colour, mean "
             "difference to the true colour, of 255; E_MC of eq. 12; median milliseconds of a frame. Where there is a "
             "person, a second table is about the person only, all "
             "frames together: signed, the mean distance with its sign, negative inside of the body; under 40 mm, what "
             "is "
             "less than that above the floor; over 65°, what no camera sees more directly than that.\n\n";
    comparisons("Seen while tuning", "accuracy_tuning", pick(kTuning));
    const std::vector<Result> held_out = comparisons("Held out from tuning", "accuracy_held_out", pick(kHeldOut));
    text_ << "[quality_measures.md](notes/quality_measures.md) has what can be measured of the same clouds without the "
             "truth, "
             "and how far that ranks them as the truth does.\n\n";
    targets(held_out);
    paperTable();
    ablation();
    frameRates();
    io::writeFile(options_.output, text_.str());
    if (!options_.measures.empty()) io::writeFile(options_.measures, ranking_.text(options_.threads));
  }

  /** \brief Only what can be said without the truth, and how it ranks. */
  void writeMeasures() {
    for (const auto* setups : {&kTuning, &kHeldOut})
      for (const Setup& setup : pick(*setups)) {
        say(setup.name());
        ranking_.add(setup, tables::peers(), tables::compare(setup, tables::peers(), options_.threads));
        io::writeFile(options_.measures,
                      ranking_.text(options_.threads));  // what is done is there when it is interrupted
      }
  }

  /** \brief A page of its own. The paper's other peer, R3D3, has cameras on a car. */
  void writeSurround() {
    text_ << "# Cameras that look outward\n\nWritten by `build/bin/fuse_flow_tables --surround FILE`, on "
          << options_.threads
          << " threads. As on a robot or a car: in a hall of 8 m × 6 m somebody walks past. Eight "
             "time-of-flight cameras overlap by 20°, six by 5°; five stereo cameras by 18°, six by 30°. Most is seen "
             "by one camera, which no other confirms: it must stay. Poses are 2 mm and 0.1° off. Not used for tuning. "
             "The "
             "columns are those of [the results](../results.md), the times those of this run.\n\n";
    const std::vector<Contender> peers = tables::peers();
    for (const Setup& setup : pick(kSurround)) {
      say(setup.name());
      const std::vector<Result> results = tables::compare(setup, peers, options_.threads);
      text_ << "## " << setup.name() << ", " << setup.frames << (setup.frames > 1 ? " frames" : " frame") << "\n\n";
      comparisonTable(peers, results);
      seenByTable(peers, results);
      personTable(peers, results);
      text_ << "\n";
      io::writeFile(options_.surround, text_.str());  // what is done is there when it is interrupted
    }
  }

 private:
  /** \brief Everything, or with --quick little of it, small. */
  std::vector<Setup> pick(std::vector<Setup> setups) const {
    for (Setup& setup : setups) setup.scale = options_.scale;
    if (!options_.quick) return setups;
    setups.resize(1);
    return {small(setups[0])};
  }
  Setup small(Setup setup) const {
    if (options_.quick) {
      setup.scale = 0.2;
      setup.frames = std::min<std::size_t>(setup.frames, 2);
    }
    return setup;
  }

  void addReading() {
    if (options_.reading.empty()) return;
    std::ifstream file(options_.reading);
    if (!file) throw io::InputError(options_.reading + ": cannot be read");
    text_ << file.rdbuf() << "\n";
  }

  void say(const std::string& what) const { std::cerr << what << std::endl; }

  std::string imageName(const std::string& name) const { return "results_" + name + ".png"; }
  void addImage(const std::string& name, const std::string& caption, const io::ColorImage& image) {
    const fs::path folder = fs::path(options_.output).parent_path() / "images";
    fs::create_directories(folder);
    io::writeColorPng((folder / imageName(name)).string(), image);
    text_ << "![" << caption << "](images/" << imageName(name) << ")\n\n";
  }

  /** \brief The results of all setups, those of one setup one after the other, in the order of the peers. */
  std::vector<Result> comparisons(const std::string& title, const std::string& image,
                                  const std::vector<Setup>& setups) {
    const std::vector<Contender> peers = tables::peers();
    text_ << "## " << title << "\n\n";
    std::vector<Result> all;
    std::vector<std::string> groups, names;
    std::vector<std::vector<double>> bars(peers.size());
    for (const Contender& peer : peers) names.push_back(peer.name);
    for (const Setup& setup : setups) {
      say(setup.name());
      std::vector<drawing::ColoredPoints> picture;
      const std::vector<Result> results =
          tables::compare(setup, peers, options_.threads, [&](std::size_t k, const auto& cloud, const auto& distances) {
            if (k > 1 || setup.scene != "person" || &setup != &setups[setups.size() / 2]) return;
            picture.emplace_back();
            picture.back().positions = cloud.positions;
            for (const float d : distances) picture.back().colors.push_back(drawing::errorColor(d, 0.02f));
          });
      text_ << "### " << setup.name() << (setup.frames > 1 ? ", " + std::to_string(setup.frames) + " frames" : "")
            << "\n\n";
      comparisonTable(peers, results);
      personTable(peers, results);
      ranking_.add(setup, peers, results);
      if (!picture.empty()) {
        drawing::Viewpoint viewpoint;
        viewpoint.zoom = 1.3;
        addImage("errors", "FUSE-Flow and VoxelGrid: blue on the true surface, red 20 mm or more from it",
                 drawing::drawClouds(picture, viewpoint));
      }
      for (std::size_t k = 0; k < peers.size(); ++k) bars[k].push_back(results[k].truth.accuracy_mean);
      groups.push_back(setup.scene + "\n" + setup.rig + "\n" + shortName(setup.sensor));
      all.insert(all.end(), results.begin(), results.end());
    }
    addImage(image, "Mean distance to the true surface",
             drawing::drawBars({"Mean distance to the true surface", " " /* room for the names */, "mm"}, groups, names,
                               bars));
    return all;
  }

  static std::string shortName(const std::string& sensor) {
    if (sensor == "structured_light") return "SL";
    if (sensor == "active_stereo") return "stereo";
    return sensor == "time_of_flight" ? "ToF" : "ToF mp";
  }

  void comparisonTable(const std::vector<Contender>& peers, const std::vector<Result>& results) {
    MarkdownTable table({"", "points", "mean mm", "ratio", "p95 mm", "F 5 mm", "F 10 mm", "compl. %", "ghosting %",
                         "flicker mm", "colour", "E_MC mm", "ms"});
    for (std::size_t k = 0; k < peers.size(); ++k) {
      const Result& r = results[k];
      table.row({peers[k].name, std::to_string(r.truth.points), number(r.truth.accuracy_mean, 2),
                 number(r.truth.accuracy_mean / results[1].truth.accuracy_mean, 2), number(r.truth.accuracy_p95, 1),
                 number(r.truth.f_score_5, 3), number(r.truth.f_score_10, 3), number(100 * r.truth.completeness_10, 1),
                 number(100 * r.truth.ghosting, 2), number(r.flicker, 2), number(r.truth.color_error, 1),
                 number(r.multi_camera_error, 2), number(r.milliseconds, 0)});
    }
    text_ << table.text();
  }

  static const simulation::PartQuality* partNamed(const Result& result, const char* name) {
    for (const simulation::PartQuality& part : result.parts)
      if (part.name() == name) return &part;
    return nullptr;
  }

  /** \brief The person alone, where there is one: what a mean over walls hides. */
  void personTable(const std::vector<Contender>& peers, const std::vector<Result>& results) {
    const simulation::PartQuality* first = partNamed(results[0], "person");
    if (first == nullptr || first->surfaceSamples() == 0) return;
    MarkdownTable table({"the person only", "points", "mean mm", "signed mm", "over 30 mm %", "F 5 mm", "compl. %",
                         "hands, compl. %", "feet, compl. %", "under 40 mm, compl. %", "over 65°, compl. %"});
    for (std::size_t k = 0; k < peers.size(); ++k) {
      const auto complete = [&](const char* part) {
        return number(100 * partNamed(results[k], part)->completeness10(), 1);
      };
      const simulation::PartQuality& person = *partNamed(results[k], "person");
      table.row({peers[k].name, std::to_string(person.points()), number(person.accuracyMean(), 2),
                 number(person.signedMean(), 2), number(100 * person.ghosting(), 2), number(person.fScore5(), 3),
                 complete("person"), complete("hand"), complete("foot"), complete("near the floor"),
                 complete("incidence over 65 deg")});
    }
    text_ << "\n" << table.text();
  }

  /** \brief The best F-score at 5 mm of the peers that have as many points as we. */
  static double bestPeer(const std::vector<Contender>& peers, const Result* results) {
    double best = 0;
    for (std::size_t k = 1; k < peers.size(); ++k)
      if (peers[k].equalPoints()) best = std::max(best, results[k].truth.f_score_5);
    return best;
  }

  static const Result& resultOf(const std::string& method, Thinning thinning, const std::vector<Contender>& peers,
                                const Result* results) {
    std::size_t k = 0;
    while (peers[k].method != method || peers[k].thinning != thinning) ++k;
    return results[k];
  }

  void targets(const std::vector<Result>& results) {
    const std::vector<Contender> peers = tables::peers();
    const std::vector<Setup> setups = pick(kHeldOut);
    text_ << "### What we aim for, on what was held out\n\nAt an equal number of points: F-score at 5 mm above every "
             "peer's; mean distance at most 0.7 × VoxelGrid's; ghosting at most a tenth, and completeness at 10 mm at "
             "least 98 %, of the concatenation's that is thinned at random. Beside it what the concatenation has with "
             "all its points.\n\n";
    MarkdownTable table({"", "F 5 mm", "best peer", "mean, ratio", "ghosting, ratio", "completeness, ratio", "missed",
                         "all points: times ours", "F 5 mm", "completeness, ratio"});
    for (std::size_t s = 0; s < setups.size(); ++s) {
      const Result* r = &results[s * peers.size()];
      const simulation::TruthQuality &ours = r[0].truth, &grid = resultOf("voxel_grid", Thinning::Leaf, peers, r).truth,
                                     &thinned = resultOf("concatenate", Thinning::Random, peers, r).truth,
                                     &all = resultOf("concatenate", Thinning::None, peers, r).truth;
      const double best_peer = bestPeer(peers, r);
      const double mean = ours.accuracy_mean / grid.accuracy_mean;
      const double ghosting = ours.ghosting / thinned.ghosting;
      const double completeness = ours.completeness_10 / thinned.completeness_10;
      std::string missed;
      const auto check = [&](bool holds, const char* what) {
        if (!holds) missed += (missed.empty() ? "" : ", ") + std::string(what);
      };
      check(ours.f_score_5 > best_peer, "F-score");
      check(mean <= 0.7, "mean");
      check(ghosting <= 0.1, "ghosting");
      check(completeness >= 0.98, "completeness");
      table.row({setups[s].name(), number(ours.f_score_5, 3), number(best_peer, 3), number(mean, 2),
                 number(ghosting, 3), number(completeness, 3), missed.empty() ? "nothing" : missed,
                 number(static_cast<double>(all.points) / static_cast<double>(ours.points), 1),
                 number(all.f_score_5, 3), number(ours.completeness_10 / all.completeness_10, 3)});
    }
    text_ << table.text();
  }

  /** \brief What of the person two cameras see, and what one alone. */
  void seenByTable(const std::vector<Contender>& peers, const std::vector<Result>& results) {
    MarkdownTable table({"the person only", "seen by one: mean mm", "over 30 mm %", "F 5 mm", "compl. %",
                         "by several: mean mm", "over 30 mm %", "F 5 mm", "compl. %"});
    for (std::size_t k = 0; k < peers.size(); ++k) {
      std::vector<std::string> row{peers[k].name};
      for (const char* name : {"seen by 1 camera", "seen by 2 or more"}) {
        const simulation::PartQuality& part = *partNamed(results[k], name);
        row.push_back(number(part.accuracyMean(), 2));
        row.push_back(number(100 * part.ghosting(), 2));
        row.push_back(number(part.fScore5(), 3));
        row.push_back(number(100 * part.completeness10(), 1));
      }
      table.row(row);
    }
    text_ << "\n" << table.text();
  }

  /** \brief Table I. Its peers reconstruct depth from colour, so only ratios can stand beside each other. */
  void paperTable() {
    text_ << "## The paper's table I\n\nThe paper compares E_MC with PatchmatchNet on static scenes (9.2 against 11.8 "
             "mm, 62 against 17 frames a "
             "second) and with R3D3 on dynamic ones (12.9 against 17.2 mm, 56 against 11), which reconstruct from "
             "colour. Here the other "
             "method is VoxelGrid, on four cameras.\n\n";
    MarkdownTable table({"", "E_MC ours mm", "VoxelGrid mm", "ratio", "paper's ratio", "frames/s ours", "VoxelGrid",
                         "ratio", "paper's ratio"});
    const std::vector<Contender> both = {tables::peers()[0], tables::peers()[1]};
    const auto row = [&](const std::string& name, const Setup& setup, double paper_error, double paper_rate) {
      say("table I: " + setup.name());
      const std::vector<Result> r = tables::compare(small(setup), both, options_.threads);
      table.row({name, number(r[0].multi_camera_error, 2), number(r[1].multi_camera_error, 2),
                 number(r[0].multi_camera_error / r[1].multi_camera_error, 2), number(paper_error, 2),
                 number(1e3 / r[0].milliseconds, 1), number(1e3 / r[1].milliseconds, 1),
                 number(r[1].milliseconds / r[0].milliseconds, 2), number(paper_rate, 2)});
    };
    row("static: room, structured_light", {"room", "ring-4", "structured_light"}, 9.2 / 11.8, 62.0 / 17);
    row("dynamic: person, structured_light", {"person", "ring-4", "structured_light", 3}, 12.9 / 17.2, 56.0 / 11);
    text_ << table.text()
          << "E_MC compares a cloud with the noisy measurements themselves, and counts for each point the camera that "
             "it came from: it "
             "prefers points left as they were measured to points on the surface.\n\n";
  }

  /** \brief Table II. */
  void ablation() {
    const Setup setup = small({"person", "ring-4", "structured_light", 3});
    text_
        << "## The paper's table II: one stage off at a time\n\n"
        << setup.name()
        << ". The paper's E_MC: 17.4 mm without measurement confidence, 16.3 without distance consistency, 9.8 "
           "without the "
           "spatial hash, 12.9 with all; 61, 71, 28 and 56 frames per second. \"Same places\": the mean over cubes of "
           "10 mm in which the cloud of all stages has points too, each counting alike, of the first frame.\n\n";
    say("table II");
    const std::vector<Contender> contenders = tables::ablation();
    std::vector<tables::PlaceMeans> places;
    const auto keepPlaces = [&](std::size_t, const simulation::PlainCloud& cloud, const std::vector<float>& distances) {
      places.emplace_back(cloud.positions, distances, 0.01f);
    };
    const std::vector<Result> results = tables::compare(setup, contenders, options_.threads, keepPlaces);
    MarkdownTable table({"", "points", "E_MC mm", "ratio", "paper's ratio", "mean mm", "same places, ratio", "p95 mm",
                         "F 5 mm", "compl. %", "ghosting %", "ms", "speed, ratio", "paper's ratio"});
    const double errors[] = {12.9, 17.4, 16.3, 9.8}, rates[] = {56, 61, 71, 28};
    for (std::size_t k = 0; k < contenders.size(); ++k) {
      const Result& r = results[k];
      table.row({contenders[k].name, std::to_string(r.truth.points), number(r.multi_camera_error, 2),
                 number(r.multi_camera_error / results[0].multi_camera_error, 2),
                 k < 4 ? number(errors[k] / errors[0], 2) : "–", number(r.truth.accuracy_mean, 2),
                 number(places[k].ratioTo(places[0]), 2), number(r.truth.accuracy_p95, 1), number(r.truth.f_score_5, 3),
                 number(100 * r.truth.completeness_10, 1), number(100 * r.truth.ghosting, 2), number(r.milliseconds, 0),
                 number(results[0].milliseconds / r.milliseconds, 2), k < 4 ? number(rates[k] / rates[0], 2) : "–"});
    }
    text_ << table.text();
  }

  /** \brief Table III. */
  void frameRates() {
    const std::vector<int> cameras = options_.quick ? std::vector<int>{1, 2} : std::vector<int>{1, 2, 4, 6, 8};
    const double paper[] = {80, 68, 55, 0, 42};
    const std::vector<Contender> both = {tables::peers()[0], tables::peers()[1]};
    text_ << "## The paper's table III: frame rate over cameras\n\n640×480 depth and colour, room, structured_light, "
             "full frame. The paper: its "
             "fastest machine, an i7-14900F with an RTX 4090. On GPUs: [notes/gpu.md](notes/gpu.md); on two that "
             "share a frame: [notes/ranks.md](notes/ranks.md#several-gpus).\n\n";
    MarkdownTable table(
        {"cameras", "ours ms", "ms a camera", "frames/s", "VoxelGrid ms", "frames/s", "time, ratio", "paper frames/s"});
    std::vector<drawing::Series> lines = {{"FUSE-Flow", {0}, {0}}, {"concatenate + VoxelGrid", {0}, {0}}};
    for (std::size_t k = 0; k < cameras.size(); ++k) {
      const Setup setup = small({"room", "ring-" + std::to_string(cameras[k]), "structured_light"});
      say("table III: " + setup.name());
      const std::vector<double> ms = tables::frameTimes(setup, both, options_.threads, options_.quick ? 1 : 7);
      for (std::size_t m = 0; m < 2; ++m) {
        lines[m].x.push_back(cameras[k]);
        lines[m].y.push_back(ms[m]);
      }
      table.row({std::to_string(cameras[k]), number(ms[0], 1), number(ms[0] / cameras[k], 1), number(1e3 / ms[0], 1),
                 number(ms[1], 1), number(1e3 / ms[1], 1), number(ms[0] / ms[1], 2),
                 paper[k] > 0 ? number(paper[k], 0) : "–"});
    }
    text_ << table.text();
    addImage("frame_time", "Frame time over cameras", drawing::drawLines({"Frame time", "cameras", "ms"}, lines));
  }

  const Options& options_;
  std::ostringstream text_;
  tables::MeasureRanking ranking_;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Compares FUSE-Flow with its peers on simulated rigs and writes the tables and plots. Needs a display, or "
      "xvfb-run.",
      "fuse_flow_tables");
  app.add_option("-o,--output", options.output, "Markdown file; plots go to the folder images beside it");
  app.add_option("--reading", options.reading, "Markdown file whose text opens the page");
  app.add_option("--measures", options.measures,
                 "Markdown file for what can be said without the truth; without -o this alone is written");
  app.add_option("--surround", options.surround,
                 "Markdown file for cameras that look outward; without -o this alone is written");
  app.add_option("--scale", options.scale,
                 "of the images' sides, (0, 1]: a smaller one is faster, and no longer the tables")
      ->check(CLI::Range(0.1, 1.0))
      ->capture_default_str();
  app.add_flag("--quick", options.quick, "a small part of everything, to see that it works");
  app.add_option("--threads", options.threads, "0: one per core")->check(command_line::threadCount());
  return command_line::runTool(app, argc, argv, [&] {
    options.threads = host::resolveThreads(options.threads);
    if (options.output.empty() && options.measures.empty() && options.surround.empty())
      throw io::OptionError("--output is required; see --help");
    io::InputFiles reading({options.reading});
    for (const auto& [option, file] :
         {std::pair{"-o", options.output}, {"--measures", options.measures}, {"--surround", options.surround}})
      if (!file.empty()) reading.refuseToReplace(option, file);
    if (!options.output.empty()) drawing::requireDisplay("fuse_flow_tables");
    if (!options.surround.empty()) Page(options).writeSurround();
    if (options.output.empty()) {
      if (!options.measures.empty()) Page(options).writeMeasures();
      return command_line::kSuccess;
    }
    Page(options).write();
    return command_line::kSuccess;
  });
}
