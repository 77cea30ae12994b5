#include "io/grabber.h"
#include "io_fixture.h"

#include <pcl/io/pcd_grabber.h>
#include <pcl/io/pcd_io.h>

#include <future>

namespace {

using namespace io_test;

/** \brief A device that delivers clouds of one type when it is told to, and files' names if it has them. */
template <typename PointT>
class FakeGrabber : public pcl::Grabber {
 public:
  using Cloud = pcl::PointCloud<PointT>;

  explicit FakeGrabber(bool tells_files = false) {
    clouds_ = createSignal<void(const typename Cloud::ConstPtr&)>();
    if (tells_files) files_ = createSignal<void(const std::string&)>();
  }
  void deliver(std::uint64_t stamp, const std::string& file = "") {
    const typename Cloud::Ptr cloud(new Cloud(3, 2));
    cloud->header.stamp = stamp;
    cloud->at(2, 1).z = 1.5f;
    cloud->sensor_origin_.x() = 0.25f;
    (*clouds_)(cloud);
    if (files_) (*files_)(file);
  }
  void start() override {}
  void stop() override {}
  std::string getName() const override { return "fake"; }
  bool isRunning() const override { return true; }
  float getFramesPerSecond() const override { return 0; }

 private:
  boost::signals2::signal<void(const typename Cloud::ConstPtr&)>* clouds_;
  boost::signals2::signal<void(const std::string&)>* files_{nullptr};
};

struct Received {
  std::vector<std::uint64_t> stamps;
  io::OrganizedCloud::ConstPtr cloud;

  io::CloudReceiver receiver() {
    return [this](std::uint64_t stamp, const io::OrganizedCloud::ConstPtr& c) {
      stamps.push_back(stamp);
      cloud = c;
    };
  }
};

template <typename PointT>
class GrabberOf : public testing::Test {};
using PointTypes = testing::Types<pcl::PointXYZ, pcl::PointXYZI, pcl::PointXYZRGB, pcl::PointXYZRGBA>;
TYPED_TEST_SUITE(GrabberOf, PointTypes);

TYPED_TEST(GrabberOf, AnyPointTypeDeliversOrganisedCloudsWithStampAndPose) {
  FakeGrabber<TypeParam> grabber;
  Received received;
  io::connectGrabber(grabber, received.receiver());
  grabber.deliver(33333);
  ASSERT_EQ(received.stamps, std::vector<std::uint64_t>{33333});
  EXPECT_EQ(received.cloud->width, 3u);
  EXPECT_EQ(received.cloud->height, 2u);
  EXPECT_EQ(received.cloud->at(2, 1).z, 1.5f);
  EXPECT_EQ(received.cloud->sensor_origin_.x(), 0.25f);
}

TEST(Grabber, ACloudWithoutAStampHasThatOfItsFilesName) {
  FakeGrabber<pcl::PointXYZRGB> grabber(true);
  Received received;
  io::connectGrabber(grabber, received.receiver());
  grabber.deliver(0, "clouds/000000066667.pcd");
  grabber.deliver(5, "clouds/7.pcd");
  EXPECT_EQ(received.stamps, (std::vector<std::uint64_t>{66667, 5}))
      << "its own goes before the file's, and is told once";
}

TEST(Grabber, ACloudWithoutAnyStampHasTheTimeOfItsArrival) {
  FakeGrabber<pcl::PointXYZRGB> grabber, files(true);
  Received received;
  io::connectGrabber(grabber, received.receiver());
  io::connectGrabber(files, received.receiver());
  grabber.deliver(0);
  files.deliver(0, "corner.pcd");
  ASSERT_EQ(received.stamps.size(), 2u);
  EXPECT_GT(received.stamps[0], 0u);
  EXPECT_GE(received.stamps[1], received.stamps[0]);
}

TEST(Grabber, OneThatDeliversNoCloudsIsRefusedByName) {
  struct Silent : FakeGrabber<pcl::PointNormal> {
  } grabber;
  EXPECT_TRUE(refuses([&] { io::connectGrabber(grabber, [](std::uint64_t, const auto&) {}); }, {"fake", "no clouds"}));
}

class PcdGrabber : public IoTest {};

TEST_F(PcdGrabber, PlaysFilesThatAreStampedByTheirNames) {
  pcl::PointCloud<pcl::PointXYZRGB> cloud(3, 2);
  std::vector<std::string> files{path("000000000500.pcd"), path("000000001000.pcd")};
  for (const std::string& file : files) ASSERT_EQ(pcl::io::savePCDFileBinary(file, cloud), 0);
  pcl::PCDGrabber<pcl::PointXYZRGB> grabber(files,
                                            100);  // frames per second; without a rate, PCL 1.13 ends the program
  std::vector<std::uint64_t> stamps;
  std::promise<void> played;
  io::connectGrabber(grabber, [&](std::uint64_t stamp, const io::OrganizedCloud::ConstPtr&) {
    stamps.push_back(stamp);
    if (stamps.size() == files.size()) played.set_value();
  });
  grabber.start();
  played.get_future().wait();
  grabber.stop();
  EXPECT_EQ(stamps, (std::vector<std::uint64_t>{500, 1000}));
}

}  // namespace
