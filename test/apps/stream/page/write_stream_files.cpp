// write_stream_files FOLDER: stream files for test_decoder.mjs and test_page.py, and beside each FILE.ffs a FILE.points with what the library's
// decoder makes of its frames. Of each frame: u32 points, and then the arrays of StreamedCloud, those that are empty left out.

#include <fuse_flow/stream/encoded_frame.h>
#include <fuse_flow/stream/stream_file.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow::stream;

struct Point {
  float x, y, z;
  std::uint8_t bgra[4];
  float confidence;
  std::uint32_t view_count;
  float normal[3];
  std::uint32_t camera_mask[2];
};

CloudView viewOf(const std::vector<Point>& points) {
  CloudView view;
  view.points = reinterpret_cast<const unsigned char*>(points.data());
  view.size = points.size();
  view.stride = sizeof(Point);
  view.color = offsetof(Point, bgra);
  view.confidence = offsetof(Point, confidence);
  view.view_count = offsetof(Point, view_count);
  view.normal = offsetof(Point, normal);
  view.camera_mask = offsetof(Point, camera_mask);
  return view;
}

/** \brief A sphere of one metre above a floor: the sphere red where x is large, the floor green; in frame k it is k · 100 mm further on. */
std::vector<Point> scene(int frame, int points, float size = 1) {
  std::mt19937 random(static_cast<unsigned int>(1 + frame));
  const auto unit = [&] { return static_cast<float>(static_cast<double>(random()) / 4294967296.0); };
  std::vector<Point> cloud(static_cast<std::size_t>(points));
  for (int k = 0; k < points; ++k) {
    Point& p = cloud[static_cast<std::size_t>(k)];
    p = {};
    if (k % 2 == 0) {
      const float z = 2 * unit() - 1, angle = 6.2831853f * unit(), r = std::sqrt(1 - z * z);
      const float n[3] = {r * std::cos(angle), r * std::sin(angle), z};
      p.x = 0.5f * n[0] + 0.1f * static_cast<float>(frame);
      p.y = 0.5f * n[1];
      p.z = 0.5f * n[2] + 0.8f;
      for (int axis = 0; axis < 3; ++axis) p.normal[axis] = n[axis];
      p.bgra[2] = static_cast<std::uint8_t>(200 + 50 * n[0]);
      p.bgra[1] = p.bgra[0] = static_cast<std::uint8_t>(40 + random() % 8);
    } else {
      p.x = 3 * unit() - 1.5f;
      p.y = 3 * unit() - 1.5f;
      p.z = 0.002f * unit();
      if (k % 3 != 0) p.normal[2] = 1;  // else it has none
      p.bgra[1] = static_cast<std::uint8_t>(150 + random() % 16);
      p.bgra[0] = p.bgra[2] = 30;
    }
    p.x *= size;
    p.y *= size;
    p.z *= size;
    p.confidence = unit();
    p.view_count = 1 + random() % 4;
    p.camera_mask[0] = 1u << random() % 20;
    p.camera_mask[1] = p.x > 0 ? 8 : 0;
  }
  return cloud;
}

/** \brief What is not alike from any two sides, in any two colours: on a grey floor of three metres a high red box, a low blue one and a yellow
 *  ball. So many points that surfaces are closed. */
std::vector<Point> room() {
  std::mt19937 random(7);
  const auto unit = [&] { return static_cast<float>(static_cast<double>(random()) / 4294967296.0); };
  std::vector<Point> cloud;
  const auto add = [&](float x, float y, float z, int r, int g, int b) {
    Point p{};
    p.x = x;
    p.y = y;
    p.z = z;
    p.bgra[2] = static_cast<std::uint8_t>(r);
    p.bgra[1] = static_cast<std::uint8_t>(g);
    p.bgra[0] = static_cast<std::uint8_t>(b);
    p.confidence = 1;
    p.view_count = 2;
    cloud.push_back(p);
  };
  const float per_square_metre = 20000;
  const auto count = [&](float area) { return static_cast<int>(per_square_metre * area); };
  for (int k = count(9); k > 0; --k) add(3 * unit() - 1.5f, 3 * unit() - 1.5f, 0, 110, 115, 120);
  const auto box = [&](float x, float y, float w, float d, float h, int r, int g, int b) {
    for (int k = count(w * d); k > 0; --k) add(x + w * unit(), y + d * unit(), h, r, g, b);
    for (int k = 2 * count(w * h); k > 0; --k) add(x + w * unit(), y + (k % 2 == 0 ? 0 : d), h * unit(), r, g, b);
    for (int k = 2 * count(d * h); k > 0; --k) add(x + (k % 2 == 0 ? 0 : w), y + d * unit(), h * unit(), r, g, b);
  };
  box(-1.1f, 0.2f, 0.5f, 0.4f, 1.4f, 200, 40, 35);
  box(0.4f, -1.0f, 0.8f, 0.5f, 0.5f, 40, 70, 210);
  for (int k = count(4.0f * 3.14159f * 0.09f); k > 0; --k) {
    const float z = 2 * unit() - 1, angle = 6.2831853f * unit(), r = std::sqrt(1 - z * z);
    add(0.5f + 0.3f * r * std::cos(angle), 0.8f + 0.3f * r * std::sin(angle), 0.3f + 0.3f * z, 230, 200, 40);
  }
  return cloud;
}

fuse_flow::stream::Description description() {
  Description result;
  result.name = "sphere";
  for (int k = 0; k < 2; ++k) {
    fuse_flow::Camera camera;
    camera.name = k == 0 ? "left" : "<b>right</b>";  // text, wherever it is shown
    camera.intrinsics.width = 640;
    camera.intrinsics.height = 480;
    camera.intrinsics.fx = camera.intrinsics.fy = 525;
    camera.intrinsics.cx = 319.5;
    camera.intrinsics.cy = 239.5;
    // They look along y, and x is to the right.
    camera.T_world_camera.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    camera.T_world_camera.translation() = Eigen::Vector3d(k - 0.5, -2.5, 1);
    result.cameras.push_back(camera);
  }
  return result;
}

template <typename T>
void put(std::ofstream& file, const std::vector<T>& values) {
  file.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
}

void write(const std::string& path, const EncodingOptions& options, int frames, int points, float size,
           const std::optional<Wishes>& wishes = {}, const std::vector<Point>* cloud_of_all = nullptr) {
  FrameEncoder encoder(options);
  FrameDecoder decoder(1);
  StreamWriter writer(path + ".ffs", description());
  std::ofstream expected(path + ".points", std::ios::binary);
  for (int k = 0; k < frames; ++k) {
    FrameTimes times;
    times.number = static_cast<std::uint64_t>(k);
    times.captured = 1'700'000'000'000'000'000 + k * 200'000'000ll;
    times.encoded = times.captured + 40'000'000;
    const auto frame = encoder.encode(viewOf(cloud_of_all ? *cloud_of_all : scene(k, points, size)), times);
    const std::vector<std::uint8_t> message =
        (wishes ? messageOf(frame, select(*frame, *wishes)) : messageOf(frame)).joined();
    writer.write(message.data(), message.size());
    StreamedCloud cloud;
    decoder.decode(message.data(), message.size(), cloud);
    put(expected, std::vector<std::uint32_t>{static_cast<std::uint32_t>(cloud.size())});
    put(expected, cloud.positions);
    put(expected, cloud.colors);
    put(expected, cloud.confidence);
    put(expected, cloud.view_counts);
    put(expected, cloud.normals);
    put(expected, cloud.camera_masks);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fputs("usage: write_stream_files FOLDER\n", stderr), 2;
  const std::string folder = std::string(argv[1]) + "/";
  EncodingOptions options;
  write(folder + "sphere", options, 6, 40000, 1);
  options.camera_masks = true;
  options.chunk_points = 1000;
  write(folder + "all_fields", options, 1, 10001, 1);
  options.layers = 8;
  options.chroma_step = 4;
  write(folder + "chroma", options, 1, 5000, 1);
  options.chroma_step = 0;
  Wishes wishes;
  wishes.points = 2000;
  write(folder + "part", options, 1, 10000, 1, wishes);
  // So far apart that chunks lie on both sides of far borders of Morton codes.
  write(folder + "wide", options, 1, 3000, 600);
  options.layers = 1;
  options.normals = options.view_count = options.confidence = options.camera_masks = false;
  write(folder + "one_layer", options, 1, 3000, 1);
  write(folder + "empty", options, 1, 0, 1);
  options = {};
  options.normals = false;
  const std::vector<Point> in_the_room = room();
  write(folder + "room", options, 1, 0, 1, {}, &in_the_room);
}
