#include "input_checks/color_check.h"
#include "input_checks/empty_clouds.h"
#include "input_checks/input_checks.h"
#include "input_checks/lens_check.h"
#include "input_checks/noise_check.h"
#include "input_checks/view_overlap.h"
#include "recordings/files/unknown_keys.h"

#include "../recordings/io_fixture.h"
#include "../recordings/room.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

namespace {

using namespace io_test;

/** \brief Views of the room in memory. */
struct RoomFrame {
  io::LoadedFrame frame;

  void add(const std::string& name, const RoomView& view) {
    Camera camera;
    camera.name = name;
    camera.intrinsics = {view.width,
                         view.height,
                         static_cast<float>(view.fx),
                         static_cast<float>(view.fy),
                         static_cast<float>(view.cx),
                         static_cast<float>(view.cy),
                         {}};
    camera.T_world_camera = view.T_world_camera;
    io::LoadedView images;
    images.depth32.resize(view.width, view.height);
    images.color.resize(view.width, view.height);
    for (int v = 0; v < view.height; ++v)
      for (int u = 0; u < view.width; ++u) {
        images.depth32.at(u, v) = static_cast<float>(view.depth(u, v));
        images.color.at(u, v) = view.color(u, v);
      }
    frame.rig.cameras.push_back(camera);
    frame.images.push_back(std::move(images));
    attach();
  }
  void attach() {
    frame.rig.views.assign(frame.images.size(), {});
    for (std::size_t i = 0; i < frame.images.size(); ++i) {
      frame.rig.views[i].depth32 = frame.images[i].depth32.view();
      frame.rig.views[i].color = frame.images[i].color.view();
      frame.rig.views[i].confidence = frame.images[i].confidence.view();
    }
  }
};

bool mentions(const std::vector<std::string>& lines, const std::vector<std::string>& words) {
  for (const std::string& line : lines) {
    bool all = true;
    for (const std::string& word : words) all = all && line.find(word) != std::string::npos;
    if (all) return true;
  }
  return false;
}

TEST(ColorCheck, FramesWithoutColourAreCounted) {
  RoomFrame room;
  room.add("left", levelView());
  room.add("right", cornerView());
  io::ColorCheck check;
  check.look(room.frame.rig);
  EXPECT_TRUE(check.complaints().empty());
  room.frame.rig.views[1].color = {};
  check.look(room.frame.rig);
  check.look(room.frame.rig);
  ASSERT_EQ(check.complaints().size(), 1u);
  EXPECT_TRUE(mentions(check.complaints(), {"'right'", "no colour in 2 of 3 frames"}));
}

TEST(ColorCheck, ARecordingWithoutAnyColourIsNoMistake) {
  RoomFrame room;
  room.add("left", levelView());
  room.frame.rig.views[0].color = {};
  io::ColorCheck check;
  check.look(room.frame.rig);
  EXPECT_TRUE(check.complaints().empty());
}

TEST(ColorCheck, ATranslationInMillimetresIsNamed) {
  RoomFrame room;
  room.add("left", levelView());
  Camera& camera = room.frame.rig.cameras[0];
  camera.color = ColorCamera{camera.intrinsics, Eigen::Isometry3d::Identity()};
  camera.color->T_depth_color.translation().x() = 0.032;
  io::ColorCheck right, wrong;
  right.look(room.frame.rig);
  EXPECT_TRUE(right.complaints().empty());
  camera.color->T_depth_color.translation().x() = 32;
  wrong.look(room.frame.rig);
  EXPECT_TRUE(mentions(wrong.complaints(), {"'left'", "none of its points", "32 m long", "metres"}));
}

TEST(ConfidenceCheck, ALargestValueFarBelowTheTypesIsNamedWithTheScaleThatWouldBeRight) {
  RoomFrame room;
  room.add("phone", levelView());
  io::LoadedView& images = room.frame.images[0];
  images.confidence.resize(64, 48);
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) images.confidence.at(u, v) = (u + v) % 2 == 0 ? 1 / 255.0f : 2 / 255.0f;
  images.assumed_confidence_step = 1 / 255.0f;
  room.attach();
  io::ConfidenceCheck check(0.5f);
  check.look(room.frame);
  EXPECT_TRUE(mentions(check.complaints(), {"'phone'", "has 2 as the largest value", "of 255", "must be 0.5"}));
  images.assumed_confidence_step = 0;  // somebody has said the scale
  io::ConfidenceCheck said(0);
  said.look(room.frame);
  EXPECT_TRUE(said.complaints().empty());
  images.assumed_confidence_step = 1 / 255.0f;
  images.confidence.at(0, 0) = 0.6f;
  io::ConfidenceCheck sure(0);
  sure.look(room.frame);
  EXPECT_TRUE(sure.complaints().empty());
}

TEST(ConfidenceCheck, ACameraMostOfWhoseMeasurementsAreDroppedIsNamed) {
  RoomFrame room;
  room.add("network", levelView());
  io::LoadedView& images = room.frame.images[0];
  images.confidence.resize(64, 48);
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) images.confidence.at(u, v) = u < 40 ? 0.45f : 0.9f;
  room.attach();
  io::ConfidenceCheck strict(0.5f), lenient(0.45f);
  strict.look(room.frame);
  lenient.look(room.frame);
  EXPECT_TRUE(mentions(strict.complaints(), {"'network'", "63 % of its measurements", "0.5", "--min-confidence"}));
  EXPECT_TRUE(lenient.complaints().empty());
  for (int v = 0; v < 48; ++v)
    for (int u = 30; u < 40; ++u) images.confidence.at(u, v) = 0.9f;
  io::ConfidenceCheck half(0.5f);
  half.look(room.frame);
  EXPECT_TRUE(half.complaints().empty()) << "fewer than half";
  std::fill(images.confidence.data.begin(), images.confidence.data.end(), 0.0f);
  io::ConfidenceCheck none(0);
  none.look(room.frame);
  EXPECT_TRUE(mentions(none.complaints(), {"'network'", "100 % of its measurements", "confidence is 0"}));
  std::fill(images.confidence.data.begin(), images.confidence.data.end(), 0.6f);
  io::ConfidenceCheck under_tau(0.5f, 0.6f), over_tau(0.5f, 0.59f);
  under_tau.look(room.frame);
  over_tau.look(room.frame);
  EXPECT_TRUE(mentions(under_tau.complaints(), {"'network'", "100 % of its measurements", "not over --tau 0.6"}));
  EXPECT_TRUE(over_tau.complaints().empty());
  io::ConfidenceCheck of_a_method_that_does_not_look(std::nullopt);
  of_a_method_that_does_not_look.look(room.frame);
  EXPECT_TRUE(of_a_method_that_does_not_look.complaints().empty());
}

RigFrame twoCameras() {
  RigFrame rig;
  rig.cameras.resize(2);
  rig.cameras[0].name = "left";
  rig.cameras[1].name = "right";
  rig.cameras[0].noise = NoiseModel{0.5f, 0, 1.5f};  // millimetres, where metres are meant
  static const std::uint16_t depth = 1000;
  rig.views.resize(2);
  for (DepthView& view : rig.views) view.depth16 = {&depth, 1, 1};
  return rig;
}

FrameStatistics withScales(float left, float right) {
  FrameStatistics statistics;
  statistics.noise_scales = {left, right};
  return statistics;
}

TEST(NoiseCheck, AModelFarFromWhatIsMeasuredIsNamed) {
  const RigFrame rig = twoCameras();
  io::NoiseCheck less, more, sometimes, none;
  for (int frame = 0; frame < 3; ++frame) {
    less.look(rig, withScales(0.25f, 0.25f));
    more.look(rig, withScales(8, 1));
    sometimes.look(rig, withScales(frame == 1 ? 0.26f : 0.25f, 1));
    none.look(rig, {});
  }
  EXPECT_TRUE(mentions(less.complaints(), {"'left'", "less than a quarter", "2000 mm at 1 m", "metres"}));
  EXPECT_EQ(less.complaints().size(), 1u) << "the other camera has no model of its own";
  EXPECT_TRUE(mentions(more.complaints(), {"'left'", "more than eight times"}));
  EXPECT_TRUE(sometimes.complaints().empty());
  EXPECT_TRUE(none.complaints().empty()) << "of methods that measure none";
}

TEST(NoiseCheck, ACameraThatIsMissingHasNone) {
  RigFrame rig = twoCameras();
  rig.views[0] = {};
  io::NoiseCheck check;
  check.look(rig, withScales(0.25f, 1));
  EXPECT_TRUE(check.complaints().empty());
}

const PreprocessingParameters kRange;

TEST(ViewOverlap, OfTheSameViewTwiceIsAllAndAgrees) {
  RoomFrame room;
  room.add("a", cornerView());
  room.add("b", cornerView());
  for (const io::CameraOverlap& camera : io::viewOverlap(room.frame.rig, kRange)) {
    EXPECT_GT(camera.points, 500u);
    EXPECT_EQ(camera.seen, camera.points);
    EXPECT_EQ(camera.agreed, camera.points);
  }
}

TEST(ViewOverlap, OfCamerasThatLookAwayFromEachOtherIsNone) {
  RoomFrame room;
  RoomView away = levelView();
  away.T_world_camera.rotate(Eigen::AngleAxisd(3.14159265, Eigen::Vector3d::UnitY()));
  RoomView narrow = levelView();
  away.fx = away.fy = narrow.fx = narrow.fy = 60;
  room.add("a", narrow);
  room.add("b", away);
  for (const io::CameraOverlap& camera : io::viewOverlap(room.frame.rig, kRange)) EXPECT_EQ(camera.seen, 0u);
  io::OverlapCheck check(kRange);
  check.look(room.frame.rig);
  EXPECT_TRUE(mentions(check.complaints(), {"'a'", "0 % of its points"}));
  EXPECT_TRUE(mentions(check.complaints(), {"'b'", "0 % of its points"}));
}

TEST(OverlapCheck, ARigThatAgreesIsNotNamed) {
  RoomFrame room;
  room.add("a", levelView());
  room.add("b", cornerView());
  room.add("c", cornerView(3));
  io::OverlapCheck check(kRange);
  check.look(room.frame.rig);
  EXPECT_TRUE(check.complaints().empty()) << check.complaints()[0];
}

TEST(OverlapCheck, PosesThatAreInvertedAreNamedWithTheConventionThatAgrees) {
  RoomFrame room;
  RoomView aside;  // along the world's y
  aside.T_world_camera.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  aside.T_world_camera.translation() << 0.9, -1.0, 1.1;
  room.add("a", cornerView());
  room.add("b", aside);
  room.add("c", levelView());
  io::OverlapCheck right(kRange);
  right.look(room.frame.rig);
  EXPECT_TRUE(right.complaints().empty());
  for (Camera& camera : room.frame.rig.cameras) camera.T_world_camera = camera.T_world_camera.inverse();
  io::OverlapCheck check(kRange);
  check.look(room.frame.rig);
  EXPECT_TRUE(mentions(check.complaints(), {"--pose-convention world_to_camera"}))
      << testing::PrintToString(check.complaints());
}

/** \brief Two cameras side by side that look at a corner of the room. */
RoomFrame pair() {
  RoomFrame room;
  room.add("a", cornerView());
  room.add("b", cornerView(3));
  return room;
}

std::vector<std::string> complaintsOf(const RoomFrame& room,
                                      const std::function<Eigen::Matrix4d(const Eigen::Matrix4d&)>& meant) {
  RigFrame rig = room.frame.rig;
  for (Camera& camera : rig.cameras) camera.T_world_camera = Eigen::Isometry3d(meant(camera.T_world_camera.matrix()));
  io::OverlapCheck check(kRange);
  check.look(rig);
  return check.complaints();
}

Eigen::Matrix4d diagonal(double x, double y, double z) { return Eigen::Vector4d(x, y, z, 1).asDiagonal(); }

// Some of what they see agrees by chance, which is no reason to say nothing.
TEST(OverlapCheck, OfTwoCamerasAxesOfOpenGlAreNamed) {
  const std::vector<std::string> lines =
      complaintsOf(pair(), [](const Eigen::Matrix4d& T) { return Eigen::Matrix4d(T * diagonal(1, -1, -1)); });
  EXPECT_TRUE(mentions(lines, {"--pose-convention opengl"})) << testing::PrintToString(lines);
}

TEST(OverlapCheck, PosesOfALeftHandedFrameAreNamedWithTheAxis) {
  RoomFrame room = pair();
  room.add("c", levelView());
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Matrix4d mirror = axis == 0 ? diagonal(-1, 1, 1) : diagonal(1, -1, 1);
    const std::vector<std::string> lines =
        complaintsOf(room, [&](const Eigen::Matrix4d& T) { return Eigen::Matrix4d(mirror * T * mirror); });
    EXPECT_TRUE(mentions(lines, {"left-handed", axis == 0 ? "x axis" : "y axis"})) << testing::PrintToString(lines);
  }
}

TEST(InputChecks, OfAPartOfTheCamerasNothingIsSaidOfHowTheyAgree) {
  RoomFrame room = pair();
  for (Camera& camera : room.frame.rig.cameras) camera.T_world_camera = camera.T_world_camera.inverse();
  for (const bool whole : {true, false}) {
    io::InputChecks checks("fuse_flow", FuseFlowParameters(), {}, whole);
    checks.look(room.frame);
    EXPECT_EQ(checks.complaints().empty(), !whole);
  }
}

TEST(OverlapCheck, PosesThatAreRightHaveNoBetterMeaning) {
  EXPECT_TRUE(complaintsOf(pair(), [](const Eigen::Matrix4d& T) { return T; }).empty());
  // A few centimetres and degrees off, as before a calibration.
  RoomFrame room = pair();
  room.frame.rig.cameras[1].T_world_camera.translation() += Eigen::Vector3d(0.03, -0.02, 0.02);
  room.frame.rig.cameras[1].T_world_camera.rotate(Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()));
  EXPECT_FALSE(mentions(complaintsOf(room, [](const Eigen::Matrix4d& T) { return T; }), {"would agree"}));
}

TEST(LensCheck, PixelsThatNoRayReachesAreCountedAmongThoseThatMeasure) {
  RoomFrame room = pair();
  Intrinsics& K = room.frame.rig.cameras[0].intrinsics;
  K.distortion.k1 = -0.5f;  // no ray beyond 0.544 focal lengths
  std::size_t beyond = 0, all = 0;
  for (int v = 0; v < K.height; ++v)
    for (int u = 0; u < K.width; ++u) {
      const double x = (u - static_cast<double>(K.cx)) / static_cast<double>(K.fx),
                   y = (v - static_cast<double>(K.cy)) / static_cast<double>(K.fy);
      float& z = room.frame.images[0].depth32.at(u, v);
      if (u == 0) z = 0;  // measures nothing
      all += z > 0 ? 1 : 0;
      beyond += z > 0 && std::hypot(x, y) > std::sqrt(2.0 / 3) * 2 / 3 ? 1 : 0;
    }
  ASSERT_GT(beyond, 0u);
  io::LensCheck check;
  check.look(room.frame.rig);
  check.look(room.frame.rig);
  char share[16];
  std::snprintf(share, sizeof share, "%.1f", 100.0 * static_cast<double>(beyond) / static_cast<double>(all));
  ASSERT_EQ(check.complaints().size(), 1u);
  EXPECT_TRUE(
      mentions(check.complaints(), {"'a'", std::string(share) + " % of its measurements are left out", "distortion"}))
      << check.complaints()[0] << " and not " << share;
}

TEST(LensCheck, AColourCameraOfItsOwnIsLookedAtToo) {
  RoomFrame room = pair();
  Camera& camera = room.frame.rig.cameras[1];
  camera.color = ColorCamera{camera.intrinsics};
  camera.color->intrinsics.distortion.k1 = -0.5f;  // no ray beyond 0.544 focal lengths
  const Intrinsics& K = camera.color->intrinsics;
  std::vector<Rgb8> color(static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height));
  double beyond = 0;
  for (int v = 0; v < K.height; ++v)
    for (int u = 0; u < K.width; ++u)
      beyond +=
          std::hypot((static_cast<float>(u) - K.cx) / K.fx, (static_cast<float>(v) - K.cy) / K.fy) > 0.5443f ? 1 : 0;
  ASSERT_GT(beyond, 0);
  room.frame.rig.views[1].color = {};
  io::LensCheck without_image;
  without_image.look(room.frame.rig);
  EXPECT_TRUE(without_image.complaints().empty()) << "nobody asks it for colour";
  room.frame.rig.views[1].color = {color.data(), K.width, K.height};
  io::LensCheck check;
  check.look(room.frame.rig);
  const std::vector<std::string> lines = check.complaints();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(mentions(lines, {"'b'", "colour camera folds over", "no colour of this camera", "distortion_model"}))
      << lines[0];
  const double said = std::stod(lines[0].substr(lines[0].find("no ray for ") + 11));
  EXPECT_NEAR(said, 100 * beyond / static_cast<double>(color.size()), 1.0)
      << "of every fourth pixel of every fourth row";
}

TEST(EmptyClouds, TheOptionThatLeavesNoPointIsNamedOnce) {
  const RoomFrame room = pair();
  io::MethodOptions options;
  options.device = "cpu";
  options.parameters.preprocessing.max_range = 10;
  const auto said = [&](const std::function<void(FuseFlowParameters&)>& change) {
    io::MethodOptions changed = options;
    change(changed.parameters);
    io::EmptyClouds empty("fuse_flow", changed);
    empty.look(6, room.frame.rig, 100);
    empty.look(7, room.frame.rig, 0);
    empty.look(8, room.frame.rig, 0);
    return empty.complaints();
  };
  using Lines = std::vector<std::string>;
  EXPECT_EQ(said([](FuseFlowParameters& p) { p.max_noise = 1e-6f; }),
            (Lines{"2 of 3 clouds are empty, the first of frame 7: no point passes --max-noise 1e-06"}));
  EXPECT_EQ(
      said([](FuseFlowParameters& p) { p.crop_box.emplace(Eigen::Vector3f(50, 5, 5), Eigen::Vector3f(60, 6, 6)); }),
      (Lines{"2 of 3 clouds are empty, the first of frame 7: no point passes --crop-box"}));
  io::EmptyClouds full("fuse_flow", options);
  full.look(0, room.frame.rig, 5);
  EXPECT_TRUE(full.complaints().empty());
  io::EmptyClouds of_a_part("fuse_flow", options);  // nobody has all images
  of_a_part.look(3, room.frame.rig, 0, false);
  EXPECT_EQ(of_a_part.complaints(), (Lines{"1 of 1 clouds are empty, the first of frame 3"}));
}

TEST(UnknownKeys, TheNameThatWasMeantIsOneThatDiffersInALetterOrTwo) {
  const std::vector<std::string> known{"distortion", "depth_scale", "fx", "fy"};
  EXPECT_EQ(io::likelyMeant("distorsion", known), "distortion");
  EXPECT_EQ(io::likelyMeant("widht", {"height", "width"}), "width") << "two letters in the wrong order";
  EXPECT_EQ(io::likelyMeant("xf", {"cx", "fx"}), "fx");
  EXPECT_EQ(io::likelyMeant("depthScale", known), "depth_scale");
  EXPECT_EQ(io::likelyMeant("serial_number", known), "");
  EXPECT_EQ(io::likelyMeant("fps", known, {{"fps", "frames_per_second"}}), "frames_per_second");
}

}  // namespace
