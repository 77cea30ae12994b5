// Images wherever they are, and points wherever they are wanted.

#include "../test_length.h"
#include "device_comparison.h"
#include "random_rig.h"

namespace {

using namespace device_comparison;
using fuse_flow::ImageView;
using fuse_flow::gpu::Memory;
using random_rig::Random;

/** \brief Two cameras before a rough wall with colour and confidence: depth16 of the first, depth32 of the second. */
struct RoughWall {
  static constexpr int kWidth = 45, kHeight = 33;  // rows that are no multiple of anything
  std::vector<std::uint16_t> depth16;
  std::vector<float> depth32, confidence[2];
  std::vector<fuse_flow::Rgb8> color[2];
  fuse_flow::RigFrame rig;

  RoughWall() {
    Random random(91);
    for (int k = 0; k < kWidth * kHeight; ++k) {
      depth16.push_back(static_cast<std::uint16_t>(random.uniform(1195.0, 1205.0)));
      depth32.push_back(random.uniform(1.195f, 1.205f));
      for (auto& image : confidence) image.push_back(random.uniform(0.5f, 1.0f));
      for (auto& image : color)
        image.push_back({static_cast<std::uint8_t>(random.below(256)), static_cast<std::uint8_t>(random.below(256)),
                         static_cast<std::uint8_t>(random.below(256))});
    }
    rig.cameras.resize(2);
    rig.views.resize(2);
    for (std::size_t i = 0; i < 2; ++i) {
      rig.cameras[i].name = "camera " + std::to_string(i);
      rig.cameras[i].intrinsics = {kWidth, kHeight, 45.0f, 45.0f, 22.0f, 16.0f, {}};
      rig.cameras[i].T_world_camera.translation().x() = 0.01 * static_cast<double>(i);
      rig.views[i].confidence = {confidence[i].data(), kWidth, kHeight};
      rig.views[i].color = {color[i].data(), kWidth, kHeight};
    }
    rig.views[0].depth16 = {depth16.data(), kWidth, kHeight};
    rig.views[1].depth32 = {depth32.data(), kWidth, kHeight};
  }
};

/** \brief Copies of images in memory of one kind, with or without padding after each row. */
class ImageCopies {
 public:
  ImageCopies(Memory memory, bool padded) : memory_(memory), padded_(padded) {}

  template <typename Pixel>
  void move(ImageView<Pixel>& image) {
    if (!image) return;
    const std::size_t row_bytes = sizeof(Pixel) * static_cast<std::size_t>(image.width);
    const std::size_t stride = row_bytes + (padded_ ? 5 * sizeof(Pixel) : 0);
    std::vector<char> bytes(stride * static_cast<std::size_t>(image.height), 0x3b);  // would be something everywhere
    for (int v = 0; v < image.height; ++v)
      std::memcpy(bytes.data() + stride * static_cast<std::size_t>(v), image.row(v), row_bytes);
    image = {reinterpret_cast<const Pixel*>(keep(std::move(bytes))), image.width, image.height, stride};
#if FUSE_FLOW_CUDA
    EXPECT_EQ(fuse_flow::gpu::memoryOf(image.data), memory_);
#endif
  }

 private:
  const char* keep(std::vector<char> bytes) {
    if (memory_ == Memory::Pageable) {
      pageable_.push_back(std::move(bytes));
      return pageable_.back().data();
    }
    if (memory_ == Memory::Pinned) {
      pinned_.emplace_back();
      pinned_.back().resize(bytes.size());
      std::memcpy(pinned_.back().data(), bytes.data(), bytes.size());
      return pinned_.back().data();
    }
    on_device_.emplace_back();
    on_device_.back().resize(bytes.size());
    fuse_flow::gpu::Execution run;
    run.copy(on_device_.back().data(), std::as_const(bytes).data(), bytes.size());
    run.wait();
    return on_device_.back().data();
  }

  Memory memory_;
  bool padded_;
  std::vector<std::vector<char>> pageable_;
  std::vector<fuse_flow::gpu::PinnedBuffer<char>> pinned_;
  std::vector<fuse_flow::gpu::DeviceBuffer<char>> on_device_;
};

/** \brief Expects every way of fusing a frame to give these bytes. */
void expectBytesOfEveryWay(Device& device, fuse_flow::gpu::Stream stream, const fuse_flow::RigFrame& frame,
                           const std::vector<Bytes>& expected) {
  device.setStream(stream);
  Cloud cloud;
  device.fuse(frame, cloud);
  EXPECT_TRUE(bytesOf(cloud) == expected) << "fuse()";
  EXPECT_TRUE(bytesOf(device.fusePinned(frame)) == expected) << "fusePinned()";

  const fuse_flow::gpu::PointSpan<PointFused> points = device.fuseOnDevice(frame);
  EXPECT_EQ(device.getStatistics().fused_points, points.size);
  using Words = fuse_flow::gpu::PointLayout<PointFused>::Words;
  Cloud downloaded;
  downloaded.resize(points.size);
  fuse_flow::gpu::Execution run;
  run.stream = stream;  // what follows on the same stream
  run.copy(reinterpret_cast<Words*>(downloaded.data()), reinterpret_cast<const Words*>(points.points), points.size);
  run.wait();
  EXPECT_TRUE(bytesOf(downloaded) == expected) << "fuseOnDevice()";

  device.submit(frame);
  device.submit(frame);
  device.next(cloud);
  EXPECT_TRUE(bytesOf(cloud) == expected) << "submit() and next()";
  device.nextPinned([&](const fuse_flow::gpu::PointSpan<PointFused>& pinned, std::uint64_t) {
    EXPECT_TRUE(bytesOf(pinned) == expected) << "submit() and nextPinned()";
  });
}

TEST(GpuImageMemory, WhereverAnImageIsTheFrameHasTheSameBytes) {
  const RoughWall wall;
  Device device;
  Cloud cloud;
  device.fuse(wall.rig, cloud);
  ASSERT_GT(cloud.size(), 200u);
  const std::vector<Bytes> expected = bytesOf(cloud);
  const fuse_flow::gpu::OwnStream stream;
  for (const Memory memory : {Memory::Pageable, Memory::Pinned, Memory::Device})
    for (const bool padded : {false, true})
      for (const char* moved : {"depth16", "depth32", "color", "confidence", "all"}) {
        if (shortTests() && moved != std::string("all")) continue;
        SCOPED_TRACE(std::string(moved) + " in memory " + std::to_string(static_cast<int>(memory)) +
                     (padded ? " with padded rows" : ""));
        const std::string which = moved;
        ImageCopies copies(memory, padded);
        fuse_flow::RigFrame frame = wall.rig;
        for (fuse_flow::DepthView& view : frame.views) {
          if (which == "depth16" || which == "all") copies.move(view.depth16);
          if (which == "depth32" || which == "all") copies.move(view.depth32);
          if (which == "color" || which == "all") copies.move(view.color);
          if (which == "confidence" || which == "all") copies.move(view.confidence);
        }
        expectBytesOfEveryWay(device, {}, frame, expected);
        expectBytesOfEveryWay(device, stream.get(), frame, expected);
      }
}

TEST(GpuImageMemory, OfADepthImageOfEitherKindColourAndConfidenceTheHostMakesTheSame) {
  const RoughWall wall;
  expectSame(wall.rig);
  fuse_flow::RigFrame without = wall.rig;
  for (fuse_flow::DepthView& view : without.views) view.confidence = {};
  expectSame(without);
}

}  // namespace
