#pragma once

/** \file
 *  \brief Rigs whose views are shared out among ranks, each of which is a thread. */

#include "../rigs.h"

#include <fuse_flow/distributed/fuse_flow.h>
#include <fuse_flow/distributed/thread_ranks.h>

#include <functional>
#include <memory>
#include <thread>
#include <vector>

namespace ranks {

using fuse_flow::PointFused;
using scenes::Cloud;
using scenes::Scene;
using scenes::Vector3d;

/** \brief A frame with all cameras and the views of one rank. \param rank_of the rank of each camera */
inline fuse_flow::RigFrame partOf(const fuse_flow::RigFrame& frame, const std::vector<int>& rank_of, int rank) {
  fuse_flow::RigFrame part = frame;
  for (std::size_t i = 0; i < part.views.size(); ++i)
    if (rank_of[i] != rank) part.views[i] = {};
  return part;
}

/** \brief Runs body(rank) once for each rank, all at a time; rethrows what the lowest rank threw that did. */
inline void atOnce(int ranks, const std::function<void(int)>& body) {
  std::vector<std::exception_ptr> thrown(static_cast<std::size_t>(ranks));
  std::vector<std::thread> threads;
  for (int r = 0; r < ranks; ++r)
    threads.emplace_back([&, r] {
      try {
        body(r);
      } catch (...) {
        thrown[static_cast<std::size_t>(r)] = std::current_exception();
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::exception_ptr& error : thrown)
    if (error) std::rethrow_exception(error);
}

/** \brief The same with each rank's communicator. */
inline void forEachRank(int ranks, const std::function<void(int, fuse_flow::distributed::Communicator&)>& body,
                        double timeout = 20) {
  fuse_flow::distributed::ThreadRanks group(ranks, timeout);
  atOnce(ranks, [&](int rank) { body(rank, group.communicator(rank)); });
}

/** \brief The same with several communicators of each rank, over which messages go apart from each other. */
inline void forEachRankWithLanes(
    int ranks, std::size_t lanes,
    const std::function<void(int, const std::vector<fuse_flow::distributed::Communicator*>&)>& body) {
  std::vector<std::unique_ptr<fuse_flow::distributed::ThreadRanks>> groups;
  for (std::size_t k = 0; k < lanes; ++k)
    groups.push_back(std::make_unique<fuse_flow::distributed::ThreadRanks>(ranks, 20));
  atOnce(ranks, [&](int rank) {
    std::vector<fuse_flow::distributed::Communicator*> own;
    for (const auto& group : groups) own.push_back(&group->communicator(rank));
    body(rank, own);
  });
}

/** \brief Camera i at rank i mod ranks. */
inline std::vector<int> inTurn(std::size_t cameras, int ranks) {
  std::vector<int> rank_of;
  for (std::size_t i = 0; i < cameras; ++i) rank_of.push_back(static_cast<int>(i) % ranks);
  return rank_of;
}

using Setup = std::function<void(fuse_flow::distributed::FuseFlow<PointFused>&)>;

/** \brief The gathered cloud of a frame. \param root who gathers */
inline Cloud fuse(const fuse_flow::RigFrame& frame, const std::vector<int>& rank_of, int ranks, const Setup& setup = {},
                  int root = 0) {
  Cloud gathered;
  forEachRank(ranks, [&](int rank, fuse_flow::distributed::Communicator& communicator) {
    fuse_flow::distributed::FuseFlow<PointFused> fusion(communicator);
    fusion.setNumberOfThreads(2);
    if (setup) setup(fusion);
    Cloud part, whole;
    fusion.fuse(partOf(frame, rank_of, rank), part);
    fusion.gather(part, whole, root);
    if (rank == root) gathered = whole;
  });
  return gathered;
}

inline bool sameBytes(const Cloud& a, const Cloud& b) {
  return a.size() == b.size() && a.header.stamp == b.header.stamp && a.width == b.width && a.is_dense == b.is_dense &&
         (a.empty() || std::memcmp(static_cast<const void*>(a.points.data()), static_cast<const void*>(b.points.data()),
                                   a.size() * sizeof(PointFused)) == 0);
}

/** \brief Cameras all around a ball in the corner of a room, whose depth is noisy and has holes. */
inline Scene noisyRoom(int cameras, unsigned int seed, double noise = 0.004) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<fuse_flow::Camera> rig;
  for (int i = 0; i < cameras; ++i) {
    const double angle = 6.2831853 * (i + 0.3 * uniform(random)) / cameras;
    rig.push_back(scenes::lookAt({1.1 * std::cos(angle), 0.25 * uniform(random), 1.2 + 1.1 * std::sin(angle)},
                                 {0.1 * uniform(random), 0.1, 1.2 + 0.1 * uniform(random)}, 96 + 8 * (i % 3), 72, 80));
    rig.back().name = "camera " + std::to_string(i);
  }
  const scenes::Surface room =
      scenes::nearest({scenes::plane({0, -1, 0}, -0.5), scenes::plane({0, 0, 1}, 3.2), scenes::plane({-1, 0, 0}, -2.3),
                       scenes::sphere({0.1, 0.15, 1.2}, 0.3)});
  Scene scene = scenes::makeScene(rig, room);
  std::normal_distribution<float> gauss(0, static_cast<float>(noise));
  for (auto& image : scene.depth)
    for (float& z : image.data) {
      z += gauss(random) * z * z;
      if (uniform(random) > 0.97) z = 0;
    }
  scene.color.resize(scene.depth.size());
  for (std::size_t i = 0; i < scene.depth.size(); ++i) {
    scene.color[i].resize(scene.depth[i].width, scene.depth[i].height);
    for (fuse_flow::Rgb8& pixel : scene.color[i].data)
      pixel = {static_cast<std::uint8_t>(random() % 256), static_cast<std::uint8_t>(random() % 256),
               static_cast<std::uint8_t>(17 * i)};
  }
  scene.rig.stamp = 1234567 + seed;
  scene.attach();
  return scene;
}

}  // namespace ranks
