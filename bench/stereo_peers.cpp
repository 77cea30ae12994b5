// Stereo of a rectified pair: MultiViewStereo beside OpenCV's semi-global matching and PCL's adaptive costs with scanline optimisation, on
// simulated pairs whose true depth is known. The table of doc/notes/stereo.md. fuse_flow_stereo_peers_bench [SCALE]

#include "simulation/simulator.h"

#include <fuse_flow/stereo/multi_view_stereo.h>

#include <pcl/stereo/stereo_matching.h>

#include <opencv2/calib3d.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow;
using Clock = std::chrono::steady_clock;

/** \brief Depth of the first image, metres, row by row; 0: none. */
using Depth = std::vector<float>;

/** \brief Two images of one instant, and the true depth of the first. */
struct Pair {
  io::LoadedFrame frame;
  Depth truth;
  int width{0}, height{0};
  float baseline{0};     ///< metres
  float focal{0};        ///< pixels
  int max_disparity{0};  ///< of what is nearest; a multiple of 16

  const ImageView<Rgb8>& image(std::size_t k) const { return frame.rig.views[k].color; }
  float depthOf(float disparity) const { return disparity > 0 ? focal * baseline / disparity : 0.0f; }
};

Pair makePair(const std::string& scene, double scale, bool with_errors) {
  simulation::SimulationOptions options;
  options.scene = scene;
  options.rig = "row-2";
  options.sensor = "ideal";
  options.scale = scale;
  if (with_errors) {
    options.faults.image.noise = 3;
    options.faults.image.exposure = 0.15;
    options.faults.image.vignetting = 0.3;
  }
  simulation::Simulator simulator(options);
  Pair pair;
  simulator.measure(0, pair.frame);
  const Camera& first = pair.frame.rig.cameras[0];
  if (first.color) throw std::runtime_error("the colour camera stands beside: the true depth is not that of its image");
  const DepthView& view = pair.frame.rig.views[0];
  pair.width = first.intrinsics.width;
  pair.height = first.intrinsics.height;
  pair.focal = first.intrinsics.fx;
  pair.baseline = static_cast<float>(
      (pair.frame.rig.cameras[1].T_world_camera.translation() - first.T_world_camera.translation()).norm());
  float nearest = 1e9f;
  for (int v = 0; v < pair.height; ++v)
    for (int u = 0; u < pair.width; ++u) {
      const float z =
          view.depth16 ? static_cast<float>(view.depth16.row(v)[u]) * first.depth_scale : view.depth32.row(v)[u];
      pair.truth.push_back(z);
      if (z > 0) nearest = std::min(nearest, z);
    }
  pair.max_disparity = 16 * static_cast<int>(std::ceil((pair.focal * pair.baseline / nearest + 2) / 16));
  return pair;
}

/** \brief \param confident what is confident alone, or all that was found */
Depth ours(const Pair& pair, bool confident) {
  RigFrame frame = pair.frame.rig;
  for (DepthView& view : frame.views) view.depth16 = {}, view.depth32 = {};
  MultiViewStereo<> stereo;
  stereo.setNumberOfThreads(2);
  StereoFrame found;
  stereo.estimate(frame, found);
  Depth depth = found.views[0].depth;
  for (std::size_t k = 0; confident && k < depth.size(); ++k)
    if (!(found.views[0].confidence[k] > 0.5f)) depth[k] = 0;
  return depth;
}

cv::Mat greyOf(const ImageView<Rgb8>& image) {
  cv::Mat grey(image.height, image.width, CV_8U);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const Rgb8& p = image.row(v)[u];
      grey.at<unsigned char>(v, u) = static_cast<unsigned char>((299 * p.r + 587 * p.g + 114 * p.b + 500) / 1000);
    }
  return grey;
}

/** \brief As OpenCV's example sets it, with all eight paths. */
Depth semiGlobal(const Pair& pair, int mode) {
  constexpr int block = 5;
  const auto matcher = cv::StereoSGBM::create(0, pair.max_disparity, block, 8 * block * block, 32 * block * block, 1,
                                              63, 10, 100, 32, mode);
  cv::Mat disparity;
  matcher->compute(greyOf(pair.image(0)), greyOf(pair.image(1)), disparity);
  Depth depth;
  for (int v = 0; v < pair.height; ++v)
    for (int u = 0; u < pair.width; ++u)
      depth.push_back(pair.depthOf(static_cast<float>(disparity.at<short>(v, u)) / 16.0f));
  return depth;
}

pcl::PointCloud<pcl::RGB> cloudOf(const ImageView<Rgb8>& image) {
  pcl::PointCloud<pcl::RGB> cloud(static_cast<std::uint32_t>(image.width), static_cast<std::uint32_t>(image.height));
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const Rgb8& p = image.row(v)[u];
      cloud(u, v) = pcl::RGB(p.r, p.g, p.b);
    }
  return cloud;
}

/** \brief As PCL's example sets it, but for the ratio filter, with which PCL 1.13 reads what is not its own, and ends. */
Depth adaptiveCost(const Pair& pair) {
  pcl::AdaptiveCostSOStereoMatching matcher;
  matcher.setMaxDisparity(pair.max_disparity);
  matcher.setXOffset(0);
  matcher.setRadius(5);
  matcher.setSmoothWeak(20);
  matcher.setSmoothStrong(100);
  matcher.setGammaC(25);
  matcher.setGammaS(10);
  matcher.setRatioFilter(0);
  matcher.setPeakFilter(0);
  matcher.setLeftRightCheck(true);
  matcher.setLeftRightCheckThreshold(1);
  matcher.setPreProcessing(true);
  pcl::PointCloud<pcl::RGB> left = cloudOf(pair.image(0)), right = cloudOf(pair.image(1));
  matcher.compute(left, right);
  const pcl::PointCloud<pcl::PointXYZ>::Ptr points(new pcl::PointCloud<pcl::PointXYZ>);
  const Intrinsics& K = pair.frame.rig.cameras[0].intrinsics;
  matcher.getPointCloud(K.cx, K.cy, pair.focal, pair.baseline, points);
  Depth depth;
  for (const pcl::PointXYZ& point : *points) depth.push_back(std::isfinite(point.z) ? point.z : 0.0f);
  return depth;
}

void print(const std::string& scene, const char* method, const Pair& pair, const std::function<Depth()>& match) {
  const auto start = Clock::now();
  const Depth found = match();
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  std::vector<float> errors;  // of the disparity, pixels
  double all = 0, near = 0, exact = 0, right = 0, far = 0;
  for (std::size_t k = 0; k < pair.truth.size(); ++k) {
    if (!(pair.truth[k] > 0)) continue;
    ++all;
    if (!(found[k] > 0)) continue;
    errors.push_back(pair.focal * pair.baseline * std::abs(1 / found[k] - 1 / pair.truth[k]));
    near += std::abs(found[k] - pair.truth[k]) < 0.01f ? 1 : 0;
    exact += errors.back() <= 0.5f ? 1 : 0;
    right += errors.back() <= 1 ? 1 : 0;
    far += errors.back() > 2 ? 1 : 0;
  }
  if (errors.empty()) throw std::runtime_error(std::string(method) + " found nothing");
  const auto count = static_cast<double>(errors.size());
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  std::printf("| %s | %s | %.1f | %.1f | %.1f | %.1f | %.2f | %.1f | %.2f |\n", scene.c_str(), method,
              100 * exact / all, 100 * right / all, 100 * near / all, 100 * count / all,
              static_cast<double>(errors[errors.size() / 2]), 100 * far / count, seconds);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const double scale = argc > 1 ? std::atof(argv[1]) : 1;
  cv::setNumThreads(2);
  std::printf(
      "| scene | method | of all: within 0.5 pixels, %% | within 1, %% | within 10 mm, %% | found, %% | of these: "
      "median, "
      "pixels | over 2, %% | s |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const bool with_errors : {false, true})
    for (const std::string scene : {"table", "person", "room"}) {
      const Pair pair = makePair(scene, scale, with_errors);
      const std::string name = scene + (with_errors ? ", errors of the images" : "");
      print(name, "MultiViewStereo, all", pair, [&] { return ours(pair, false); });
      print(name, "MultiViewStereo, confident", pair, [&] { return ours(pair, true); });
      print(name, "OpenCV, SGBM, eight paths", pair, [&] { return semiGlobal(pair, cv::StereoSGBM::MODE_HH); });
      print(name, "OpenCV, SGBM, three paths", pair, [&] { return semiGlobal(pair, cv::StereoSGBM::MODE_SGBM_3WAY); });
      print(name, "PCL, AdaptiveCostSO", pair, [&] { return adaptiveCost(pair); });
    }
}
