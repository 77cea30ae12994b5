#include "../count_allocations.h"
#include "../scenes.h"
#include "../simulated_recording.h"

#include <vector>

namespace {

using count_allocations::allocationsOf;
using count_allocations::refuseAllocation;
using fuse_flow::FuseFlow;
using fuse_flow::PointFused;

class Allocations : public testing::Test {
 protected:
  void SetUp() override {
#if !defined(FUSE_FLOW_TEST_COUNTS_ALLOCATIONS)
    GTEST_SKIP() << "allocations are counted with glibc and without sanitizers only";
#endif
  }
};

TEST_F(Allocations, AreCounted) {
  std::vector<int>* numbers = nullptr;
  EXPECT_GE(allocationsOf([&] { numbers = new std::vector<int>(1000); }), 2);
  delete numbers;
  pcl::PointCloud<PointFused> cloud;
  EXPECT_GE(allocationsOf([&] { cloud.resize(1000); }), 1);
  EXPECT_EQ(allocationsOf([&] { cloud.resize(500); }), 0);
}

/** \brief Three frames of a simulated recording. */
class FrameAllocations : public Allocations {
 protected:
  void SetUp() override {
    Allocations::SetUp();
    if (IsSkipped()) return;
    static const std::vector<fuse_flow::io::LoadedFrame> once = simulated_recording::frames(0.25, 3);
    for (const fuse_flow::io::LoadedFrame& frame : once) {
      frames_.push_back(frame.rig);
      frames_.back().cameras[0].name = "a name too long for a string's own memory";
    }
  }

  /** \brief Of frames that have been fused before, again and again: tasks go to threads as it happens. */
  template <typename PointT>
  void expectNone(const fuse_flow::FuseFlowParameters& parameters, unsigned int threads, bool normals = false) {
    FuseFlow<PointT> fusion;
    fusion.setParameters(parameters);
    fusion.setNumberOfThreads(threads);
    fusion.setComputeNormals(normals);
    pcl::PointCloud<PointT> cloud;
    for (const fuse_flow::RigFrame& frame : frames_) fusion.fuse(frame, cloud);
    for (int repetition = 0; repetition < 10; ++repetition)
      for (const fuse_flow::RigFrame& frame : frames_)
        ASSERT_EQ(allocationsOf([&] { fusion.fuse(frame, cloud); }), 0)
            << threads << " threads, repetition " << repetition;
    ASSERT_FALSE(cloud.empty());
  }

  std::vector<fuse_flow::RigFrame> frames_;
};

TEST_F(FrameAllocations, ThereAreNoneOnOneThreadOnceTheMemoryIsThere) { expectNone<PointFused>({}, 1); }

TEST_F(FrameAllocations, ThereAreNoneOnTwoThreadsOnceTheMemoryIsThere) { expectNone<PointFused>({}, 2); }

TEST_F(FrameAllocations, ThereAreNoneOnSevenThreadsOnceTheMemoryIsThere) { expectNone<PointFused>({}, 7); }

TEST_F(FrameAllocations, ThereAreNoneWithThePublishedParameters) {
  expectNone<PointFused>(fuse_flow::FuseFlowParameters::published(), 2);
}

TEST_F(FrameAllocations, ThereAreNoneForNormals) { expectNone<pcl::PointXYZRGBNormal>({}, 2, true); }

TEST_F(FrameAllocations, ThereAreNonePointWise) {
  fuse_flow::FuseFlowParameters parameters;
  parameters.use_spatial_hash = false;
  expectNone<PointFused>(parameters, 2);
}

TEST_F(FrameAllocations, ThereAreNoneForLensesThatBend) {
  for (fuse_flow::RigFrame& frame : frames_)
    for (fuse_flow::Camera& camera : frame.cameras)
      camera.intrinsics.distortion = {-0.1f, 0.02f, 1e-4f, 1e-4f, 0, 0.01f, 0, 0};
  expectNone<PointFused>({}, 2);
}

TEST_F(FrameAllocations, ThereAreNoneForConfidenceImagesAndFloatDepth) {
  std::vector<std::vector<float>> images;
  for (fuse_flow::RigFrame& frame : frames_)
    for (fuse_flow::DepthView& view : frame.views) {
      images.emplace_back();
      for (int v = 0; v < view.height(); ++v)
        for (int u = 0; u < view.width(); ++u)
          images.back().push_back(0.001f * static_cast<float>(view.depth16.row(v)[u]));
      view.depth32 = {images.back().data(), view.width(), view.height()};
      view.depth16 = {};
      images.emplace_back(images.back().size(), 0.9f);
      view.confidence = {images.back().data(), view.width(), view.height()};
    }
  expectNone<PointFused>({}, 2);
}

TEST_F(FrameAllocations, ThereAreNoneForACropBox) {
  fuse_flow::FuseFlowParameters parameters;
  parameters.crop_box = Eigen::AlignedBox3f(Eigen::Vector3f(-1, -1, 0), Eigen::Vector3f(1, 1, 2));
  expectNone<PointFused>(parameters, 2);
}

TEST_F(FrameAllocations, ThereAreNoneToFillHoles) {
  fuse_flow::FuseFlowParameters parameters;
  parameters.preprocessing.fill_neighbours = 3;
  expectNone<PointFused>(parameters, 2);
}

TEST_F(FrameAllocations, ThereAreNoneForMultipathInterference) {
  for (fuse_flow::RigFrame& frame : frames_) frame.cameras[1].multipath.modulation_frequency = 200e6f;
  expectNone<PointFused>({}, 2);
}

TEST_F(FrameAllocations, ThereAreNoneForMissingCameras) {
  frames_[1].views[0] = {};
  frames_[2].views[1] = {};
  expectNone<PointFused>({}, 2);
}

/** \brief Bytes that malloc has handed out. */
std::size_t bytesInUse() {
#if defined(FUSE_FLOW_TEST_COUNTS_ALLOCATIONS)
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
#else
  return 0;
#endif
}

TEST_F(Allocations, ACameraThatGoesMissingNeedsNoMemory) {
  const std::vector<fuse_flow::io::LoadedFrame> frames = simulated_recording::frames(1, 1);
  for (const unsigned int threads : {1u, 2u}) {
    FuseFlow<PointFused> fusion;
    fusion.setNumberOfThreads(threads);
    pcl::PointCloud<PointFused> cloud;
    for (int repetition = 0; repetition < 2; ++repetition) fusion.fuse(frames[0].rig, cloud);
    for (std::size_t missing = 0; missing < frames[0].rig.views.size(); ++missing) {
      fuse_flow::RigFrame rest = frames[0].rig;
      rest.views[missing] = {};
      EXPECT_EQ(allocationsOf([&] { fusion.fuse(rest, cloud); }), 0) << threads << " threads, without view " << missing;
    }
  }
}

TEST_F(Allocations, ACameraThatNeverHasAViewMayClaimAnySize) {
  scenes::Scene scene = scenes::wall(2);
  pcl::PointCloud<PointFused> expected, cloud;
  FuseFlow<PointFused>().fuse(scene.rig, expected);
  fuse_flow::Camera huge = scene.rig.cameras[0];
  huge.intrinsics.width = huge.intrinsics.height = 65536;
  huge.intrinsics.distortion.k1 = 0.1f;  // rays of which there is a table
  huge.depth_correction.columns = huge.depth_correction.rows = 2;
  huge.depth_correction.relative = huge.depth_correction.per_metre = {0.01f, 0.01f, 0.01f, 0.01f};
  scene.rig.cameras.push_back(huge);
  scene.rig.views.emplace_back();
  FuseFlow<PointFused> fusion;
  const std::size_t before = bytesInUse();
  for (int repetition = 0; repetition < 2; ++repetition) {
    fusion.fuse(scene.rig, cloud);
    EXPECT_TRUE(scenes::bytes(cloud) == scenes::bytes(expected));
    EXPECT_EQ(fusion.getStatistics().missing_cameras, std::vector<std::size_t>{2});
  }
  EXPECT_LT(bytesInUse() - before, std::size_t{100} << 20);
}

TEST_F(Allocations, ACameraThatAppearsLaterIsFusedAsIfItHadAlwaysBeenThere) {
  scenes::Scene scene = scenes::wall(3);
  for (fuse_flow::Camera& camera : scene.rig.cameras) {
    camera.intrinsics.distortion.k1 = 0.05f;
    camera.depth_correction.columns = camera.depth_correction.rows = 2;
    camera.depth_correction.relative = camera.depth_correction.per_metre = {0.01f, 0, 0, 0.02f};
  }
  fuse_flow::RigFrame without = scene.rig;
  without.views[1] = {};
  pcl::PointCloud<PointFused> expected, expected_without, cloud;
  FuseFlow<PointFused>().fuse(scene.rig, expected);
  FuseFlow<PointFused>().fuse(without, expected_without);
  FuseFlow<PointFused> fusion;
  for (int repetition = 0; repetition < 2; ++repetition) {
    fusion.fuse(without, cloud);
    EXPECT_TRUE(scenes::bytes(cloud) == scenes::bytes(expected_without));
    fusion.fuse(scene.rig, cloud);
    EXPECT_TRUE(scenes::bytes(cloud) == scenes::bytes(expected));
    for (fuse_flow::RigFrame* rig : {&scene.rig, &without})  // calibrated anew while one camera is missing
      rig->cameras[1].depth_correction.relative[0] = 0.03f;
    FuseFlow<PointFused>().fuse(scene.rig, expected);
    FuseFlow<PointFused>().fuse(without, expected_without);
  }
}

TEST_F(Allocations, AfterMemoryHasRunOutFramesAreFusedAsByANewObject) {
  const scenes::Scene scene = scenes::makeScene(scenes::cameraRow(3), scenes::ballAndWall());
  const scenes::Scene next = scenes::wall(2);
  pcl::PointCloud<PointFused> expected;
  FuseFlow<PointFused>().fuse(next.rig, expected);
  long refused = 0;
  for (bool ran_out = true; ran_out; ++refused) {
    FuseFlow<PointFused> fusion;
    fuse_flow::FuseFlowParameters parameters;
    parameters.confidence.threshold = 0.5f;
    fusion.setParameters(parameters);
    fusion.setNumberOfThreads(1);
    pcl::PointCloud<PointFused> cloud;
    ran_out = false;
    try {
      refuseAllocation(refused, [&] { fusion.fuse(scene.rig, cloud); });
    } catch (const std::bad_alloc&) {
      ran_out = true;
    }
    EXPECT_EQ(fusion.getParameters().confidence.threshold, 0.5f);
    fusion.setParameters({});
    fusion.fuse(next.rig, cloud);
    ASSERT_TRUE(scenes::bytes(cloud) == scenes::bytes(expected)) << "allocation " << refused;
  }
  EXPECT_GT(refused, 100);
}

TEST_F(Allocations, AFrameHoldsAtMost64BytesAPixelBeyondInputAndOutput) {
  const std::vector<fuse_flow::io::LoadedFrame> frames = simulated_recording::frames(1, 1);
  fuse_flow::RigFrame rig = frames[0].rig;
  for (fuse_flow::DepthView& view : rig.views) view.color = {};
  const double pixels = 640.0 * 480.0 * static_cast<double>(rig.views.size());
  for (const unsigned int threads : {2u, 16u}) {
    const std::size_t before = bytesInUse();
    FuseFlow<PointFused> fusion;
    fusion.setNumberOfThreads(threads);
    pcl::PointCloud<PointFused> cloud;
    for (int repetition = 0; repetition < 2; ++repetition) fusion.fuse(rig, cloud);
    const std::size_t output = cloud.points.capacity() * sizeof(PointFused);
    const double bytes_a_pixel = static_cast<double>(bytesInUse() - before - output) / pixels;
    RecordProperty("bytes_a_pixel_on_" + std::to_string(threads) + "_threads", std::to_string(bytes_a_pixel));
    EXPECT_LE(bytes_a_pixel, 64.0) << threads << " threads";
    EXPECT_GE(bytes_a_pixel, 28.0) << threads << " threads";  // less, and nothing was measured
  }
}

}  // namespace
