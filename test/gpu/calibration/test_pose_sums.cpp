#include "../../test_length.h"
#include "../furnished_rig.h"

#include <fuse_flow/gpu/calibration/alignment_system.h>
#include <fuse_flow/impl/calibration/alignment_system.hpp>

#include <gtest/gtest.h>

#include <cstring>

// What the device adds up is what the CPU adds up, to the last bit: the same samples in the same order, the same counterparts, the
// same equations. Only where the samples' centre lies is added up in another order.

namespace {

using furnished_rig::FurnishedRig;
using furnished_rig::Options;
using furnished_rig::Poses;
using furnished_rig::Random;
using fuse_flow::AlignmentGates;
using fuse_flow::AlignmentSample;
using fuse_flow::AlignmentSums;

template <typename Value>
bool sameBits(const Value& a, const Value& b) {
  return std::memcmp(&a, &b, sizeof(Value)) == 0;
}

Options randomOptions(Random& random) {
  Options options;
  options.cameras = 1 + random.below(5);
  options.width =
      (random.oneIn(3) ? 200 : 90) + random.below(80);  // blocks of two pixels fill a row of a hundred, or not
  options.height = 70 + random.below(60);
  options.integers = random.oneIn(2);
  options.color = !random.oneIn(4);
  options.distortion = random.oneIn(3);
  options.color_camera = random.oneIn(4);
  options.plane_only = random.oneIn(8);
  return options;
}

fuse_flow::ExtrinsicParameters randomParameters(Random& random) {
  fuse_flow::ExtrinsicParameters p;
  p.reduction = 1 + random.below(3);
  if (random.oneIn(3)) p.coarse_above = 0.5f;  // noisy enough to some
  if (random.oneIn(3)) p.max_speckle = random.uniform(0.0f, 3.0f);
  p.samples = 100 + random.below(3000);
  p.max_neighbours = 1 + random.below(5);
  p.smoothing.passes = random.below(5);
  p.use_color = !random.oneIn(5);
  p.residual_multipath = random.oneIn(4) ? 0.0f : random.uniform(0.01f, 0.5f);
  if (random.oneIn(4)) p.preprocessing.fill_neighbours = 5;
  if (random.oneIn(8)) p.preprocessing.bilateral = true;
  if (random.oneIn(4)) p.preprocessing.max_range = 3.0f;
  return p;
}

void expectSameSamples(const std::vector<AlignmentSample>& host, const std::vector<AlignmentSample>& device) {
  ASSERT_EQ(device.size(), host.size());
  for (std::size_t k = 0; k < host.size(); ++k) ASSERT_TRUE(sameBits(device[k], host[k])) << k;
}

void expectSameSums(fuse_flow::host::RigCorrespondences& host, fuse_flow::host::RigCorrespondences& device) {
  ASSERT_EQ(device.pairs().size(), host.pairs().size());
  for (std::size_t k = 0; k < host.pairs().size(); ++k) {
    EXPECT_EQ(device.pairs()[k].i, host.pairs()[k].i);
    EXPECT_EQ(device.pairs()[k].j, host.pairs()[k].j);
    EXPECT_TRUE(sameBits(device.pairs()[k].geometry, host.pairs()[k].geometry)) << k;
    EXPECT_TRUE(sameBits(device.pairs()[k].color, host.pairs()[k].color)) << k;
  }
  EXPECT_EQ(device.medianResidual(), host.medianResidual());
  const auto &expected = host.clusters(), &clusters = device.clusters();
  ASSERT_EQ(clusters.size(), expected.size());
  const auto byPlace = [](const auto* a, const auto* b) {
    return a->camera != b->camera ? a->camera < b->camera : a->part < b->part;
  };
  std::vector<const fuse_flow::host::AlignmentCluster*> a, b;
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    a.push_back(&expected[k]);
    b.push_back(&clusters[k]);
  }
  std::stable_sort(a.begin(), a.end(), byPlace);
  std::stable_sort(b.begin(), b.end(), byPlace);
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(b[k]->camera, a[k]->camera);
    EXPECT_EQ(b[k]->part, a[k]->part);
    ASSERT_EQ(b[k]->geometry.size(), a[k]->geometry.size());
    for (std::size_t slot = 0; slot < a[k]->geometry.size(); ++slot) {
      EXPECT_TRUE(sameBits(b[k]->geometry[slot], a[k]->geometry[slot]));
      EXPECT_TRUE(sameBits(b[k]->color[slot], a[k]->color[slot]));
    }
  }
}

/** \brief Both systems with the same frames. */
struct Systems {
  fuse_flow::host::AlignmentSystem host{2};
  fuse_flow::gpu::AlignmentSystem device;

  void add(const fuse_flow::RigFrame& frame, const fuse_flow::ExtrinsicParameters& p) {
    host.add(frame, p);
    device.add(frame, p);
  }
  void clear() {
    host.clear();
    device.clear();
  }

  /** \brief Samples, neighbours and sums at every stage of a search. */
  void expectSame(const Poses& poses, const fuse_flow::ExtrinsicParameters& p) {
    host.sample(poses, p.samples);
    device.sample(poses, p.samples);
    const auto here = host.extent(poses), there = device.extent(poses);
    EXPECT_LT((here.center - there.center).norm(), 1e-9);
    EXPECT_NEAR(here.radius, there.radius, 1e-9);
    EXPECT_EQ(device.hasColor(), host.hasColor());
    for (std::size_t t = 0; t < host.instants(); ++t)
      for (std::size_t i = 0; i < host.cameras(); ++i) {
        expectSameSamples(host.samples(t, i), device.samples(t, i));
        for (std::size_t j = 0; j < host.cameras(); ++j)
          EXPECT_EQ(device.normalNoise(i, j), host.normalNoise(i, j)) << i << ", " << j;
      }
    Poses centered = poses;
    for (Eigen::Isometry3d& T : centered) T.pretranslate(-here.center);
    AlignmentGates gates{0.25f, 3.0f, 0.7f, 1e9f, 0.0f, 40.0f, false, 0, 3};
    host.findNeighbours(centered, gates, p.max_neighbours);
    device.findNeighbours(centered, gates, p.max_neighbours);
    for (const bool color : {false, true})
      for (const std::size_t stride : {3u, 1u}) {
        gates = {
            color ? 0.03f : 0.2f, color ? 3.0f : 0.0f, 0.7f, 6.0f, color ? 0.0f : 0.1f, 40.0f, color, stride, stride};
        host.evaluate(centered, here.radius, gates);
        device.evaluate(centered, here.radius, gates);
        expectSameSums(host, device);
      }
  }
};

TEST(GpuPoseSums, OfRandomRigsAreTheHosts) {
  Random random(61);
  Systems systems;  // the same objects for all: frames of changing number, size and kind
  std::size_t correspondences = 0, colored = 0;
  for (int trial = 0; trial < timesOver(24, 4); ++trial) {
    SCOPED_TRACE(trial);
    FurnishedRig frame(random, randomOptions(random));
    const fuse_flow::ExtrinsicParameters p = randomParameters(random);
    systems.clear();
    const int instants = 1 + random.below(2);
    for (int t = 0; t < instants; ++t) {
      if (t > 0) frame.measure(random);
      if (random.oneIn(3))
        frame.rig.views[static_cast<std::size_t>(random.below(static_cast<int>(frame.rig.views.size())))] = {};
      systems.add(frame.rig, p);
    }
    systems.expectSame(frame.disturbed(random), p);
    for (const auto& pair : systems.device.pairs()) {
      correspondences += static_cast<std::size_t>(pair.geometry.count);
      colored += static_cast<std::size_t>(pair.color.count);
    }
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(correspondences, enough(5000)) << "there was something to compare";
  EXPECT_GT(colored, enough(1000));
}

TEST(GpuPoseSums, OfFullSizeImagesAreTheHosts) {
  Random random(62);
  Options options;
  options.cameras = 2;
  options.width = 640;
  options.height = 480;
  const FurnishedRig frame(random, options);
  const fuse_flow::ExtrinsicParameters p;
  Systems systems;
  systems.add(frame.rig, p);
  systems.expectSame(frame.disturbed(random), p);
  EXPECT_EQ(systems.device.samples(0, 0).size(), 12000u);
}

TEST(GpuPoseSums, ViewsOfNothingHaveNone) {
  Random random(63);
  FurnishedRig frame(random, {});
  const fuse_flow::ExtrinsicParameters p;
  Systems systems;
  for (fuse_flow::DepthView& view : frame.rig.views) view = {};
  systems.add(frame.rig, p);
  systems.expectSame(frame.poses(), p);
  systems.clear();
  const std::vector<std::uint16_t> zeros(160 * 120, 0);
  for (fuse_flow::DepthView& view : frame.rig.views) view.depth16 = {zeros.data(), 160, 120};
  systems.add(frame.rig, p);
  systems.expectSame(frame.poses(), p);
  systems.clear();
  fuse_flow::ExtrinsicParameters coarse;
  coarse.reduction = 16;  // 10 × 7 blocks: too few for the noise of normals
  systems.add(FurnishedRig(random, {}).rig, coarse);
  systems.expectSame(frame.poses(), coarse);
}

// The kernel adds one number of the sums a thread.
TEST(GpuPoseSums, FactorsMakeTheSameSumsAsCorrespondences) {
  Random random(64);
  for (const bool colored : {false, true}) {
    AlignmentSums expected{};
    double sums[fuse_flow::gpu::kAlignmentSums] = {};
    for (int k = 0; k < 200; ++k) {
      const auto vector = [&] {
        return fuse_flow::Vec3{random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f)};
      };
      const fuse_flow::Correspondence c{vector(), vector(), random.uniform(-0.1f, 0.1f), random.uniform(0.0f, 1e5f),
                                        colored ? vector() : fuse_flow::Vec3{}};
      if (colored) {
        fuse_flow::addCorrespondence(expected, c.x, c.n, c.own, c.r, c.w);
      } else {
        fuse_flow::addCorrespondence(expected, c.x, c.n, c.r, c.w);
      }
      fuse_flow::gpu::CorrespondenceFactors factors;
      factors.set(c);
      for (std::uint32_t n = 0; n < fuse_flow::gpu::kAlignmentSums; ++n) {
        const fuse_flow::gpu::SumTerm term = fuse_flow::gpu::termOf(n);
        sums[n] += factors.left[term.left] * factors.right[term.right];
      }
    }
    EXPECT_EQ(std::memcmp(&expected, sums, sizeof sums), 0) << colored;
  }
}

}  // namespace
