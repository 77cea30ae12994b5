#include "support/cloud_file.h"
#include "support/tool_fixture.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace tool_test {
namespace {

const std::vector<std::string> kMethods{"fuse_flow", "concatenate", "voxel_grid", "approximate_voxel_grid",
                                        "outlier_removal"};
constexpr const char* kStages[] = {"preprocess", "generate", "merge", "fuse", "output", "total"};

class Results : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    wall_.cameras = 3;
    wall_.frames = 3;
    wall_.write(recording_);
  }
  nlohmann::json reportOf(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{recording(), "-o", out(), "--report", out("report.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolResult result = fuse(arguments);
    EXPECT_TRUE(succeeded(result));
    return nlohmann::json::parse(readText(out("report.json")));
  }
  WallRecording wall_;
};

TEST_F(Results, EveryMethodFindsTheWall) {
  for (const std::string& method : kMethods) {
    const nlohmann::json report = reportOf({"--method", method});
    EXPECT_EQ(report["method"], method);
    for (std::size_t frame = 0; frame < wall_.frames; ++frame) {
      const std::vector<FilePoint> points = readCloudFile(out_ / ("00000" + std::to_string(frame) + ".ply"));
      ASSERT_FALSE(points.empty()) << method;
      EXPECT_EQ(report["frames"][frame]["points_out"], points.size()) << method;
      for (const FilePoint& p : points) {
        ASSERT_NEAR(p.z, WallRecording::wallDistance(frame), 1e-3) << method;
        ASSERT_NEAR(p.r, 200, 1) << method;
        ASSERT_NEAR(p.g, 100, 1) << method;
        ASSERT_NEAR(p.b, 50, 1) << method;
        ASSERT_GT(p.confidence, 0) << method;
        ASSERT_LE(p.confidence, 1) << method;
        ASSERT_GE(p.view_count, 1u) << method;
        ASSERT_LE(p.view_count, wall_.cameras) << method;
      }
    }
  }
}

TEST_F(Results, ConcatenateKeepsEveryPoint) {
  const nlohmann::json report = reportOf({"--method", "concatenate"});
  EXPECT_EQ(readCloudFile(out_ / "000000.ply").size(), 3u * 32 * 24);
  EXPECT_EQ(report["total"]["points_in"], report["total"]["points_out"]);
}

TEST_F(Results, TheLeafSizeIsThatOfTheGrid) {
  // 32 columns 1/16 m apart, and two more cameras 0.1 m to the side, see 2.2 m by 1.5 m of the wall.
  reportOf({"--method", "voxel_grid", "--leaf-size", "0.5"});
  EXPECT_LE(readCloudFile(out_ / "000000.ply").size(), 6u * 4u);
  EXPECT_GE(readCloudFile(out_ / "000000.ply").size(), 4u * 3u);
}

/** \brief Everything that a report promises, in its unit, for every method. */
TEST_F(Results, TheReportHoldsFramesAndTotals) {
  for (const std::string& method : kMethods) {
    const nlohmann::json report = reportOf({"--method", method});
    ASSERT_EQ(report["frames"].size(), wall_.frames) << method;
    double points_in = 0, coverage = 0;
    for (std::size_t frame = 0; frame < wall_.frames; ++frame) {
      const nlohmann::json& entry = report["frames"][frame];
      EXPECT_EQ(entry["frame"], frame);
      EXPECT_EQ(entry["points_in"], 3 * 32 * 24) << method;
      EXPECT_LE(entry["points_gated"], entry["points_in"]) << method;
      EXPECT_GT(entry["points_out"], 0) << method;
      EXPECT_EQ(entry["points"], entry["points_out"]) << method;
      EXPECT_LE(entry["multi_view_points"], entry["points"]) << method;
      EXPECT_EQ(entry["missing_cameras"], nlohmann::json::array()) << method;
      // The wall is exact: what is left is rounding, in millimetres.
      EXPECT_GE(entry["e_mc_mm"], 0) << method;
      EXPECT_LT(entry["e_mc_mm"], 1.0) << method;
      EXPECT_LT(entry["e_mc_multi_view_mm"], 1.0) << method;
      EXPECT_EQ(entry["free_space_violations"], 0) << method;
      EXPECT_GE(entry["coverage"], 0) << method;
      EXPECT_LE(entry["coverage"], 1) << method;
      for (const char* stage : kStages) ASSERT_GE(entry["milliseconds"][stage], 0) << method << " " << stage;
      EXPECT_GT(entry["milliseconds"]["total"], 0) << method;
      for (const char* stage : kStages)
        EXPECT_LE(entry["milliseconds"][stage], entry["milliseconds"]["total"]) << method << " " << stage;
      for (const char* stage : {"generate", "fuse", "output"})  // what every method does
        EXPECT_GT(entry["milliseconds"][stage], 0) << method << " " << stage;
      EXPECT_GT(entry["frames_per_second"], 0) << method;
      EXPECT_GT(entry["peak_memory_mib"], 1) << method;
      points_in += entry["points_in"].get<double>() / 3;
      coverage += entry["coverage"].get<double>() / 3;
    }
    const nlohmann::json& total = report["total"];
    EXPECT_EQ(total["frames"], wall_.frames);
    EXPECT_DOUBLE_EQ(total["points_in"], points_in) << method;
    EXPECT_NEAR(total["coverage"], coverage, 1e-9) << method;
    EXPECT_EQ(total["free_space_violations"], 0) << method;
    for (const char* stage : kStages) {
      const nlohmann::json& milliseconds = total["milliseconds"][stage];
      ASSERT_TRUE(milliseconds["median"].is_number()) << stage;
      EXPECT_LE(milliseconds["median"], milliseconds["p95"]) << method << " " << stage;
    }
    EXPECT_NEAR(total["frames_per_second"].get<double>() * total["milliseconds"]["total"]["median"].get<double>(), 1000,
                1e-6)
        << method;
    EXPECT_GT(total["peak_memory_mib"], 1) << method;
    EXPECT_LT(total["peak_memory_mib"], 65536) << method;
  }
}

TEST_F(Results, TheSummaryIsTheReportInWords) {
  const ToolResult result = fuse({recording(), "-o", out(), "--report", out("report.json")});
  ASSERT_TRUE(succeeded(result));
  for (const char* word : {"fuse_flow: 3 frames", "frames per second", "median", "p95", "points in", "E_MC", "coverage",
                           "free-space violations", "peak memory"})
    EXPECT_NE(result.out.find(word), std::string::npos) << word;
  EXPECT_EQ(result.out.find("nan"), std::string::npos) << result.out;
}

TEST_F(Results, AnyNumberOfThreadsGivesTheSameBytes) {
  for (const std::string& method : kMethods) {
    ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("one"), "--method", method, "--threads", "1"})));
    for (const char* threads : {"2", "7"}) {
      ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("more"), "--method", method, "--threads", threads})));
      ASSERT_EQ(listing(folder_ / "more").size(), wall_.frames);
      for (const std::string& name : listing(folder_ / "more"))
        EXPECT_EQ(readText(folder_ / "one" / name), readText(folder_ / "more" / name)) << method << " " << name;
    }
  }
}

TEST_F(Results, PlyAndPcdHoldTheSamePoints) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("cloud.ply"), "--frames", "1"})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("cloud.pcd"), "--frames", "1"})));
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("folder"), "--frames", "1", "--format", "pcd"})));
  const std::vector<FilePoint> ply = readCloudFile(out("cloud.ply")), pcd = readCloudFile(out("cloud.pcd"));
  ASSERT_FALSE(ply.empty());
  EXPECT_TRUE(ply == pcd);
  EXPECT_EQ(readText(out("cloud.pcd")), readText(out("folder/000001.pcd")));
}

/** \brief The cameras look along +z at the wall, whose normal faces them. */
TEST_F(Results, NormalsAreWrittenWhereTheyAreAskedFor) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("plain.ply"), "--frames", "0"})));
  EXPECT_EQ(readText(out("plain.ply")).find("property float nx"), std::string::npos);
  const std::vector<FilePoint> plain = readCloudFile(out("plain.ply"));
  for (const char* name : {"normals.ply", "normals.pcd"}) {
    ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(name), "--frames", "0", "--normals"}))) << name;
    const std::vector<FilePoint> points = readCloudFile(out(name));
    ASSERT_EQ(points.size(), plain.size()) << name;
    std::size_t with_normal = 0;  // rims of images have none
    for (std::size_t i = 0; i < points.size(); ++i) {
      FilePoint p = points[i];
      if (p.nz != 0) {
        ++with_normal;
        ASSERT_NEAR(p.nz, -1, 1e-3) << name;
      }
      p.nx = p.ny = p.nz = 0;
      ASSERT_TRUE(p == plain[i]) << name;
    }
    EXPECT_GT(with_normal, points.size() / 2) << name;
  }
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out("peer.ply"), "--normals", "--method", "voxel_grid"}), 2,
                             {"--normals", "voxel_grid"}));
}

/** \brief That points of the wall have the bits of cameras in whose images they are, and of no other, and that each camera has some. \param all_asked
 *  the rig has so few cameras that each is asked (--max-views): then all of these bits are there; in the outermost columns, whose neighbourhoods
 *  are cut, either may be */
void expectMasks(const std::vector<FilePoint>& points, const WallRecording& wall, bool all_asked) {
  ASSERT_FALSE(points.empty());
  std::set<std::size_t> seen;
  for (const FilePoint& p : points) {
    std::size_t bits = 0, without_bit = 0;
    for (std::size_t k = 0; k < wall.cameras; ++k) {
      const double u = wall.width * (p.x - 0.1 * static_cast<double>(k)) / p.z + (wall.width - 1) / 2.0;
      const bool inside = u > 1 && u < wall.width - 2, outside = u < -0.5 || u > wall.width - 0.5;
      if (k >= 64) {
        without_bit += outside ? 0 : 1;
        continue;
      }
      const bool bit = (p.camera_mask[k / 32] >> k % 32 & 1u) != 0;
      if (outside) {
        ASSERT_FALSE(bit) << "camera " << k << ", column " << u;
      }
      if (inside && all_asked) {
        ASSERT_TRUE(bit) << "camera " << k << ", column " << u;
      }
      bits += bit ? 1 : 0;
      if (bit) seen.insert(k);
    }
    ASSERT_GE(p.view_count, bits);
    ASSERT_LE(p.view_count, bits + without_bit);
  }
  EXPECT_EQ(seen.size(), std::min<std::size_t>(wall.cameras, 64));
}

/** \brief Camera 0 is the leftmost of three, camera 2 the rightmost. */
TEST_F(Results, CamerasOfAPointAreWrittenWhereTheyAreAskedFor) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("plain.ply"), "--frames", "0"})));
  const std::vector<FilePoint> plain = readCloudFile(out("plain.ply"));
  const auto further_right = [](const FilePoint& a, const FilePoint& b) { return a.x < b.x; };
  for (const char* name : {"mask.ply", "mask.pcd"}) {
    ASSERT_TRUE(succeeded(fuse({recording(), "-o", out(name), "--frames", "0", "--camera-mask"}))) << name;
    const std::vector<FilePoint> points = readCloudFile(out(name));
    ASSERT_EQ(points.size(), plain.size()) << name;
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_TRUE(points[i] == plain[i]) << name;
    }
    expectMasks(points, wall_, true);
    EXPECT_EQ(std::min_element(points.begin(), points.end(), further_right)->camera_mask[0], 1u) << name;
    EXPECT_EQ(std::max_element(points.begin(), points.end(), further_right)->camera_mask[0], 4u) << name;
  }
  EXPECT_NE(readText(out("mask.pcd")).find("view_count camera_mask\n"), std::string::npos);
  const std::string ply = readText(out("mask.ply"));
  EXPECT_NE(ply.find("view_count\nproperty uint camera_mask_0\nproperty uint camera_mask_1\nend_header\n"),
            std::string::npos);
  EXPECT_EQ(ply.find("property float nx"), std::string::npos);
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("normals.ply"), "--frames", "0", "--normals"})));
  EXPECT_EQ(readText(out("normals.ply")).find("camera_mask"), std::string::npos);
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("both.ply"), "--frames", "0", "--normals", "--camera-mask"})));
  EXPECT_NE(readText(out("both.ply")).find("property float nx"), std::string::npos);
  EXPECT_TRUE(isOneLineError(fuse({recording(), "-o", out("peer.ply"), "--camera-mask", "--method", "voxel_grid"}), 2,
                             {"--camera-mask", "voxel_grid"}));
  // The files of one scanner each, fused as clouds.
  for (const char* camera : {"0", "1"})
    ASSERT_TRUE(succeeded(
        fuse({recording(), "-o", out(std::string("scanner_") + camera + ".ply"), "--frames", "0", "--views", camera})));
  ASSERT_TRUE(succeeded(fuse({out("scanner_0.ply"), out("scanner_1.ply"), "-o", out("again.pcd"), "--camera-mask"})));
  const std::vector<FilePoint> again = readCloudFile(out("again.pcd"));
  EXPECT_EQ(std::min_element(again.begin(), again.end(), further_right)->camera_mask[0], 1u);
  EXPECT_EQ(std::max_element(again.begin(), again.end(), further_right)->camera_mask[0], 2u);
}

TEST_F(Results, CamerasFromThe65thOnHaveNoBitAndItIsSaid) {
  wall_.cameras = 66;
  wall_.frames = 1;
  wall_.write(folder_ / "many");
  const ToolResult result = fuse({out("many"), "-o", out("many.pcd"), "--camera-mask"});
  ASSERT_TRUE(succeeded(result));
  EXPECT_NE(result.err.find("has bits for 64 cameras, and there are 66"), std::string::npos) << result.err;
  expectMasks(readCloudFile(out("many.pcd")), wall_, false);
  const ToolResult fewer = fuse({out("many"), "-o", out("fewer.pcd"), "--camera-mask", "--views", "0:64:1"});
  EXPECT_EQ(fewer.err.find("has bits"), std::string::npos) << fewer.err;
}

TEST_F(Results, TheCropBoxBoundsTheCloud) {
  for (const std::string& method : kMethods) {
    ASSERT_TRUE(succeeded(fuse({recording(), "-o", out("crop.ply"), "--frames", "0", "--method", method, "--crop-box",
                                "0", "-0.2", "0", "0.5", "0.3", "5"})));
    const std::vector<FilePoint> points = readCloudFile(out("crop.ply"));
    ASSERT_FALSE(points.empty()) << method;
    for (const FilePoint& p : points) {
      EXPECT_GE(p.x, 0) << method;
      EXPECT_LE(p.x, 0.5) << method;
      EXPECT_GE(p.y, -0.2f) << method;
      EXPECT_LE(p.y, 0.3f) << method;
    }
  }
}

/** \brief The same cloud, in memory and read back: every figure to the last digit. */
TEST_F(Results, EvaluateFindsTheFiguresOfTheReport) {
  for (const std::string& method : kMethods) {
    for (const char* format : {"ply", "pcd"}) {
      const nlohmann::json report = reportOf({"--method", method, "--format", format});
      for (std::size_t frame = 0; frame < wall_.frames; frame += timesOver(1, 100)) {
        const std::string cloud = out("out/00000" + std::to_string(frame) + "." + format);
        const ToolResult result =
            evaluate({recording(), cloud, "--frame", std::to_string(frame), "--json", out("figures.json")});
        ASSERT_TRUE(succeeded(result));
        const nlohmann::json figures = nlohmann::json::parse(readText(out("figures.json")));
        for (const char* key :
             {"points", "multi_view_points", "e_mc_mm", "e_mc_multi_view_mm", "free_space_violations", "coverage"})
          EXPECT_EQ(figures[cloud][key], report["frames"][frame][key]) << method << " " << key;
      }
    }
  }
}

TEST_F(Results, EvaluateFindsTheTotalsOfTheReport) {
  fs::remove(depthFile(recording_, 0, 0));  // the frames have different numbers of points
  for (std::size_t k = 0; k < wall_.cameras; ++k) fs::remove(depthFile(recording_, k, 1));
  for (const char* format : {"ply", "pcd"}) {
    const nlohmann::json report = reportOf({"--format", format});
    const ToolResult result = evaluate({recording(), out(), "--json", out("figures.json")});
    ASSERT_TRUE(succeeded(result)) << format;
    const nlohmann::json figures = nlohmann::json::parse(readText(out("figures.json")))[out()];
    for (const char* key : {"e_mc_mm", "e_mc_multi_view_mm", "free_space_violations", "coverage"}) {
      EXPECT_TRUE(figures[key].is_number()) << key;
      EXPECT_EQ(figures[key], report["total"][key]) << key;
    }
    ASSERT_EQ(figures["frames"].size(), 2u);  // no camera has the one between them
    EXPECT_EQ(figures["frames"][1]["frame"], 2);
    fs::remove_all(out_);
  }
}

/** \brief A wall at z = 2 m as two cameras see it that stand 0.1 m apart; and as many points on the wall. */
TEST_F(Results, EvaluateReadsARecordingOfSeveralPcdFiles) {
  ASSERT_TRUE(succeeded(runProgram(FUSE_FLOW_EXPORT_TOOL, {recording(), "-o", out("pcd")})));
  std::vector<std::string> views;
  for (const char* camera : {"pcd/camera_0", "pcd/camera_1"})
    views.push_back((fs::path(out(camera)) / listing(out(camera)).at(0)).string());
  ASSERT_TRUE(succeeded(fuse({views[0], views[1], "-o", out("cloud.pcd"), "--report", out("report.json")})));
  ASSERT_TRUE(
      succeeded(evaluate({out("cloud.pcd"), "--recording", views[0], views[1], "--json", out("figures.json")})));
  const nlohmann::json figures = nlohmann::json::parse(readText(out("figures.json")));
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_GT(figures[out("cloud.pcd")]["multi_view_points"], 0);
  EXPECT_EQ(figures[out("cloud.pcd")]["coverage"],
            nlohmann::json::parse(readText(out("report.json")))["frames"][0]["coverage"]);
  // Which of these would be cameras, and which a cloud?
  EXPECT_TRUE(isOneLineError(evaluate({views[0], views[1], out("cloud.pcd")}), 2, {views[0], "--recording"}));
}

/** \brief Pixels are 62 mm apart: points cover few of them within 15 mm, and all within a metre. */
TEST_F(Results, TheReportMeasuresWithTheQualityOptions) {
  // Without --gate-noise 0, the corners of the images pass the gate, too.
  const nlohmann::json all = reportOf({"--frames", "0", "--gate-noise", "0"}),
                       some = reportOf({"--frames", "0", "--coverage-step", "4", "--coverage-radius", "1"});
  EXPECT_LT(all["total"]["coverage"], 1);
  EXPECT_EQ(some["total"]["coverage"], 1);
  ASSERT_TRUE(succeeded(evaluate({recording(), out("out/000000.ply"), "--coverage-step", "4", "--coverage-radius", "1",
                                  "--json", out("figures.json")})));
  EXPECT_EQ(nlohmann::json::parse(readText(out("figures.json")))[out("out/000000.ply")]["coverage"], 1);
}

TEST_F(Results, EvaluatePrintsARowForEachCloud) {
  ASSERT_TRUE(succeeded(fuse({recording(), "-o", out()})));
  const ToolResult result = evaluate({recording(), out("out/000000.ply"), out("out/000001.ply")});
  ASSERT_TRUE(succeeded(result));
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 10);
  EXPECT_LT(result.out.find("noise [mm]"), result.out.find("E_MC [mm]"));
  for (const char* word : {"double surfaces", "flicker", "No truth is known here", "E_MC", "violations", "coverage",
                           "000000.ply", "000001.ply"})
    EXPECT_NE(result.out.find(word), std::string::npos) << word;
}

/** \brief A cloud 20 mm behind the wall is 20 mm from every view that sees it; 0.5 m in front, it floats in free space. */
TEST_F(Results, EvaluateMeasuresKnownErrors) {
  const auto wallAt = [&](const std::string& name, double z) {
    std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for (int i = 0; i < 9; ++i)
      ply +=
          std::to_string(0.1 + 0.05 * (i % 3)) + " " + std::to_string(0.05 * (i / 3)) + " " + std::to_string(z) + "\n";
    writeText(folder_ / name, ply);
  };
  wallAt("behind.ply", 2.02);
  wallAt("in_front.ply", 1.5);
  ASSERT_TRUE(
      succeeded(evaluate({recording(), out("behind.ply"), out("in_front.ply"), "--json", out("figures.json")})));
  const nlohmann::json figures = nlohmann::json::parse(readText(out("figures.json")));
  EXPECT_NEAR(figures[out("behind.ply")]["e_mc_mm"], 20, 0.01);
  EXPECT_NEAR(figures[out("behind.ply")]["e_mc_multi_view_mm"], 20, 0.01);
  EXPECT_EQ(figures[out("behind.ply")]["free_space_violations"], 0);
  EXPECT_EQ(figures[out("behind.ply")]["multi_view_points"], 9);
  EXPECT_EQ(figures[out("in_front.ply")]["free_space_violations"], 1);
  EXPECT_TRUE(figures[out("in_front.ply")]["e_mc_mm"].is_null());
  EXPECT_EQ(figures[out("in_front.ply")]["coverage"], 0);
}

TEST_F(Results, ProgressIsForATerminalOnly) {
  if (!terminalsAtHand()) GTEST_SKIP() << "no pseudo-terminals: /dev/pts is not mounted";
  RunOptions terminal;
  terminal.terminal = true;
  const ToolResult shown = fuse({recording(), "-o", out()}, terminal);
  EXPECT_EQ(shown.exit_code, 0);
  for (const char* words : {"1 of 3 frames", "2 of 3 frames", "3 of 3 frames", "frames/s", "s left"})
    EXPECT_NE(shown.err.find(words), std::string::npos) << words << " is not in '" << shown.err << "'";
  EXPECT_TRUE(succeeded(fuse({recording(), "-o", out()})));
}

TEST_F(Results, AfterProgressAnErrorHasALineOfItsOwn) {
  if (!terminalsAtHand()) GTEST_SKIP() << "no pseudo-terminals: /dev/pts is not mounted";
  writeText(depthFile(recording_, 0, 1), "");
  RunOptions terminal;
  terminal.terminal = true;
  const ToolResult result = fuse({recording(), "-o", out()}, terminal);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("\nfuse_flow_fuse: "), std::string::npos) << result.err;
}

}  // namespace
}  // namespace tool_test
