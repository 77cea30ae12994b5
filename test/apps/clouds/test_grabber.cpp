#include "../recordings/io_fixture.h"
#include "clouds/grabber.h"

#include <pcl/io/image.h>
#include <pcl/io/image_depth.h>
#include <pcl/io/image_rgb24.h>
#include <pcl/io/pcd_grabber.h>
#include <pcl/io/pcd_io.h>

#include <future>

namespace {

using namespace io_test;

/** \brief A device that delivers clouds of one type on demand, and file names if it has them. */
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

/** \brief Pixels as a driver hands them over. */
template <typename Pixel>
class Frame : public pcl::io::FrameWrapper {
 public:
  Frame(unsigned int width, unsigned int height, std::vector<Pixel> pixels, std::uint64_t stamp = 0)
      : width_(width), height_(height), pixels_(std::move(pixels)), stamp_(stamp) {}
  const void* getData() const override { return pixels_.data(); }
  unsigned int getDataSize() const override { return static_cast<unsigned int>(pixels_.size() * sizeof(Pixel)); }
  unsigned int getWidth() const override { return width_; }
  unsigned int getHeight() const override { return height_; }
  unsigned int getFrameID() const override { return 0; }
  std::uint64_t getTimestamp() const override { return stamp_; }

 private:
  unsigned int width_, height_;
  std::vector<Pixel> pixels_;
  std::uint64_t stamp_;
};

/** \brief A device of 4 × 2 pixels with the signatures of pcl::io::OpenNI2Grabber. */
class FakeDepthGrabber : public pcl::Grabber {
 public:
  enum class Offers { Pairs, DepthAlone };
  explicit FakeDepthGrabber(Offers offers) {
    depths_ = createSignal<void(const pcl::io::DepthImage::Ptr&)>();
    if (offers == Offers::Pairs)
      pairs_ = createSignal<void(const pcl::io::Image::Ptr&, const pcl::io::DepthImage::Ptr&, float)>();
  }
  void deliver(std::uint64_t stamp, unsigned int color_scale = 1) {
    constexpr std::uint64_t kShadow = 2046, kNoSample = 2047;
    const std::vector<std::uint16_t> z{500, 2046, 2047, 0, 1500, 1501, 1502, 1503};
    const pcl::io::FrameWrapper::Ptr wrapped(new Frame<std::uint16_t>(4, 2, z, stamp));
    const pcl::io::DepthImage::Ptr depth(new pcl::io::DepthImage(wrapped, 75, 5, kShadow, kNoSample));
    (*depths_)(depth);
    if (!pairs_) return;
    std::vector<std::uint8_t> rgb;
    for (unsigned int v = 0; v < 2 * color_scale; ++v)
      for (unsigned int u = 0; u < 4 * color_scale; ++u)
        for (const unsigned int c : {10 * (u / color_scale), 100 * (v / color_scale), 7u})
          rgb.push_back(static_cast<std::uint8_t>(c));
    const pcl::io::FrameWrapper::Ptr pixels(new Frame<std::uint8_t>(4 * color_scale, 2 * color_scale, rgb, stamp));
    (*pairs_)(pcl::io::Image::Ptr(new pcl::io::ImageRGB24(pixels)), depth, 0.2f);
  }
  void start() override {}
  void stop() override {}
  std::string getName() const override { return "fake depth"; }
  bool isRunning() const override { return true; }
  float getFramesPerSecond() const override { return 0; }

 private:
  boost::signals2::signal<void(const pcl::io::DepthImage::Ptr&)>* depths_;
  boost::signals2::signal<void(const pcl::io::Image::Ptr&, const pcl::io::DepthImage::Ptr&, float)>* pairs_{nullptr};
};

struct ReceivedImages {
  std::vector<std::uint64_t> stamps;
  std::shared_ptr<const io::LoadedView> images;

  io::ImageReceiver receiver() {
    return [this](std::uint64_t stamp, const std::shared_ptr<const io::LoadedView>& i) {
      stamps.push_back(stamp);
      images = i;
    };
  }
};

TEST(DepthGrabber, DeliversDepthWithItsColorOnceAndNoMeasurementIsZero) {
  for (const unsigned int color_scale : {1u, 2u}) {
    FakeDepthGrabber grabber(FakeDepthGrabber::Offers::Pairs);
    ReceivedImages received;
    io::connectDepthGrabber(grabber, received.receiver());
    grabber.deliver(33333, color_scale);
    ASSERT_EQ(received.stamps, std::vector<std::uint64_t>{33333}) << "the pair, not the depth beside it";
    EXPECT_EQ(received.images->depth16.data, (std::vector<std::uint16_t>{500, 0, 0, 0, 1500, 1501, 1502, 1503}));
    EXPECT_EQ(received.images->depth16.width, 4);
    ASSERT_EQ(received.images->color.height, 2) << "of the depth image's size";
    EXPECT_EQ(received.images->color.at(3, 0).r, 30);
    EXPECT_EQ(received.images->color.at(3, 1).g, 100);
    EXPECT_EQ(received.images->color.at(0, 1).b, 7);
  }
}

TEST(DepthGrabber, WithoutColorItDeliversDepthAloneAndWithoutAStampTheTimeOfArrival) {
  FakeDepthGrabber grabber(FakeDepthGrabber::Offers::DepthAlone);
  ReceivedImages received;
  io::connectDepthGrabber(grabber, received.receiver());
  grabber.deliver(0);
  ASSERT_EQ(received.stamps.size(), 1u);
  EXPECT_GT(received.stamps[0], 0u);
  EXPECT_TRUE(received.images->color.empty());
  EXPECT_EQ(received.images->depth16.at(3, 1), 1503);
}

TEST(DepthGrabber, OneOfCloudsIsRefusedByName) {
  FakeGrabber<pcl::PointXYZ> grabber;
  EXPECT_TRUE(refuses([&] { io::connectDepthGrabber(grabber, [](std::uint64_t, const auto&) {}); },
                      {"fake", "no depth images"}));
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
