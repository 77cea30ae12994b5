
#include "io_fixture.h"
#include "recordings/files/file_io.h"

#include <fuse_flow/recordings/rig_json.h>

#include <nlohmann/json.hpp>

namespace {

using namespace io_test;
using Json = nlohmann::json;

class RigJson : public IoTest {
 protected:
  std::vector<io::RigCamera> read(const Json& json) const { return readText(json.dump()); }
  std::vector<io::RigCamera> readText(const std::string& text) const {
    return io::readRigJson(write("rig.json", text)).cameras;
  }
};

/** \brief A camera with a value of its own in every field. */
Json leftCamera() {
  return {{"name", "left"},
          {"width", 640},
          {"height", 480},
          {"fx", 525.5},
          {"fy", 526.25},
          {"cx", 319.5},
          {"cy", 239.75},
          {"distortion", {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}},
          {"depth_scale", 0.00025},
          {"T_world_camera", {0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1}},
          {"color",
           {{"width", 1280},
            {"height", 720},
            {"fx", 920.5},
            {"fy", 921.25},
            {"cx", 640.5},
            {"cy", 360.75},
            {"distortion", {-0.1, -0.2, -0.3, -0.4, -0.5, -0.6, -0.7, -0.8}},
            {"T_depth_color", {1, 0, 0, 0.03, 0, 0, -1, 0.04, 0, 1, 0, 0.05, 0, 0, 0, 1}}}}};
}

Json rig(const Json& camera) { return {{"cameras", {camera}}}; }

std::vector<float> numbersOf(const Intrinsics& K) {
  const Distortion& d = K.distortion;
  return {static_cast<float>(K.width),
          static_cast<float>(K.height),
          K.fx,
          K.fy,
          K.cx,
          K.cy,
          d.k1,
          d.k2,
          d.p1,
          d.p2,
          d.k3,
          d.k4,
          d.k5,
          d.k6};
}

TEST_F(RigJson, KeysThatAreNotKnownAreNamedWithTheOneThatWasMeant) {
  Json json = rig(leftCamera());
  EXPECT_TRUE(io::readRigJson(write("rig.json", json.dump())).warnings.empty());
  Json right = leftCamera();
  right["name"] = "right";
  for (Json* camera : {&json["cameras"][0], &right}) {
    (*camera)["distorsion"] = {1};
    (*camera)["T_camera_world"] = 7;
  }
  json["cameras"].push_back(right);
  json["cameras"][0]["color"]["T_color_depth"] = 1;
  json["version"] = 3;
  const std::vector<std::string> warnings = io::readRigJson(write("rig.json", json.dump())).warnings;
  const auto has = [&](const std::vector<std::string>& words) {
    for (const std::string& line : warnings) {
      bool all = true;
      for (const std::string& word : words) all = all && line.find(word) != std::string::npos;
      if (all) return true;
    }
    return false;
  };
  EXPECT_EQ(warnings.size(), 4u);
  EXPECT_TRUE(has({"'version'"}));
  EXPECT_TRUE(has({"camera 'left' and 1 other", "'distorsion'", "there is distortion"}));
  EXPECT_TRUE(has({"'T_camera_world'", "there is T_world_camera", "inverse"}));
  EXPECT_TRUE(has({"camera 'left' color", "'T_color_depth'", "there is T_depth_color"}));
}

TEST_F(RigJson, AnErrorNamesTheKeyThatWasMisspelt) {
  Json camera = leftCamera();
  camera["distorsion"] = camera["distortion"];
  camera.erase("distortion");
  camera["distortion_model"] = "equidistant";
  EXPECT_TRUE(refuses([&] { read(rig(camera)); }, {"camera 'left': distortion is missing",
                                                   "(not known there: 'distorsion', there is distortion)"}));
  camera = leftCamera();
  camera.erase("width");
  camera["widht"] = 640;
  camera["note"] = "of 2024";
  EXPECT_TRUE(refuses([&] { read(rig(camera)); }, {"width is missing", "(not known there: 'widht', there is width)"}));
  camera = leftCamera();
  camera["color"] = "color/";  // no object, whose keys nobody can know
  EXPECT_TRUE(refuses([&] { read(rig(camera)); }, {"color"}));
}

TEST_F(RigJson, TheScaleOfConfidenceIsReadAndWritten) {
  Json json = rig(leftCamera());
  EXPECT_FALSE(read(json)[0].confidence_scale);
  json["cameras"][0]["confidence_scale"] = 0.5;
  EXPECT_EQ(read(json)[0].confidence_scale, 0.5f);
  io::RigDescription written;
  written.cameras = read(json);
  io::writeRigJson(path("again.json"), written);
  EXPECT_EQ(io::readRigJson(path("again.json")).cameras[0].confidence_scale, 0.5f);
  for (const double wrong : {0.0, -1.0, 2.0}) {
    json["cameras"][0]["confidence_scale"] = wrong;
    EXPECT_TRUE(refuses([&] { read(json); }, {"confidence_scale"})) << wrong;
  }
}

TEST_F(RigJson, EveryFieldReachesItsMember) {
  const auto cameras = read(rig(leftCamera()));
  ASSERT_EQ(cameras.size(), 1u);
  const Camera& camera = cameras[0].camera;
  EXPECT_EQ(camera.name, "left");
  EXPECT_EQ(camera.depth_scale, 0.00025f);
  EXPECT_EQ(numbersOf(camera.intrinsics), (std::vector<float>{640, 480, 525.5f, 526.25f, 319.5f, 239.75f, 0.1f, 0.2f,
                                                              0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f}));
  EXPECT_EQ(camera.T_world_camera.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(camera.T_world_camera.linear() * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
  ASSERT_TRUE(camera.color);
  EXPECT_EQ(numbersOf(camera.color->intrinsics), (std::vector<float>{1280, 720, 920.5f, 921.25f, 640.5f, 360.75f, -0.1f,
                                                                     -0.2f, -0.3f, -0.4f, -0.5f, -0.6f, -0.7f, -0.8f}));
  EXPECT_EQ(camera.color->T_depth_color.translation(), Eigen::Vector3d(0.03, 0.04, 0.05));
  EXPECT_EQ(camera.color->T_depth_color.linear() * Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ());
}

TEST_F(RigJson, WithoutDistortionAndColorTheCameraIsAPinholeWithRegisteredColor) {
  Json camera = leftCamera();
  camera.erase("distortion");
  camera.erase("color");
  const auto cameras = read(rig(camera));
  EXPECT_TRUE(isIdeal(cameras[0].camera.intrinsics.distortion));
  EXPECT_FALSE(cameras[0].camera.color);
}

TEST_F(RigJson, CamerasKeepTheirOrderAndUnknownKeysAreNoMistake) {
  Json json = rig(leftCamera());
  json["cameras"].push_back(leftCamera());
  json["cameras"][1]["name"] = "a second camera";
  json["cameras"][1]["serial"] = "0815";
  json["comment"] = "calibrated on Monday";
  const auto cameras = read(json);
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].camera.name, "left");
  EXPECT_EQ(cameras[1].camera.name, "a second camera");
}

TEST_F(RigJson, TheExampleOfTheDocumentationIsOne) {
  const std::string text = io::readFile(FUSE_FLOW_TEST_SOURCE_DIR "/doc/reference/formats.md");
  const std::string fence = "```json\n";
  const std::size_t begin = text.find(fence) + fence.size();
  const auto cameras = readText(text.substr(begin, text.find("```", begin) - begin));
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].camera.intrinsics.fx, 525.0f);
  EXPECT_EQ(cameras[0].camera.color->T_depth_color.translation().x(), 0.03);
}

TEST_F(RigJson, WhatIsWrittenReadsBackTheSame) {
  auto cameras = read(rig(leftCamera()));
  Camera& camera = cameras[0].camera;
  camera.T_world_camera.rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, 3).normalized()));
  camera.intrinsics.fx = 1000.0f / 3;
  camera.color->T_depth_color.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()));
  io::RigCamera right{camera};
  right.camera.depth_scale = 0.001f;
  right.camera.name = "right";
  right.camera.color.reset();
  right.camera.intrinsics.distortion = {};
  camera.depth_correction = {3, 2, {0.01f, -0.02f, 1.0f / 300, 0, 0.1f, -0.5f}, {0, 1e-5f, 0.02f, -0.3f, 0.5f, 0}};
  camera.multipath = {200e6f, 0.45f};
  camera.noise = fuse_flow::NoiseModel{0.001f, 0.0f, 1.0f / 300};
  cameras.push_back(right);  // from here on camera is no more
  io::writeRigJson(path("back.json"), {cameras, 29.97});
  const auto [back, frames_per_second, warnings] = io::readRigJson(path("back.json"));
  EXPECT_EQ(frames_per_second, 29.97);
  ASSERT_EQ(back.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back[i].camera.name, cameras[i].camera.name);
    EXPECT_EQ(back[i].camera.depth_scale, cameras[i].camera.depth_scale);
    EXPECT_EQ(numbersOf(back[i].camera.intrinsics), numbersOf(cameras[i].camera.intrinsics));
    EXPECT_EQ(back[i].camera.T_world_camera.matrix(), cameras[i].camera.T_world_camera.matrix());
  }
  EXPECT_EQ(numbersOf(back[0].camera.color->intrinsics), numbersOf(cameras[0].camera.color->intrinsics));
  EXPECT_EQ(back[0].camera.color->T_depth_color.matrix(), cameras[0].camera.color->T_depth_color.matrix());
  EXPECT_FALSE(back[1].camera.color);
  EXPECT_EQ(back[0].camera.depth_correction, cameras[0].camera.depth_correction);
  EXPECT_TRUE(back[1].camera.depth_correction.empty());
  EXPECT_EQ(back[0].camera.multipath, cameras[0].camera.multipath);
  EXPECT_EQ(back[1].camera.multipath, fuse_flow::Multipath());
  EXPECT_EQ(back[0].camera.noise, cameras[0].camera.noise);
  EXPECT_FALSE(back[1].camera.noise);
}

TEST_F(RigJson, OfNoiseWhatIsNotNamedIsNone) {
  Json camera = leftCamera();
  camera["noise"] = {{"quadratic", 0.003}};
  EXPECT_EQ(read(rig(camera))[0].camera.noise, (fuse_flow::NoiseModel{0, 0, 0.003f}));
}

TEST_F(RigJson, NoiseThatIsNoneIsRefused) {
  const auto refused = [&](const Json& noise, const std::vector<std::string>& words) {
    Json camera = leftCamera();
    camera["noise"] = noise;
    return refuses([&] { read(rig(camera)); }, words);
  };
  EXPECT_TRUE(refused(0.01, {"left", "noise", "must be an object with floor, linear, quadratic"}));
  EXPECT_TRUE(refused({{"floor", -0.1}}, {"left", "noise", "floor", "-0.1", "must be 0 to 10"}));
  EXPECT_TRUE(refused({{"linear", 11}}, {"left", "noise", "linear", "11"}));
  EXPECT_TRUE(refused({{"floor", 0}}, {"left", "noise", "is 0 at every depth"}));
}

TEST_F(RigJson, OfMultipathOnlyTheFrequencyIsNeeded) {
  Json camera = leftCamera();
  camera["multipath"] = {{"modulation_frequency", 80e6}};
  EXPECT_EQ(read(rig(camera))[0].camera.multipath, (fuse_flow::Multipath{80e6f, 0.6f}));
}

TEST_F(RigJson, WithoutAFrequencyNothingIsWrittenThatWouldNotBeRead) {
  std::vector<io::RigCamera> cameras = read(rig(leftCamera()));
  cameras[0].camera.multipath = {0, 0.3f};
  io::writeRigJson(path("back.json"), {cameras, std::nullopt});
  EXPECT_EQ(io::readRigJson(path("back.json")).cameras[0].camera.multipath, fuse_flow::Multipath());
}

TEST_F(RigJson, WhatIsWrittenReadsWellToPeople) {
  io::writeRigJson(path("back.json"), {read(rig(leftCamera())), std::nullopt});
  const std::string text = io::readFile(path("back.json"));
  EXPECT_NE(text.find("\"depth_scale\": 0.00025,"), std::string::npos) << text;
  EXPECT_NE(text.find("\"fx\": 525.5,"), std::string::npos) << text;
  EXPECT_EQ(text.find("frames_per_second"), std::string::npos) << "which it was not told";
}

TEST_F(RigJson, TheRateIsThatOfTheFile) {
  Json json = rig(leftCamera());
  EXPECT_FALSE(io::readRigJson(write("rig.json", json.dump())).frames_per_second);
  json["frames_per_second"] = 12.5;
  EXPECT_EQ(io::readRigJson(write("rig.json", json.dump())).frames_per_second, 12.5);
  for (const Json& wrong : {Json(0), Json(-30), Json("30"), Json(), Json(1e-4), Json(2e6)}) {
    json["frames_per_second"] = wrong;
    EXPECT_TRUE(
        refuses([&] { read(json); }, {path("rig.json") + ": frames_per_second is " + wrong.dump() + ", must be"}));
  }
}

TEST_F(RigJson, AKeyThatIsMissingIsNamedWithFileAndCamera) {
  for (const char* key : {"width", "height", "fx", "fy", "cx", "cy", "T_world_camera"}) {
    Json camera = leftCamera();
    camera.erase(key);
    EXPECT_TRUE(
        refuses([&] { read(rig(camera)); }, {path("rig.json") + ": camera 'left': " + key + " is missing, must be "}));
  }
  for (const char* key : {"width", "height", "fx", "fy", "cx", "cy", "T_depth_color"}) {
    Json camera = leftCamera();
    camera["color"].erase(key);
    EXPECT_TRUE(refuses([&] { read(rig(camera)); },
                        {path("rig.json") + ": camera 'left' color: " + key + " is missing, must be "}));
  }
}

TEST_F(RigJson, TheInverseOfAPoseIsNoPoseAndNamed) {
  Json camera = leftCamera();
  camera["T_camera_world"] = camera["T_world_camera"];
  camera.erase("T_world_camera");
  EXPECT_TRUE(
      refuses([&] { read(rig(camera)); }, {"T_world_camera is missing", "T_camera_world", "must be its inverse"}));
}

TEST_F(RigJson, PosesThatNobodyUsesNeedNotBePoses) {
  Json camera = leftCamera();
  camera["T_world_camera"][5] = nullptr;
  const std::string path = write("rig.json", rig(camera).dump());
  EXPECT_TRUE(refuses([&] { io::readRigJson(path); }, {"T_world_camera"}));
  const io::RigDescription without = io::readRigJson(path, false);
  EXPECT_NE(without.cameras[0].pose_error.find("camera 'left': T_world_camera"), std::string::npos)
      << without.cameras[0].pose_error;
  EXPECT_TRUE(without.cameras[0].camera.T_world_camera.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(io::readRigJson(write("good.json", rig(leftCamera()).dump()), false).cameras[0].pose_error.empty());
}

TEST_F(RigJson, ALensModelWithoutCoefficientsIsRefused) {
  Json camera = leftCamera();
  camera.erase("distortion");
  for (const char* model : {"equidistant", "fancy"}) {
    camera["distortion_model"] = model;
    EXPECT_TRUE(refuses([&] { read(rig(camera)); }, {"distortion is missing", model}));
  }
  camera["distortion_model"] = "none";
  EXPECT_TRUE(isIdeal(read(rig(camera))[0].camera.intrinsics.distortion));
}

TEST_F(RigJson, TextThatIsFilledUpWithZerosIsDamaged) {
  const std::string text = rig(leftCamera()).dump();
  const std::string path = write("rig.json", text + std::string(1000, '\0'));
  EXPECT_TRUE(refuses([&] { io::readRigJson(path); }, {path + ": byte " + std::to_string(text.size()) + " is 0"}));
}

TEST_F(RigJson, ACameraWithoutDepthNeedsNoUnitOfDepth) {
  Json camera = leftCamera();
  camera.erase("depth_scale");
  const std::vector<io::RigCamera> without = read(rig(camera));
  EXPECT_FALSE(without[0].has_depth_scale);
  io::writeRigJson(path("again.json"), {without, std::nullopt});
  EXPECT_EQ(io::readFile(path("again.json")).find("depth_scale"), std::string::npos);
  EXPECT_TRUE(read(rig(leftCamera()))[0].has_depth_scale);
}

/** \brief Values that each key must refuse, and what the message says of them. */
struct Wrong {
  const char* key;
  Json value;
  const char* problem;
};
const std::vector<Wrong>& wrongIntrinsics() {
  static const Json seven = {0, 0, 0, 0, 0, 0, 0}, text_within = {0, 0, 0, 0, 0, 0, 0, "0"};
  static const std::vector<Wrong> wrong = {
      {"width", 0, "is 0"},
      {"width", -640, "is -640"},
      {"width", 640.5, "is 640.5, must be a whole number"},
      {"width", "640", "is \"640\", must be a number"},
      {"width", 65536, "is 65536, must be a whole number of pixels, 65535 at most"},
      {"height", 0, "is 0"},
      {"height", nullptr, "is null, must be a number"},
      {"fx", 0, "is 0, must be positive"},
      {"fx", -525, "is -525, must be positive"},
      {"fx", 1e300, "must be positive"},
      {"fy", 0.0, "is 0.0, must be positive"},
      {"fy", Json::array(), "is [], must be a number"},
      {"cx", "centre", "is \"centre\", must be a number"},
      {"cx", 1e300, "must be finite"},
      {"cy", true, "is true, must be a number"},
      {"cy", -1e39, "must be finite"},
      {"distortion", 0, "must be a list of 8 numbers"},
      {"distortion", seven, "has 7 numbers, must be 8"},
      {"distortion", text_within, "must be a list of 8 numbers"}};
  return wrong;
}

TEST_F(RigJson, AValueThatIsWrongIsNamedWithFileCameraAndKey) {
  std::vector<Wrong> wrong = wrongIntrinsics();
  const Json scaled = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1};
  wrong.insert(wrong.end(), {{"depth_scale", 0, "is 0, must be positive"},
                             {"depth_scale", -0.001, "must be positive"},
                             {"depth_scale", 1e-60, "must be metres per unit"},
                             {"depth_scale", 1e60, "must be metres per unit"},
                             {"depth_scale", "mm", "is \"mm\", must be a number"},
                             {"T_world_camera", {1, 2, 3}, "has 3 numbers, must be 16"},
                             {"T_world_camera", "identity", "must be a list of 16 numbers"},
                             {"T_world_camera", scaled, "is not rigid"},
                             {"color", "registered", "must be an object with width"},
                             {"color", nullptr, "must be an object with width"}});
  for (const Wrong& change : wrong) {
    Json camera = leftCamera();
    camera[change.key] = change.value;
    EXPECT_TRUE(refuses([&] { read(rig(camera)); }, {path("rig.json") + ": ", "'left'", change.key, change.problem}))
        << camera[change.key];
  }
}

TEST_F(RigJson, AWrongColorCameraIsNamedAsThat) {
  std::vector<Wrong> wrong = wrongIntrinsics();
  wrong.insert(wrong.end(), {{"T_depth_color", {1, 2, 3}, "has 3 numbers, must be 16"},
                             {"T_depth_color", std::vector<int>(16, 0), "the last row is 0 0 0 0"}});
  for (const Wrong& change : wrong) {
    Json camera = leftCamera();
    camera["color"][change.key] = change.value;
    EXPECT_TRUE(
        refuses([&] { read(rig(camera)); }, {path("rig.json") + ": ", "'left'", "color", change.key, change.problem}))
        << camera["color"][change.key];
  }
}

TEST_F(RigJson, ANameMustBeThatOfAFolder) {
  for (const Json& name : {Json(""), Json("."), Json(".."), Json("a/b"), Json("a\\b"), Json("a\nb"), Json(7), Json()}) {
    Json camera = leftCamera();
    camera["name"] = name;
    EXPECT_TRUE(refuses([&] { read(rig(camera)); }, {path("rig.json") + ": camera number 0: name is " + name.dump()}));
  }
  Json camera = leftCamera();
  camera.erase("name");
  EXPECT_TRUE(refuses([&] { read(rig(camera)); }, {"camera number 0: name is missing"}));
  EXPECT_TRUE(refuses(
      [&] {
        read({{"cameras", {leftCamera(), leftCamera()}}});
      },
      {"camera number 1: name is \"left\", which another camera has"}));
}

TEST_F(RigJson, WhatIsDeepOrLongIsNotQuotedInFull) {
  const std::string deep = std::string(200000, '[') + std::string(200000, ']');
  EXPECT_TRUE(refuses([&] { readText("{\"cameras\": [" + deep + "]}"); }, {path("rig.json"), "16 deep"}));
  const std::string text = "{\"cameras\": [\"" + std::string(10000, 'x') + "\xff\"]}";
  std::string message;
  try {
    readText(text);
  } catch (const io::InputError& error) {
    message = error.what();
  }
  EXPECT_LT(message.size(), 300u + path("rig.json").size());
}

TEST_F(RigJson, WhatIsNoRigIsNamed) {
  for (const char* text : {"[]", "{}", "7", "null", R"({"cameras": []})", R"({"cameras": {}})", R"({"cameras": null})",
                           R"({"camera": [{}]})"})
    EXPECT_TRUE(refuses([&] { readText(text); }, {path("rig.json") + ": cameras is missing or empty"})) << text;
  EXPECT_TRUE(
      refuses([&] { readText(R"({"cameras": ["left"]})"); }, {"camera number 0: is \"left\", must be an object"}));
  EXPECT_TRUE(refuses([&] { readText(""); }, {path("rig.json") + ": is not JSON: error at byte 1"}));
  EXPECT_TRUE(refuses([&] { readText(R"({"cameras": [)"); }, {"is not JSON"}));
  EXPECT_TRUE(refuses([&] { readText(R"({"cameras": [{"name": "left", "fx": NaN}]})"); }, {"is not JSON"}));
  EXPECT_TRUE(refuses([&] { readText(R"({"cameras": [{"fx": 1e999}]})"); }, {"too large"}));
  EXPECT_TRUE(refuses([&] { readText("{\"cameras\": [{\"name\": \"\xff\"}]}"); }, {"is not JSON"}));
  EXPECT_TRUE(refuses([&] { io::readRigJson(path("no.json")); }, {path("no.json"), "not found"}));
}

TEST_F(RigJson, ARigWithAnyByteChangedIsReadOrRefused) {
  const std::string whole = rig(leftCamera()).dump();
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const int change : {0x01, 0x10, 0x40, 0x80}) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ change);
      try {
        readText(damaged);
      } catch (const io::InputError& error) {
        EXPECT_EQ(std::string(error.what()).find(path("rig.json")), 0u) << error.what();
      }
    }
}

}  // namespace
