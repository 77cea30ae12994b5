#include "evaluation/truth.h"
#include "recordings/files/file_io.h"
#include "simulation/simulator.h"

#include <fuse_flow/recordings/error.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using namespace fuse_flow::simulation;
namespace fs = std::filesystem;

/** \brief The truth of a small rig, of which one file is changed. */
class DamagedTruth : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / (std::string("fuse_flow_damaged_truth_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    SimulationOptions options;
    options.scene = "table";
    options.sensor = "ideal";
    options.scale = 0.1;
    options.threads = 1;
    writeTruth(folder_.string(), Simulator(options));
    EXPECT_NO_THROW(Truth(folder_.string()));
  }
  void TearDown() override { fs::remove_all(folder_); }

  /** \brief What is said after the first occurrence of a text in a file has been replaced. */
  std::string messageAfter(const std::string& name, const std::string& text, const std::string& by) const {
    const std::string file = (folder_ / "truth" / name).string(), whole = fuse_flow::io::readFile(file);
    std::string changed = whole;
    const std::size_t at = changed.find(text);
    EXPECT_NE(at, std::string::npos) << text;
    changed.replace(at, text.size(), by);
    fuse_flow::io::writeFile(file, changed);
    std::string message;
    try {
      Truth truth(folder_.string());
      ADD_FAILURE() << name << ": '" << by << "' was taken for '" << text << "'";
    } catch (const fuse_flow::io::InputError& error) {
      message = error.what();
    }
    fuse_flow::io::writeFile(file, whole);
    EXPECT_EQ(message.rfind(file, 0), 0u) << message;
    return message;
  }

  fs::path folder_;
};

TEST_F(DamagedTruth, WhatLacksIsKnown) {
  EXPECT_TRUE(Truth::isIn(folder_.string()));
  EXPECT_TRUE(Truth::missingIn(folder_.string()).empty());
  for (const char* name : {"simulation.json", "rig.json", "fixed.ply"}) {
    const fs::path file = folder_ / "truth" / name, aside = folder_ / name;
    fs::rename(file, aside);
    EXPECT_FALSE(Truth::isIn(folder_.string()));
    EXPECT_EQ(Truth::missingIn(folder_.string()), (std::vector<std::string>{file.string()}));
    fs::rename(aside, file);
  }
  fs::remove_all(folder_ / "truth");
  EXPECT_FALSE(Truth::isIn(folder_.string()));
  EXPECT_TRUE(Truth::missingIn(folder_.string()).empty()) << "a recording without truth lacks nothing";
}

TEST_F(DamagedTruth, AMeshWithoutFacesIsNone) {
  EXPECT_NE(messageAfter("fixed.ply", "element face", "element fare").find("without faces"), std::string::npos);
}

TEST_F(DamagedTruth, IsSaidByObjectAndKeyAndInNoLibrarysWords) {
  const std::string file = "simulation.json";
  for (const auto& [text, by, said] : std::vector<std::tuple<std::string, std::string, std::string>>{
           {"\"min_range\"", "\"min\"", "min_range is missing, must be a number"},
           {"\"max_range\": ", "\"max_range\": \"far\", \"was\": ", "max_range is \"far\", must be a number"},
           {"\"objects\"", "\"things\"", "objects is missing, must be a list"},
           {"\"moving\": false", "\"moving\": 0", "object number 0: moving is 0, must be true or false"},
           {"\"name\": ", "\"name\": 3, \"was\": ", "object number 0: name is 3, must be a word"},
           {"\"part\": ", "\"part\": 7, \"was\": ", "object number 0: part is 7, must be a word"},
           {"\"first\": [", "\"first\": [300, ", "object number 0: first is [300,"},
           {"\"infrared\": ", "\"infrared\": null, \"was\": ", "infrared is null, must be a number"},
           {"{", "", "is not JSON: error at byte"},
           {"\"min_range\": ", "\"min_range\": 1e999, \"was\": ", "too large for a double"}}) {
    const std::string message = messageAfter(file, text, by);
    EXPECT_NE(message.find(said), std::string::npos) << message;
    EXPECT_EQ(message.find("json.exception"), std::string::npos) << message;
  }
  EXPECT_NE(messageAfter(file, "{", std::string(2000, '[') + "{").find("16 deep"), std::string::npos);
}

/** \brief PCL's reader would end the program at some of them, and read beside the points at others. */
TEST_F(DamagedTruth, MeshesWithAnotherHeaderAreRefused) {
  for (const auto& [text, by] : std::vector<std::pair<std::string, std::string>>{
           {"element vertex", "obj_info num_cols 7\nobj_info num_rows 3\nelement vertex"},
           {"property uchar red", "property uchar rot"},
           {"property float rest_x", "property uchar rest_x"},
           {"property ushort object", "property uchar object"},
           {"property float nx", "property list uchar float nx"},
           {"element vertex ", "element vertex 9"},
           {"end_header", "element range_grid 1\nproperty list uchar int k\nend_header"},
           {"end_header", "end_hea"}})
    messageAfter("fixed.ply", text, by);
}

}  // namespace
