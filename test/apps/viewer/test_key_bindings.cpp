#include "viewer/controls/key_bindings.h"

#include "viewer_fixture.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

namespace viewer_test {
namespace {

TEST(KeyBindings, NoKeyIsTakenTwiceAndEachIsFound) {
  std::set<std::string> taken;
  for (const KeyBinding& binding : keyBindings())
    for (const std::string& key : binding.keys) {
      EXPECT_TRUE(taken.insert(key).second) << key;
      EXPECT_EQ(findBinding(key), &binding);
    }
  EXPECT_EQ(findBinding("F12"), nullptr);
}

TEST(KeyBindings, TheHelpListsEveryOne) {
  const std::string help = helpText();
  for (const KeyBinding& binding : keyBindings()) {
    EXPECT_NE(help.find(binding.label), std::string::npos) << binding.keys[0];
    for (const std::string& line : linesOf(binding.help)) EXPECT_NE(help.find(line), std::string::npos) << line;
  }
  EXPECT_NE(help.find("Unlike in pcl_viewer"), std::string::npos);
  for (const char* what : {"concatenated", "grids", "published", "outlier removal", "kept", "--folder", "--format"})
    EXPECT_NE(help.find(what), std::string::npos) << what;
}

/** \brief Keys without a label of their own are listed with the one before them, as in "Right, Left". */
TEST(KeyBindings, ALabelNamesAsManyKeysAsFollowWithoutOne) {
  std::size_t named = 0, found = 0;
  for (const KeyBinding& binding : keyBindings()) {
    if (!binding.label.empty()) {
      EXPECT_LE(named, found) << "a key is not there that is named before " << binding.label;
      named = 1 + static_cast<std::size_t>(std::count(binding.label.begin(), binding.label.end(), ','));
      found = 0;
    }
    found += binding.keys.size();
    EXPECT_GE(named, binding.label.empty() ? 2u : 1u) << binding.keys[0];
  }
}

/** \brief What the help of pcl_viewer lists, but for its handlers of geometry and colour, which are the digits. */
TEST(KeyBindings, EveryKeyOfPclViewerDoesSomething) {
  for (const char* key :
       {"p", "w", "s", "j", "c",     "f",      "e",      "q",     "plus",  "minus", "alt+plus", "alt+minus",
        "g", "u", "o", "r", "alt+r", "ctrl+s", "ctrl+r", "alt+s", "alt+f", "l",     "x",        "h"})
    EXPECT_TRUE(findBinding(key)) << key;
}

TEST(KeyBindings, TheDocumentationHasTheSameTable) {
  std::ifstream file(std::string(FUSE_FLOW_TEST_SOURCE_DIR) + "/doc/reference/viewer.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  std::size_t rows = 0;
  for (const KeyBinding& binding : keyBindings()) {
    if (binding.label.empty()) continue;
    std::string line = binding.help;
    std::replace(line.begin(), line.end(), '\n', ' ');
    const std::string row = "| " + binding.group + " | `" + binding.label + "` | " + line + " |";
    EXPECT_NE(page.find(row), std::string::npos) << "doc/reference/viewer.md lacks\n" << row;
    ++rows;
  }
  for (const auto& [label, help] : mouseBindings()) {
    EXPECT_NE(page.find("| Mouse | " + label + " | " + help + " |"), std::string::npos) << label;
    ++rows;
  }
  std::set<std::string> groups{"Mouse"};
  for (const KeyBinding& binding : keyBindings()) groups.insert(binding.group);
  std::istringstream lines(page);
  std::size_t listed = 0;
  for (std::string line; std::getline(lines, line);)
    for (const std::string& group : groups) listed += line.rfind("| " + group + " | ", 0) == 0 ? 1 : 0;
  EXPECT_EQ(listed, rows) << "it lists what is no key";
}

class EveryKey : public ViewerWindow, public testing::WithParamInterface<std::string> {
 protected:
  /** \brief Where a point of the left view is drawn, away from the texts and the images. */
  std::array<int, 2> drawnInTheMiddle() {
    for (const PointFused& p : *viewer_->panes().cloud(0)->cloud) {
      const std::array<int, 2> at = drawnAt(p.getVector3fMap().cast<double>());
      if (at[0] > 140 && at[0] < 190 && at[1] > 100 && at[1] < 200) return at;
    }
    ADD_FAILURE() << "no point is drawn there";
    return {0, 0};
  }

  /** \brief All that a key can change. */
  std::string state() {
    std::ostringstream text;
    const Playback& p = viewer_->playback();
    text << p.frame() << p.playing() << p.loop() << ' ' << p.speed() << ' ' << viewer_->controls().fused() << ' '
         << viewer_->controls().comparison() << ' ' << static_cast<int>(viewer_->panes().layout()) << ' '
         << viewer_->filming() << viewer_->quitting() << ' ' << viewer_->markedDistance().has_value() << ' ' << files();
    std::size_t hash = 0;
    for (const Rgb8& pixel : picture().data) hash = 31 * hash + 65536u * pixel.r + 256u * pixel.g + pixel.b;
    text << ' ' << hash;
    return text.str();
  }
};

TEST_P(EveryKey, DoesSomething) {
  options_.first_frame = 12;
  options_.color_by = ColorBy::Confidence;
  if (GetParam() == "4" || GetParam() == "5") options_.color_by = ColorBy::Views;
  if (GetParam() == "End")
    openWall();  // simulated cameras never end
  else
    openTable();
  if (GetParam() == "BackSpace") viewer_->toggle(Component::SpatialHash);
  const std::array<int, 2> on_a_point = drawnInTheMiddle();
  moveTo(on_a_point[0], on_a_point[1]);
  if (GetParam() == "Escape") {
    viewer_->markCursor();
    viewer_->markCursor();
  }
  if (GetParam() == "ctrl+r") viewer_->window().pressKey("ctrl+s");
  if (GetParam() == "w" || GetParam() == "s") viewer_->window().pressKey("p");
  if (GetParam() == "ctrl+r" || GetParam() == "r") viewer_->panes().camera()->Azimuth(40);
  viewer_->panes().camera()->SetViewAngle(110);  // the cameras, too
  viewer_->settle();
  const std::string before = state();
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  viewer_->window().pressKey(GetParam());
  const std::string printed = testing::internal::GetCapturedStderr() + testing::internal::GetCapturedStdout();
  viewer_->settle();
  if (GetParam() == "c" || GetParam() == "ctrl+s")
    EXPECT_NE(printed, "") << "it says what the camera is";
  else
    EXPECT_NE(state(), before);
}

std::vector<std::string> allKeys() {
  std::vector<std::string> keys;
  for (const KeyBinding& binding : keyBindings()) keys.push_back(binding.keys.front());
  return keys;
}

INSTANTIATE_TEST_SUITE_P(Viewer, EveryKey, testing::ValuesIn(allKeys()), [](const auto& key) {
  std::string name;
  for (const char c : key.param) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

}  // namespace
}  // namespace viewer_test
