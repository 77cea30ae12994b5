#include "io_fixture.h"
#include "room.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <sstream>

namespace {

using namespace io_test;

/** \brief An organised cloud as text, put together without PCL: points in the camera's frame, the pose in VIEWPOINT. */
struct PcdText {
  RoomView view{levelView()};
  std::string viewpoint{"0.5 0.3 1.2 0.5 -0.5 0.5 -0.5"};  // tx ty tz qw qx qy qz
  std::string color_type{"U"};                             // "U", "F" or "" for none
  /** \brief Pixels without a point. */
  std::function<bool(int, int)> hole{[](int, int) { return false; }};
  std::string no_point{"nan nan nan"};

  std::string text() const {
    std::ostringstream out;
    out.precision(9);
    out << "VERSION 0.7\nFIELDS x y z" << (colored() ? " rgb" : "") << "\nSIZE 4 4 4" << (colored() ? " 4" : "")
        << "\nTYPE F F F" << (colored() ? " " + color_type : "") << "\nCOUNT 1 1 1" << (colored() ? " 1" : "")
        << "\nWIDTH " << view.width << "\nHEIGHT " << view.height << "\nVIEWPOINT " << viewpoint << "\nPOINTS "
        << view.width * view.height << "\nDATA ascii\n";
    for (int v = 0; v < view.height; ++v)
      for (int u = 0; u < view.width; ++u) {
        if (hole(u, v))
          out << no_point;
        else
          out << view.point(u, v).transpose();
        if (colored()) out << ' ' << packed(view.color(u, v));
        out << '\n';
      }
    return out.str();
  }

 private:
  bool colored() const { return !color_type.empty(); }
  std::string packed(const Rgb8& c) const {
    const std::uint32_t bits = std::uint32_t{c.r} << 16 | std::uint32_t{c.g} << 8 | c.b;
    if (color_type == "U") return std::to_string(bits);
    float as_float = 0;
    static_assert(sizeof as_float == sizeof bits);
    std::memcpy(&as_float, &bits, sizeof bits);
    std::ostringstream text;
    text.precision(9);
    text << as_float;
    return text.str();
  }
};

class Pcd : public IoTest {
 protected:
  io::LoadedFrame open(const std::vector<std::string>& files, const io::RecordingOptions& options = {}) const {
    io::LoadedFrame frame;
    io::openRecording(files, options)->read(0, frame);
    return frame;
  }
};

PcdText corner() {
  PcdText pcd;
  pcd.view = cornerView();
  const Eigen::Quaterniond q(pcd.view.T_world_camera.linear());
  std::ostringstream viewpoint;
  viewpoint.precision(9);
  viewpoint << pcd.view.T_world_camera.translation().transpose() << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' '
            << q.z();
  pcd.viewpoint = viewpoint.str();
  return pcd;
}

TEST_F(Pcd, PointsLieOnTheWallsOfTheRoom) {
  const auto recording =
      io::openRecording({write("level.pcd", PcdText().text()), write("corner.pcd", corner().text())});
  EXPECT_EQ(recording->kind(), "pcd");
  EXPECT_EQ(recording->frameCount(), 1u);
  EXPECT_EQ(recording->viewName(0), "level");
  EXPECT_EQ(recording->viewName(1), "corner");
  io::LoadedFrame frame;
  recording->read(0, frame);
  ASSERT_EQ(frame.rig.views.size(), 2u);
  EXPECT_TRUE(frame.rig.views[0].color);
  EXPECT_TRUE(showsRoom(frame, 0));
  EXPECT_TRUE(showsRoom(frame, 1));
}

TEST_F(Pcd, TheIntrinsicsAreThoseThatMadeThePoints) {
  const io::LoadedFrame frame = open({write("a.pcd", PcdText().text())});
  const Intrinsics& K = frame.rig.cameras[0].intrinsics;
  EXPECT_EQ(K.width, 64);
  EXPECT_EQ(K.height, 48);
  EXPECT_NEAR(K.fx, 24, 1e-3);
  EXPECT_NEAR(K.fy, 20, 1e-3);
  EXPECT_NEAR(K.cx, 29, 1e-3);
  EXPECT_NEAR(K.cy, 25.5, 1e-3);
}

TEST_F(Pcd, AFlatWallDeterminesTheIntrinsicsToo) {
  PcdText pcd;
  pcd.view.fx = pcd.view.fy = 100;  // so narrow that it sees one wall only
  const io::LoadedFrame frame = open({write("a.pcd", pcd.text())});
  EXPECT_NEAR(frame.rig.cameras[0].intrinsics.fx, 100, 1e-2);
  EXPECT_NEAR(frame.rig.cameras[0].intrinsics.cy, 25.5, 1e-2);
  EXPECT_TRUE(showsRoom(frame, 0, 1));
}

TEST_F(Pcd, TheViewpointIsThePoseOfTheCameraRealPartFirst) {
  PcdText pcd;
  pcd.viewpoint = "1 2 3 0.70710678 0 0 0.70710678";  // a quarter turn about z, which takes x to y
  const io::LoadedFrame frame = open({write("a.pcd", pcd.text())});
  const Eigen::Isometry3d& T = frame.rig.cameras[0].T_world_camera;
  EXPECT_LT((T * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(), 1e-6);
  EXPECT_LT((T * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1, 2, 4)).norm(), 1e-6);
}

TEST_F(Pcd, AViewpointThatIsNoPoseIsRefused) {
  PcdText pcd;
  for (const char* viewpoint :
       {"0 0 0 0 0 0 0", "nan 0 0 1 0 0 0", "0 0 0 inf 0 0 0", "a b c d e f g", "0 0 0 1 0 0 west"}) {
    pcd.viewpoint = viewpoint;
    const std::string file = write("a.pcd", pcd.text());
    EXPECT_TRUE(refuses([&] { open({file}); }, {file, "VIEWPOINT", "quaternion"})) << viewpoint;
  }
  pcd.viewpoint = "1 2 3 1.4142136 0 0 1.4142136";  // of any length it is a rotation
  EXPECT_TRUE(open({write("b.pcd", pcd.text())}).rig.cameras[0].T_world_camera.linear().isUnitary(1e-6));
}

TEST_F(Pcd, PixelsWithoutAPointHaveNoDepth) {
  PcdText pcd;
  pcd.hole = [](int u, int v) { return u < 5 && v < 7; };
  for (const char* no_point : {"nan nan nan", "nan nan 1.5", "0 0 0", "inf -inf inf"}) {
    pcd.no_point = no_point;
    const io::LoadedFrame frame = open({write("a.pcd", pcd.text())});
    const float z = frame.rig.views[0].depth32.row(6)[4];
    EXPECT_TRUE(z == 0 || !std::isfinite(z)) << no_point << " is " << z;
    EXPECT_NEAR(frame.rig.views[0].depth32.row(7)[4], levelView().depth(4, 7), 1e-5) << no_point;
    EXPECT_NEAR(frame.rig.cameras[0].intrinsics.fx, 24, 1e-3) << no_point;
  }
}

TEST_F(Pcd, ColorIsReadHoweverItIsPackedAndWhereItIs) {
  PcdText pcd;
  pcd.color_type = "F";
  io::LoadedFrame frame = open({write("a.pcd", pcd.text())});
  EXPECT_TRUE(frame.rig.views[0].color);
  EXPECT_TRUE(showsRoom(frame, 0));
  pcd.color_type = "";
  frame = open({write("b.pcd", pcd.text())});
  EXPECT_FALSE(frame.rig.views[0].color);
  EXPECT_TRUE(showsRoom(frame, 0));
  io::RecordingOptions options;
  options.read_color = false;
  EXPECT_FALSE(open({path("a.pcd")}, options).rig.views[0].color);
}

TEST_F(Pcd, ViewsChooseAmongTheFiles) {
  const std::vector<std::string> files{write("a.pcd", PcdText().text()), write("b.pcd", corner().text())};
  io::RecordingOptions options;
  options.views = "1";
  const io::LoadedFrame frame = open(files, options);
  ASSERT_EQ(frame.rig.cameras.size(), 1u);
  EXPECT_EQ(frame.rig.cameras[0].name, "b");
  EXPECT_TRUE(showsRoom(frame, 0));
  options.views = "2";
  EXPECT_TRUE(refuses<io::OptionError>([&] { open(files, options); }, {"--views 2", "below 2"}));
}

TEST_F(Pcd, TheExtensionMayBeInCapitals) {
  const io::LoadedFrame frame = open({write("A.PCD", PcdText().text())});
  EXPECT_TRUE(showsRoom(frame, 0));
}

TEST_F(Pcd, OptionsOfOtherRecordingsAreRefused) {
  const std::string file = write("a.pcd", PcdText().text());
  io::RecordingOptions options;
  options.slide = 5;
  EXPECT_TRUE(refuses<io::OptionError>([&] { open({file}, options); }, {"--slide", file}));
  options.slide = 0;
  options.depth_scale = 0.001f;
  EXPECT_TRUE(refuses<io::OptionError>([&] { open({file}, options); }, {"--depth-scale", file, "metres"}));
}

TEST_F(Pcd, PointsThatAreNotThoseOfAPinholeAtTheirOriginAreRefused) {
  PcdText in_the_world;  // as a tool leaves them that has applied the pose already
  in_the_world.view = cornerView();
  std::string text = in_the_world.text();
  const std::string data = "DATA ascii\n";
  text.resize(text.find(data) + data.size());
  std::ostringstream points;
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u)
      points << (in_the_world.view.T_world_camera * in_the_world.view.point(u, v)).transpose() << " 0\n";
  const std::string file = write("a.pcd", text + points.str());
  EXPECT_TRUE(refuses([&] { open({file}); }, {file, "not those of a camera at their origin"}));
}

/** \brief An organised cloud as text. \param point of a pixel */
std::string cloudText(int width, int height, const std::function<Eigen::Vector3d(int, int)>& point) {
  std::ostringstream out;
  out.precision(9);
  out << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " << width << "\nHEIGHT " << height
      << "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << width * height << "\nDATA ascii\n";
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) out << point(u, v).transpose() << '\n';
  return out.str();
}

/** \brief How far the points of a view are at most from where they should be, metres. */
double farthest(const io::LoadedFrame& frame, const std::function<Eigen::Vector3d(int, int)>& point) {
  const Intrinsics& K = frame.rig.cameras[0].intrinsics;
  double most = 0;
  for (int v = 0; v < K.height; ++v)
    for (int u = 0; u < K.width; ++u) {
      const Ray ray = unproject(K, {static_cast<float>(u), static_cast<float>(v)});
      const float z = frame.rig.views[0].depth32.row(v)[u];
      const Eigen::Vector3d p(static_cast<double>(ray.x * z), static_cast<double>(ray.y * z), static_cast<double>(z));
      most = std::max(most, (p - point(u, v)).norm());
    }
  return most;
}

/** \brief Points of the level view's wall and corner through a lens, by rays that a double-precision solver finds. */
struct DistortedPcd {
  Distortion lens;
  double fx{150}, fy{151}, cx{63}, cy{53};
  int width{128}, height{106};

  Eigen::Vector2d distorted(const Eigen::Vector2d& p) const {
    const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
    const auto k = [](float value) { return static_cast<double>(value); };
    const double s = (1 + r2 * (k(lens.k1) + r2 * (k(lens.k2) + r2 * k(lens.k3)))) /
                     (1 + r2 * (k(lens.k4) + r2 * (k(lens.k5) + r2 * k(lens.k6))));
    return {x * s + 2 * k(lens.p1) * x * y + k(lens.p2) * (r2 + 2 * x * x),
            y * s + k(lens.p1) * (r2 + 2 * y * y) + 2 * k(lens.p2) * x * y};
  }
  /** \brief x/z and y/z, by fixed-point iteration: these lenses are mild. */
  Eigen::Vector2d ray(int u, int v) const {
    const Eigen::Vector2d wanted((u - cx) / fx, (v - cy) / fy);
    Eigen::Vector2d p = wanted;
    for (int k = 0; k < 200; ++k) p += wanted - distorted(p);
    return p;
  }
  Eigen::Vector3d point(int u, int v) const {
    const Eigen::Vector2d r = ray(u, v);
    return (1.5 + 0.2 * r.x()) * Eigen::Vector3d(r.x(), r.y(), 1);
  }
  std::string text() const {
    return cloudText(width, height, [this](int u, int v) { return point(u, v); });
  }
};

TEST_F(Pcd, PointsThroughALensThatDistortsKeepTheirPlaces) {
  DistortedPcd kinect, azure;
  kinect.lens = {0.0906f, -0.2684f, 0.0f, 0.0f, 0.0949f};
  azure.lens = {0.51f, -0.2f, 0.0002f, -0.0001f, -0.005f, 0.85f, -0.07f, -0.03f};
  for (const DistortedPcd& pcd : {kinect, azure}) {
    const auto recording = io::openRecording({write("a.pcd", pcd.text())});
    EXPECT_TRUE(recording->warnings().empty());
    io::LoadedFrame frame;
    recording->read(0, frame);
    EXPECT_LT(farthest(frame, [&pcd](int u, int v) { return pcd.point(u, v); }), 1e-4);
  }
}

/** \brief A fisheye whose pixels are as far from the middle as their rays are inclined, 60 degrees at the corners. */
TEST_F(Pcd, PointsThroughAFisheyeKeepTheirPlaces) {
  const auto point = [](int u, int v) {
    const double x = (u - 79.5) / 95, y = (v - 59.5) / 95, theta = std::hypot(x, y);
    const double s = std::tan(theta) / theta;
    return Eigen::Vector3d(1.2 * s * x, 1.2 * s * y, 1.2);
  };
  const auto recording = io::openRecording({write("a.pcd", cloudText(160, 120, point))});
  EXPECT_TRUE(recording->warnings().empty()) << recording->warnings()[0];
  io::LoadedFrame frame;
  recording->read(0, frame);
  EXPECT_LT(farthest(frame, point), 5e-4);
}

/** \brief A lens that bends to and fro, which none of the models does. */
TEST_F(Pcd, PointsThatNoLensHoldsAreSaidOrRefused) {
  const auto recording = [&](double pixels) {
    const auto point = [pixels](int u, int v) {
      return Eigen::Vector3d((u - 79.5 + pixels * std::sin(v / 3.0)) / 95, (v - 59.5) / 95, 1);
    };
    return io::openRecording({write("a.pcd", cloudText(160, 120, point))});
  };
  ASSERT_EQ(recording(0.8)->warnings().size(), 1u);
  EXPECT_NE(recording(0.8)->warnings()[0].find("at worst by 0.8"), std::string::npos) << recording(0.8)->warnings()[0];
  EXPECT_TRUE(refuses([&] { recording(3); }, {path("a.pcd"), "whose lens the Brown-Conrady"}));
}

/** \brief Of many points only some are fitted, but all are judged. */
TEST_F(Pcd, ASinglePointBesideItsRayIsSaid) {
  const auto point = [](int u, int v) {
    const double aside = u == 77 && v == 31 ? 3 : 0;  // pixels
    return Eigen::Vector3d((u - 79.5 + aside) / 95, (v - 59.5) / 95, 1);
  };
  const auto recording = io::openRecording({write("a.pcd", cloudText(160, 120, point))});
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_NE(recording->warnings()[0].find("at worst by 3"), std::string::npos) << recording->warnings()[0];
}

TEST_F(Pcd, PointsThatALensMovesAreSaid) {
  PcdText pcd;
  pcd.hole = [](int u, int v) { return u == 40 && v == 30; };
  std::ostringstream aside;  // of one pixel, half a pixel beside its ray
  aside.precision(9);
  aside << (pcd.view.point(40, 30) + pcd.view.depth(40, 30) * Eigen::Vector3d(0.5 / 24, 0, 0)).transpose();
  pcd.no_point = aside.str();
  const auto recording = io::openRecording({write("a.pcd", pcd.text())});
  ASSERT_EQ(recording->warnings().size(), 1u);
  EXPECT_NE(recording->warnings()[0].find("at worst by 0.4"), std::string::npos) << recording->warnings()[0];
}

TEST_F(Pcd, TooFewPointsAreRefused) {
  PcdText pcd;
  pcd.hole = [](int u, int v) { return v * 64 + u >= 99; };
  const std::string file = write("a.pcd", pcd.text());
  EXPECT_TRUE(refuses([&] { open({file}); }, {file, "has 99 valid points, must be 100 or more"}));
}

TEST_F(Pcd, AnUnorganisedCloudIsRefused) {
  const std::string file = write("a.pcd",
                                 "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
                                 "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n0 0 1\n0 1 1\n");
  EXPECT_TRUE(refuses([&] { open({file}); }, {file, "unorganised", "2x1"}));
}

}  // namespace
