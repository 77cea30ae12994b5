#include "fuzz_target.h"
#include "scratch.h"

#include "recordings/images/jpeg_encode.h"
#include "recordings/streams/frame_sets.h"

#include "../apps/recordings/images/float_files.h"

#include <fuse_flow/recordings/image.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

// What fuzzing, and reading the parsers for it, has found: each of these inputs once ended the program, took gigabytes, or computed with numbers that overflow.

namespace {

using namespace fuse_flow_fuzz;
using io_test::rawBytes;

/** \brief Runs an input as the fuzzer of that name does. */
void expectTaken(const std::string& name, const std::string& input) {
  const auto target = std::find_if(targets().begin(), targets().end(), [&](const Target& t) { return t.name == name; });
  if (target == targets().end()) GTEST_SKIP() << "the build has no parser for it: " << name;
  EXPECT_NO_THROW(runInput(*target, input));
}

/** \brief Says that it is 65000 × 65000 pixels. */
std::string largeJpeg() {
  fuse_flow::io::ColorImage image;
  image.resize(8, 8);
  std::fill(image.data.begin(), image.data.end(), fuse_flow::Rgb8{10, 20, 30});
  std::string bytes = fuse_flow::io::encodeJpeg(image, 90);
  const std::size_t frame = bytes.find("\xff\xc0");  // marker, length, precision, height, width
  return bytes.replace(frame + 5, 4, "\xfd\xe8\xfd\xe8", 4);
}

/** \brief The same of depth: the entries that a TIFF needs, and no pixels. */
std::string largeTiff() {
  std::string bytes = "II*" + std::string(1, '\0') + rawBytes(std::uint32_t{8});
  const std::vector<std::pair<std::uint16_t, std::uint32_t>> entries{
      {256, 65000}, {257, 65000}, {258, 16}, {259, 1}, {262, 1}, {273, 8}, {277, 1}, {278, 1}, {279, 130000}};
  bytes += rawBytes(static_cast<std::uint16_t>(entries.size()));
  for (const auto& [tag, value] : entries)
    bytes += rawBytes(tag) + rawBytes(std::uint16_t{4}) + rawBytes(std::uint32_t{1}) + rawBytes(value);
  return bytes + rawBytes(std::uint32_t{0});
}

/** \brief An OpenEXR image without pixels: only what says how many blocks it has. Tiles have one pixel. */
std::string exrHeader(std::int32_t width, std::int32_t height, bool tiles) {
  const auto attribute = [](const std::string& name, const std::string& type, const std::string& value) {
    return name + '\0' + type + '\0' + rawBytes(static_cast<std::uint32_t>(value.size())) + value;
  };
  const std::string channel = "Z" + std::string(1, '\0') + rawBytes(std::int32_t{2}) + std::string(4, '\0') +
                              rawBytes(std::int32_t{1}) + rawBytes(std::int32_t{1}) + '\0';
  const std::string window = std::string(8, '\0') + rawBytes(width - 1) + rawBytes(height - 1);
  const std::string one = rawBytes(std::int32_t{1});
  return rawBytes(std::uint32_t{20000630}) + std::string{2, static_cast<char>(tiles ? 2 : 0), 0, 0} +
         attribute("channels", "chlist", channel) + attribute("compression", "compression", std::string(1, '\0')) +
         attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window) +
         attribute("lineOrder", "lineOrder", std::string(1, '\0')) +
         attribute("pixelAspectRatio", "float", rawBytes(1.0f)) +
         attribute("screenWindowCenter", "v2f", std::string(8, '\0')) +
         attribute("screenWindowWidth", "float", rawBytes(1.0f)) +
         (tiles ? attribute("tiles", "tiledesc", one + one + '\0') : "") + '\0';
}

std::string rigOf(const std::string& more) {
  return "{\"cameras\": [{\"name\": \"right\", \"width\": 65000, \"height\": 65000, \"fx\": 30000, \"fy\": 30000, "
         "\"cx\": 30000, \"cy\": 30000, \"depth_scale\": 0.001, \"T_world_camera\": "
         "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]" +
         more + "}]}";
}

TEST(FuzzFindings, ABinningOfFourBillionIsRefused) {  // it was made a float, and that a 0 to divide by
  std::string message = '\2' + rawBytes(std::uint32_t{0}) + rawBytes(std::uint64_t{0}) + rawBytes(std::uint32_t{0}) +
                        rawBytes(std::uint32_t{480}) + rawBytes(std::uint32_t{640}) + rawBytes(std::uint32_t{0}) +
                        rawBytes(std::uint32_t{0});
  for (int matrix = 0; matrix < 2; ++matrix)
    for (const double k : {500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0}) message += rawBytes(k);
  for (int k = 0; k < 12; ++k) message += rawBytes(0.0);
  message += rawBytes(~std::uint32_t{0}) + rawBytes(~std::uint32_t{0});
  for (int k = 0; k < 4; ++k) message += rawBytes(std::uint32_t{0});
  expectTaken("ros1_message", message + '\0');
}

TEST(FuzzFindings, ASizeOfRvlIsLookedAtBeforeItsMemoryIsTaken) {
  const std::string size = rawBytes(std::uint32_t{16384}) + rawBytes(std::uint32_t{16384});
  const std::string format = "16UC1; compressedDepth rvl";
  const auto text = [](const std::string& value) { return rawBytes(static_cast<std::uint32_t>(value.size())) + value; };
  expectTaken("ros1_message", '\1' + rawBytes(std::uint32_t{0}) + rawBytes(std::uint64_t{0}) + text("") + text(format) +
                                  text(std::string(12, '\0') + size + std::string(8, '\0')));
}

TEST(FuzzFindings, ACameraOfDistancesTakesNoMemoryBeforeItHasAnImage) {
  expectTaken("rig", joinedFiles({rigOf(", \"depth_is\": \"distance\""), "", "no image"}));
}

TEST(FuzzFindings, AnImageThatItsFileCannotHoldIsRefused) {
  // Each is of its camera's size, so that nothing else refuses it.
  expectTaken("rig", joinedFiles({rigOf(""), "", largeTiff()}));
  const std::string camera = "1 SIMPLE_PINHOLE 65000 65000 30000 32500 32500\n";
  expectTaken("colmap", joinedFiles({camera, "1 1 0 0 0 0 0 0 1 a.png\n\n", largeJpeg()}));
}

TEST(FuzzFindings, AnExrWithoutRoomForItsTableOfBlocksIsRefusedBeforeItsMemoryIsTaken) {
  expectTaken("exr", exrHeader(8, 1'000'000, false));
  expectTaken("exr", exrHeader(1000, 1000, true));
}

TEST(FuzzFindings, BytesOfAColourInAPlyAreAllThereAndInTheirOrder) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string red = "property uchar red\n", green = "property uchar green\n", blue = "property uchar blue\n";
  const std::string alpha = "property uchar alpha\n", end = "end_header\n1 2 3 4 5 6 7 8\n";
  expectTaken("ply", header + "property float red\n" + blue + end);
  expectTaken("ply", header + red + green + blue + blue + end);
  expectTaken("ply", header + red + green + blue + alpha + "property uchar alpha\n" + end);
  expectTaken("ply", header + red + alpha + "property uint view_count\n" + end);
}

TEST(FuzzFindings, AHashInANameIsNoNumber) {
  expectTaken("image_names", "#.png\n1.png\n2.png\n");
  expectTaken("image_names", "a1.png\na#.png\n");
}

TEST(FuzzFindings, AnIndentedSizeOfAPlyIsRefused) {
  expectTaken("ply",
              "ply\nformat ascii 1.0\n obj_info num_cols 1\nelement vertex 1\nproperty float x\nend_header\n1\n");
}

TEST(FuzzFindings, AliasesOfYamlDoNotMultiply) {
  std::string rows = "row: &r [1", lists = "K: [*r";
  for (int k = 0; k < 4000; ++k) {
    rows += ",1";
    lists += ",*r";
  }
  expectTaken("intrinsics", '\0' + rows + "]\n" + lists + "]\n");
}

TEST(FuzzFindings, TimesThatAreAsFarApartAsNumbersAllowMakeFrames) {
  using namespace fuse_flow::io;
  const FrameSets sets = groupByTime({{0, kLatestTime}, {1, kLatestTime - 1}});
  EXPECT_EQ(sets.sets.size(), 2u);
  expectTaken("image_names", "1.png\n9200000000000000000.png\n100000000000.png\n");
  expectTaken("timestamps", "1\n2\n3\n9.19e18\n");
}

}  // namespace
