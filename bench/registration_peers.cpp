#include "registration_peers.h"

#include <fuse_flow/impl/sensors/frame_views.hpp>

#include <pcl/common/transforms.h>
#include <pcl/features/fpfh_omp.h>
#include <pcl/features/normal_3d_omp.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/lum.h>
#include <pcl/registration/sample_consensus_prerejective.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>

namespace bench {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Clock = std::chrono::steady_clock;
using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

double since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/** \brief Each view's points in its camera's frame, thinned. */
std::vector<Cloud::Ptr> thinned(const fuse_flow::RigFrame& frame, float leaf) {
  fuse_flow::host::FrameViews views;
  views.assign(frame, {}, fuse_flow::host::resolveThreads(0));
  std::vector<Cloud::Ptr> clouds;
  for (std::size_t i = 0; i < frame.views.size(); ++i) {
    const auto all = std::make_shared<Cloud>();
    for (int v = 0; v < views.depths[i].height(); ++v)
      for (int u = 0; u < views.depths[i].width(); ++u) {
        const float z = views.depths[i].row(v)[u];
        if (!(z > 0)) continue;
        const fuse_flow::Vec3 p = fuse_flow::pointOnRay(views.rig[i].ray(u, v), z);
        all->push_back({p.x, p.y, p.z});
      }
    clouds.push_back(std::make_shared<Cloud>());
    pcl::VoxelGrid<pcl::PointXYZ> grid;
    grid.setInputCloud(all);
    grid.setLeafSize(leaf, leaf, leaf);
    grid.filter(*clouds.back());
  }
  return clouds;
}

/** \brief Kruskal's: of the pairs, largest overlap first, those that connect what is not yet connected; ordered from camera 0. */
Pairs spanningTree(std::size_t cameras, const Pairs& overlaps) {
  std::vector<std::size_t> group(cameras);
  for (std::size_t i = 0; i < cameras; ++i) group[i] = i;
  Pairs edges;
  for (const auto& [a, b] : overlaps) {
    if (group[a] == group[b]) continue;
    const std::size_t old = group[b], now = group[a];
    for (std::size_t& g : group)
      if (g == old) g = now;
    edges.emplace_back(a, b);
  }
  Pairs ordered;
  std::vector<bool> reached(cameras, false);
  reached[0] = true;
  for (bool grown = true; grown;) {
    grown = false;
    for (auto [a, b] : edges) {
      if (reached[a] == reached[b]) continue;
      if (reached[b]) std::swap(a, b);
      ordered.emplace_back(a, b);
      reached[b] = grown = true;
    }
  }
  return ordered;
}

}  // namespace

PeerResult gicpAlongTree(const fuse_flow::RigFrame& frame, const std::vector<Eigen::Isometry3d>& initial,
                         const Pairs& overlaps, float leaf, float max_distance) {
  const auto start = Clock::now();
  const std::vector<Cloud::Ptr> clouds = thinned(frame, leaf);
  PeerResult result{initial, 0};
  for (const auto& [from, to] : spanningTree(initial.size(), overlaps)) {
    pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
    gicp.setInputTarget(clouds[from]);
    gicp.setInputSource(clouds[to]);
    gicp.setMaxCorrespondenceDistance(max_distance);
    gicp.setMaximumIterations(50);
    Cloud aligned;
    gicp.align(aligned, (initial[from].inverse() * initial[to]).matrix().cast<float>());
    Eigen::Isometry3d relative(gicp.getFinalTransformation().cast<double>());
    relative.linear() = Eigen::Quaterniond(relative.linear()).normalized().toRotationMatrix();
    result.T_world_camera[to] = result.T_world_camera[from] * relative;
  }
  result.milliseconds = since(start);
  return result;
}

PeerResult lum(const fuse_flow::RigFrame& frame, const std::vector<Eigen::Isometry3d>& initial, const Pairs& overlaps,
               float leaf, float max_distance, int rounds) {
  const auto start = Clock::now();
  const std::vector<Cloud::Ptr> clouds = thinned(frame, leaf);
  PeerResult result{initial, 0};
  for (int round = 0; round < rounds; ++round) {
    std::vector<Cloud::Ptr> placed;
    std::vector<std::shared_ptr<pcl::KdTreeFLANN<pcl::PointXYZ>>> trees;
    pcl::registration::LUM<pcl::PointXYZ> problem;
    for (std::size_t i = 0; i < clouds.size(); ++i) {
      placed.push_back(std::make_shared<Cloud>());
      pcl::transformPointCloud(*clouds[i], *placed[i], result.T_world_camera[i].matrix().cast<float>());
      trees.push_back(std::make_shared<pcl::KdTreeFLANN<pcl::PointXYZ>>());
      trees[i]->setInputCloud(placed[i]);
      problem.addPointCloud(placed[i]);
    }
    const float reach = std::max(0.03f, max_distance * std::pow(0.65f, static_cast<float>(round)));
    for (const auto& [a, b] : overlaps) {
      const auto matches = std::make_shared<pcl::Correspondences>();
      pcl::Indices index(1);
      std::vector<float> squared(1);
      for (std::size_t k = 0; k < placed[b]->size(); ++k)
        if (trees[a]->nearestKSearch((*placed[b])[k], 1, index, squared) > 0 && squared[0] < reach * reach)
          matches->emplace_back(static_cast<int>(k), index[0], squared[0]);
      if (matches->size() > 100) problem.setCorrespondences(b, a, matches);
    }
    problem.setMaxIterations(5);
    problem.compute();
    for (std::size_t i = 0; i < clouds.size(); ++i)
      result.T_world_camera[i] =
          Eigen::Isometry3d(problem.getTransformation(i).matrix().cast<double>()) * result.T_world_camera[i];
  }
  for (Eigen::Isometry3d& T : result.T_world_camera)
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  result.milliseconds = since(start);
  return result;
}

PeerResult fpfhAlongTree(const fuse_flow::RigFrame& frame, float leaf) {
  using Features = pcl::PointCloud<pcl::FPFHSignature33>;
  const auto start = Clock::now();
  const std::vector<Cloud::Ptr> clouds = thinned(frame, leaf);
  std::vector<Features::Ptr> features;
  for (const Cloud::Ptr& cloud : clouds) {
    const auto normals = std::make_shared<pcl::PointCloud<pcl::Normal>>();
    pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::Normal> normal_estimation;
    normal_estimation.setInputCloud(cloud);  // the camera is at the origin, where normals are turned to
    normal_estimation.setRadiusSearch(2 * static_cast<double>(leaf));
    normal_estimation.compute(*normals);
    features.push_back(std::make_shared<Features>());
    pcl::FPFHEstimationOMP<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> feature_estimation;
    feature_estimation.setInputCloud(cloud);
    feature_estimation.setInputNormals(normals);
    feature_estimation.setRadiusSearch(5 * static_cast<double>(leaf));
    feature_estimation.compute(*features.back());
  }
  struct Edge {
    std::size_t inliers;
    Eigen::Isometry3d T;  // second camera → first
  };
  std::map<std::pair<std::size_t, std::size_t>, Edge> edges;
  std::srand(1);  // PCL's sampling draws from it
  for (std::size_t i = 0; i < clouds.size(); ++i)
    for (std::size_t j = i + 1; j < clouds.size(); ++j) {
      pcl::SampleConsensusPrerejective<pcl::PointXYZ, pcl::PointXYZ, pcl::FPFHSignature33> consensus;
      consensus.setInputSource(clouds[j]);
      consensus.setSourceFeatures(features[j]);
      consensus.setInputTarget(clouds[i]);
      consensus.setTargetFeatures(features[i]);
      consensus.setMaximumIterations(50000);
      consensus.setNumberOfSamples(3);
      consensus.setCorrespondenceRandomness(5);
      consensus.setSimilarityThreshold(0.9f);
      consensus.setMaxCorrespondenceDistance(1.5 * static_cast<double>(leaf));
      consensus.setInlierFraction(0.25f);
      Cloud aligned;
      consensus.align(aligned);
      if (!consensus.hasConverged()) continue;
      Eigen::Isometry3d T(consensus.getFinalTransformation().cast<double>());
      T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
      edges[{i, j}] = {consensus.getInliers().size(), T};
    }
  Pairs best_first;
  for (const auto& [pair, edge] : edges) best_first.push_back(pair);
  std::stable_sort(best_first.begin(), best_first.end(),
                   [&](const auto& a, const auto& b) { return edges[a].inliers > edges[b].inliers; });
  PeerResult result{std::vector<Eigen::Isometry3d>(clouds.size(), Eigen::Isometry3d::Identity()), 0};
  for (const auto& [from, to] : spanningTree(clouds.size(), best_first)) {
    const Eigen::Isometry3d& T = edges[std::minmax(from, to)].T;
    result.T_world_camera[to] = result.T_world_camera[from] * (from < to ? T : T.inverse());
  }
  result.milliseconds = since(start);
  return result;
}

}  // namespace bench
