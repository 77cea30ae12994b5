#include "../scenes.h"

#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/one_thread.h>

#include <functional>
#include <future>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace one_thread {

/** \brief A point that says when one is made: within filters and fusions. */
struct EIGEN_ALIGN16 TellingPoint {
  PCL_ADD_POINT4D
  PCL_MAKE_ALIGNED_OPERATOR_NEW
  TellingPoint() {
    x = y = z = 0;
    data[3] = 1;
    const std::function<void()> tell = std::exchange(next(), {});
    if (tell) tell();
  }
  /** \brief What this thread does when it makes its next point. */
  static std::function<void()>& next() {
    static thread_local std::function<void()> action;
    return action;
  }
};

}  // namespace one_thread

POINT_CLOUD_REGISTER_POINT_STRUCT(one_thread::TellingPoint, (float, x, x)(float, y, y)(float, z, z))

namespace {

using fuse_flow::detail::OneThread;
using one_thread::TellingPoint;

/** \brief What the call throws on a thread of its own; empty: nothing. */
template <typename Call>
std::string thrownElsewhere(const Call& call) {
  return std::async(std::launch::async,
                    [&]() -> std::string {
                      try {
                        call();
                      } catch (const pcl::PCLException& exception) {
                        return exception.what();
                      }
                      return "";
                    })
      .get();
}

TEST(OneThread, ASecondThreadIsRefusedWhileTheFirstIsInside) {
  OneThread object;
  const auto enter = [&] { const OneThread::Inside inside(object, "Owner"); };
  EXPECT_EQ(thrownElsewhere(enter), "");
  {
    const OneThread::Inside inside(object, "Owner");
    EXPECT_NE(thrownElsewhere(enter).find("Owner: two threads use one object at once"), std::string::npos);
    EXPECT_NO_THROW(enter());  // the same thread
    EXPECT_NE(thrownElsewhere(enter), "") << "the first one has not left";
  }
  EXPECT_EQ(thrownElsewhere(enter), "");
}

TEST(OneThread, ACopyHasNobodyInside) {
  OneThread object;
  const OneThread::Inside inside(object, "Owner");
  OneThread copy(object);
  EXPECT_EQ(thrownElsewhere([&] { const OneThread::Inside there(copy, "Owner"); }), "");
  copy = object;
  EXPECT_EQ(thrownElsewhere([&] { const OneThread::Inside there(copy, "Owner"); }), "");
}

TEST(OneThread, WhoThrowsHasLeft) {
  OneThread object;
  EXPECT_THROW(
      {
        const OneThread::Inside inside(object, "Owner");
        throw std::runtime_error("");
      },
      std::runtime_error);
  EXPECT_EQ(thrownElsewhere([&] { const OneThread::Inside inside(object, "Owner"); }), "");
}

/** \brief Whether two clouds have the same points. */
bool same(const pcl::PointCloud<TellingPoint>& a, const pcl::PointCloud<TellingPoint>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t k = 0; k < a.size(); ++k)
    if (a[k].x != b[k].x || a[k].y != b[k].y || a[k].z != b[k].z) return false;
  return true;
}

TEST(OneThread, FuseFlowRefusesASecondThreadAndTheFirstOnesFrameIsAsEver) {
  const scenes::Scene scene = scenes::wall(2);
  fuse_flow::FuseFlow<TellingPoint> fusion;
  fusion.setNumberOfThreads(1);
  pcl::PointCloud<TellingPoint> expected, cloud, other;
  fusion.fuse(scene.rig, expected);
  std::string thrown;
  TellingPoint::next() = [&] { thrown = thrownElsewhere([&] { fusion.fuse(scene.rig, other); }); };
  fusion.fuse(scene.rig, cloud);
  EXPECT_NE(thrown.find("fuse_flow::FuseFlow: two threads"), std::string::npos) << thrown;
  ASSERT_FALSE(cloud.empty());
  EXPECT_TRUE(same(cloud, expected));
  EXPECT_EQ(thrownElsewhere([&] { fusion.fuse(scene.rig, other); }), "");  // one after the other
  EXPECT_TRUE(same(other, expected));
}

TEST(OneThread, AFilterRefusesASecondThread) {
  const scenes::Scene scene = scenes::wall(1);
  fuse_flow::DepthBackprojection<TellingPoint> filter;
  filter.setCamera(scene.rig.cameras[0]);
  filter.setView(scene.rig.views[0]);
  filter.setNumberOfThreads(1);
  pcl::PointCloud<TellingPoint> cloud, other;
  std::string thrown;
  TellingPoint::next() = [&] { thrown = thrownElsewhere([&] { filter.filter(other); }); };
  filter.filter(cloud);
  EXPECT_NE(thrown.find("fuse_flow::DepthBackprojection: two threads"), std::string::npos) << thrown;
  EXPECT_EQ(thrownElsewhere([&] { filter.filter(other); }), "");
  EXPECT_EQ(other.size(), cloud.size());
}

TEST(OneThread, ObjectsOfTheirOwnMayBeUsedAtOnce) {
  const scenes::Scene scene = scenes::makeScene(scenes::cameraRow(3), scenes::ballAndWall());
  pcl::PointCloud<fuse_flow::PointFused> expected;
  fuse_flow::FuseFlow<fuse_flow::PointFused>().fuse(scene.rig, expected);
  std::vector<std::future<bool>> equal;
  for (int thread = 0; thread < 4; ++thread)
    equal.push_back(std::async(std::launch::async, [&] {
      fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
      fusion.setNumberOfThreads(3);
      pcl::PointCloud<fuse_flow::PointFused> cloud;
      bool all = true;
      for (int repetition = 0; repetition < 3; ++repetition) {
        fusion.fuse(scene.rig, cloud);
        all = all && scenes::bytes(cloud) == scenes::bytes(expected);
      }
      return all;
    }));
  for (std::future<bool>& done : equal) EXPECT_TRUE(done.get());
}

}  // namespace
