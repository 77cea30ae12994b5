#include "evaluation/report.h"

#include "../recordings/io_fixture.h"

#include <algorithm>
#include <cmath>

namespace {

using namespace io_test;
using Json = nlohmann::json;

FrameStatistics statistics(double total_ms) {
  FrameStatistics s;
  s.measured_points = 1000;
  s.gated_points = 800;
  s.fused_points = 200;
  s.preprocess_ms = 0.1 * total_ms;
  s.generate_ms = 0.2 * total_ms;
  s.merge_ms = 0.15 * total_ms;
  s.fuse_ms = 0.5 * total_ms;
  s.output_ms = 0.05 * total_ms;
  s.total_ms = total_ms;
  return s;
}

ReprojectionQuality quality() {
  ReprojectionQuality q;
  q.points = 200;
  q.seen_points = 180;
  q.multi_view_points = 150;
  q.violating_points = 5;
  q.pixels = 1000;
  q.covered_pixels = 980;
  q.error = 0.0125;
  q.multi_view_error = 0.0105;
  return q;
}

SurfaceQuality surface() {
  SurfaceQuality q;
  q.points = 200;
  q.sampled_points = 100;
  q.surface_points = q.judged_points = 80;
  q.double_points = 4;
  q.violating_points = 3;
  q.pixels = 1000;
  q.covered_pixels = 970;
  q.noise_sum = 80 * 0.0021;
  return q;
}

/** \brief The report of frames that took so long. */
Json timed(const std::vector<double>& milliseconds) {
  io::Report report("fuse_flow");
  for (std::size_t i = 0; i < milliseconds.size(); ++i) report.addFrame(i, statistics(milliseconds[i]), std::nullopt);
  return report.json();
}

TEST(Report, AFrameHasItsFigures) {
  FrameStatistics s = statistics(40);
  s.missing_cameras = {1, 3};
  io::Report report("voxel_grid");
  report.addFrame(7, s, quality());
  const Json json = report.json();
  EXPECT_EQ(json["method"], "voxel_grid");
  ASSERT_EQ(json["frames"].size(), 1u);
  const Json& frame = json["frames"][0];
  EXPECT_EQ(frame["frame"], 7);
  EXPECT_EQ(frame["points_in"], 1000);
  EXPECT_EQ(frame["points_gated"], 800);
  EXPECT_EQ(frame["points_out"], 200);
  EXPECT_EQ(frame["missing_cameras"], (Json{1, 3}));
  EXPECT_DOUBLE_EQ(frame["frames_per_second"], 25);
  EXPECT_GT(frame["peak_memory_mib"], 1);
  EXPECT_LE(frame["peak_memory_mib"], json["total"]["peak_memory_mib"]);
  EXPECT_EQ(frame["points"], 200);
  EXPECT_EQ(frame["multi_view_points"], 150);
  EXPECT_DOUBLE_EQ(frame["e_mc_mm"], 12.5);
  EXPECT_DOUBLE_EQ(frame["e_mc_multi_view_mm"], 10.5);
  EXPECT_DOUBLE_EQ(frame["free_space_violations"], 0.025);
  EXPECT_DOUBLE_EQ(frame["coverage"], 0.98);
  const std::vector<std::pair<const char*, double>> stages{{"preprocess", 4}, {"generate", 8}, {"merge", 6},
                                                           {"fuse", 20},      {"output", 2},   {"total", 40}};
  EXPECT_EQ(frame["milliseconds"].size(), stages.size());
  for (const auto& [stage, ms] : stages) EXPECT_DOUBLE_EQ(frame["milliseconds"][stage], ms) << stage;
}

TEST(Report, TheMedianOfAnOddNumberOfFramesIsTheMiddleOne) {
  const Json json = timed({30, 10, 50});
  EXPECT_DOUBLE_EQ(json["total"]["milliseconds"]["total"]["median"], 30);
  EXPECT_DOUBLE_EQ(json["total"]["milliseconds"]["fuse"]["median"], 15);
  EXPECT_DOUBLE_EQ(json["total"]["frames_per_second"], 1000.0 / 30);
}

TEST(Report, TheMedianOfAnEvenNumberOfFramesLiesBetweenTheMiddleTwo) {
  EXPECT_DOUBLE_EQ(timed({40, 10})["total"]["milliseconds"]["total"]["median"], 25);
  EXPECT_DOUBLE_EQ(timed({10, 20, 30, 1000})["total"]["milliseconds"]["total"]["median"], 25);
}

TEST(Report, OneInTwentyFramesTakesLongerThanTheNinetyFifthPercentile) {
  std::vector<double> milliseconds;
  for (int i = 100; i >= 0; --i) milliseconds.push_back(i);
  const Json total = timed(milliseconds)["total"]["milliseconds"]["total"];
  EXPECT_DOUBLE_EQ(total["median"], 50);
  EXPECT_DOUBLE_EQ(total["p95"], 95);
  EXPECT_DOUBLE_EQ(timed({7})["total"]["milliseconds"]["total"]["p95"], 7);
}

TEST(Report, TotalsAreMeansOverTheFrames) {
  io::Report report("fuse_flow");
  FrameStatistics s = statistics(10);
  report.addFrame(0, s, std::nullopt);
  s.measured_points = 3000;
  s.fused_points = 500;
  report.addFrame(1, s, std::nullopt);
  const Json total = report.json()["total"];
  EXPECT_EQ(total["frames"], 2);
  EXPECT_DOUBLE_EQ(total["points_in"], 2000);
  EXPECT_DOUBLE_EQ(total["points_out"], 350);
  EXPECT_GT(total["peak_memory_mib"].get<double>(), 1);
}

TEST(Report, FramesWithoutAFigureDoNotCountInItsMean) {
  io::Report report("fuse_flow");
  ReprojectionQuality one = quality(), none;
  one.error = 0.010;
  none.error = none.multi_view_error = std::nan("");
  report.addFrame(0, statistics(10), one);
  report.addFrame(1, statistics(10), none);          // every camera missed it
  report.addFrame(2, statistics(10), std::nullopt);  // nobody asked
  one.error = 0.020;
  report.addFrame(3, statistics(10), one);
  const Json json = report.json();
  for (const char* figure : {"e_mc_mm", "e_mc_multi_view_mm", "free_space_violations", "coverage"}) {
    EXPECT_TRUE(json["frames"][0][figure].is_number()) << figure;
    EXPECT_TRUE(json["frames"][1][figure].is_null()) << figure;
    EXPECT_TRUE(json["frames"][2][figure].is_null()) << figure;
  }
  EXPECT_DOUBLE_EQ(json["total"]["e_mc_mm"], 15);
  EXPECT_DOUBLE_EQ(json["total"]["coverage"], 0.98);
}

/** \brief 100 points 10 mm off and 300 that are 20 mm off: 17.5 mm, not the 15 mm between the frames. */
TEST(Report, InTheTotalEveryPointAndEveryPixelCountsTheSame) {
  io::Report report("fuse_flow");
  ReprojectionQuality few, many;
  few.points = few.seen_points = 100;
  few.error = 0.010;
  few.pixels = few.covered_pixels = 1000;
  many.points = many.seen_points = many.violating_points = 300;
  many.error = 0.020;
  many.pixels = 3000;
  report.addFrame(0, statistics(10), few);
  report.addFrame(1, statistics(10), many);
  const Json total = report.json()["total"];
  EXPECT_DOUBLE_EQ(total["e_mc_mm"], 17.5);
  EXPECT_DOUBLE_EQ(total["free_space_violations"], 0.75);
  EXPECT_DOUBLE_EQ(total["coverage"], 0.25);
  EXPECT_TRUE(total["e_mc_multi_view_mm"].is_null());
}

TEST(Report, WithoutFramesThereIsNothingToMeasure) {
  const Json json = io::Report("fuse_flow").json();
  EXPECT_EQ(json["total"]["frames"], 0);
  EXPECT_TRUE(json["frames"].is_array());
  EXPECT_TRUE(json["frames"].empty());
  EXPECT_TRUE(json["total"]["frames_per_second"].is_null());
  EXPECT_TRUE(json["total"]["e_mc_mm"].is_null());
  EXPECT_TRUE(json["total"]["milliseconds"]["total"]["median"].is_null());
  EXPECT_NO_THROW(json.dump());
}

TEST(Report, TheSummarySaysWhatTheTotalsSay) {
  io::Report report("fuse_flow");
  report.addFrame(0, statistics(40), quality());
  const std::string text = report.summary();
  for (const char* words :
       {"fuse_flow: 1 frames, 25.0 frames per second (median 40.0 ms, p95 40.0 ms)", "1000 points in, 200 out a frame",
        "  against what was measured, noise and all: E_MC 12.50 mm", "over points with two or more views 10.50 mm",
        "free-space violations 2.50 %", "coverage 98.00 %", "peak memory"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " is not in " << text;
}

TEST(Report, WhatIsSaidOfTheSurfaceLeads) {
  io::Report report("fuse_flow");
  SurfaceQuality later = surface();
  later.flicker = {10, 10 * 0.0015};
  report.addFrame(0, statistics(40), quality(), surface());
  report.addFrame(1, statistics(40), quality(), later);
  report.addFrame(2, statistics(40), std::nullopt);
  const Json json = report.json();
  EXPECT_DOUBLE_EQ(json["frames"][0]["surface_noise_mm"], 2.1);
  EXPECT_DOUBLE_EQ(json["frames"][0]["double_surfaces"], 0.05);
  EXPECT_DOUBLE_EQ(json["frames"][0]["free_space_violations_off_silhouettes"], 0.015);
  EXPECT_DOUBLE_EQ(json["frames"][0]["coverage_within_noise"], 0.97);
  EXPECT_TRUE(json["frames"][0]["flicker_mm"].is_null());
  EXPECT_DOUBLE_EQ(json["frames"][1]["flicker_mm"], 1.5);
  EXPECT_TRUE(json["frames"][2]["surface_noise_mm"].is_null());
  EXPECT_DOUBLE_EQ(json["total"]["surface_noise_mm"], 2.1);
  EXPECT_DOUBLE_EQ(json["total"]["flicker_mm"], 1.5);
  const std::string text = report.summary();
  const auto at = text.find(
      "\n  violations off silhouettes 1.50 %, flicker 1.50 mm, double surfaces 5.00 %, noise of the surface 2.10 mm, "
      "coverage within the sensor's noise 97.00 %\n");
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_LT(at, text.find("E_MC"));
}

TEST(Report, TheTableOfTheSurfaceHasItsColumnsUnderTheirHeadings) {
  const std::string header = io::surfaceHeader(12), row = io::surfaceRow("a.ply", 12, surface());
  EXPECT_EQ(header.size(), row.size());
  for (const auto& [heading, value] :
       std::vector<std::pair<std::string, std::string>>{{"points", "200"},
                                                        {"noise [mm]", "2.10"},
                                                        {"double surfaces [%]", "5.00"},
                                                        {"violations off silhouettes [%]", "1.50"},
                                                        {"coverage within noise [%]", "97.00"},
                                                        {"flicker [mm]", "-"}}) {
    const std::size_t end = header.find(heading) + heading.size();
    ASSERT_LE(end, row.size()) << heading;
    EXPECT_EQ(row.substr(end - value.size(), value.size()), value) << heading;
  }
}

TEST(Report, TheSummaryNamesTheCamerasThatMissedFrames) {
  io::Report report("fuse_flow", {"left", "middle", "right"});
  FrameStatistics s = statistics(40);
  report.addFrame(0, s, std::nullopt);
  EXPECT_EQ(report.summary().find("missed"), std::string::npos);
  s.missing_cameras = {2};
  report.addFrame(1, s, std::nullopt);
  s.missing_cameras = {0, 2};
  report.addFrame(2, s, std::nullopt);
  const std::string text = report.summary();
  for (const char* line : {"\n  camera left missed 1 of 3 frames\n", "\n  camera right missed 2 of 3 frames\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << " is not in " << text;
  EXPECT_EQ(text.find("middle"), std::string::npos) << text;
}

TEST(Report, TheSummaryLeavesOutWhatWasNotMeasured) {
  io::Report report("fuse_flow");
  report.addFrame(0, statistics(40), std::nullopt);
  EXPECT_EQ(report.summary().find("E_MC"), std::string::npos);
  EXPECT_EQ(report.summary().find("nan"), std::string::npos);
}

TEST(Report, TheTableHasItsColumnsUnderTheirHeadings) {
  const std::string header = io::qualityHeader(12), row = io::qualityRow("a.ply", 12, quality());
  EXPECT_EQ(header.size(), row.size());
  for (const auto& [heading, value] : std::vector<std::pair<std::string, std::string>>{{"points", "200"},
                                                                                       {"E_MC [mm]", "12.50"},
                                                                                       {"2+ views [mm]", "10.50"},
                                                                                       {"violations [%]", "2.50"},
                                                                                       {"coverage [%]", "98.00"}}) {
    const std::size_t end = header.find(heading) + heading.size();
    ASSERT_LE(end, row.size()) << heading;
    EXPECT_EQ(row.substr(end - value.size(), value.size()), value) << heading;
  }
}

TEST(Report, TheTableHasADashWhereThereWasNothingToMeasure) {
  const std::string header = io::qualityHeader(12),
                    row = io::qualityRow("empty.ply", 12, io::QualityOfSequence().result());
  EXPECT_EQ(header.size(), row.size());
  EXPECT_EQ(std::count(row.begin(), row.end(), '-'), 4) << row;
  EXPECT_EQ(row.find("nan"), std::string::npos) << row;
}

}  // namespace
