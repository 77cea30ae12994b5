#include "viewer/controls/key_bindings.h"

#include "viewer/viewer.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

namespace fuse_flow::viewing {
namespace {

KeyBinding colorKey(const std::string& key, ColorBy what, const std::string& help) {
  return {"Colour by", key, {key}, help, [what](Viewer& v) { v.colorBy(what); }};
}

KeyBinding componentKey(const std::string& key, Component component, const std::string& help) {
  return {"Fusion", key, {key}, help, [component](Viewer& v) { v.toggle(component); }};
}

KeyBinding pclKey(const std::string& label, const std::vector<std::string>& keys, const std::string& help) {
  return {"View", label, keys, help, [](Viewer& v) { v.passKeyToPcl(); }};
}

KeyBinding formKey(const std::string& label, const std::string& key, Form form, const std::string& help) {
  return {"View", label, {key}, help, [form](Viewer& v) { v.drawAs(form); }};
}

void step(Viewer& viewer, long frames) { viewer.playback().step(frames); }

std::vector<KeyBinding> makeBindings() {
  return {
      {"Play", "Space", {"space"}, "play, pause", [](Viewer& v) { v.playback().toggle(); }},
      {"Play", "Right, Left", {"Right"}, "one frame on, back", [](Viewer& v) { step(v, 1); }},
      {"Play", "", {"Left"}, "", [](Viewer& v) { step(v, -1); }},
      {"Play", "PgDn, PgUp", {"Next"}, "ten frames on, back", [](Viewer& v) { step(v, 10); }},
      {"Play", "", {"Prior"}, "", [](Viewer& v) { step(v, -10); }},
      {"Play", "Home, End", {"Home"}, "first, last frame", [](Viewer& v) { v.playback().seek(0); }},
      {"Play", "", {"End"}, "", [](Viewer& v) { v.seekEnd(); }},
      {"Play", "], [", {"bracketright"}, "twice, half as fast", [](Viewer& v) { v.changeSpeed(2); }},
      {"Play", "", {"bracketleft"}, "", [](Viewer& v) { v.changeSpeed(0.5); }},
      {"Play", "Ctrl l", {"ctrl+l"}, "loop", [](Viewer& v) { v.playback().setLoop(!v.playback().loop()); }},
      componentKey("1", Component::MeasurementConfidence, "MF, measurement confidence"),
      componentKey("2", Component::DistanceConsistency, "DC, distance consistency"),
      componentKey("3", Component::SpatialHash, "SA, spatial hash aggregation"),
      {"Fusion", "0", {"0"}, "poses: refined as it plays, given", [](Viewer& v) { v.toggleRefinement(); }},
      {"Fusion", "k", {"k"}, "sliders: tau, sigma, cells, weight", [](Viewer& v) { v.toggleSliders(); }},
      {"Fusion", "b", {"b"}, "crop box with handles", [](Viewer& v) { v.toggleCropBox(); }},
      {"Fusion", "Backspace", {"BackSpace"}, "parameters as at the start", [](Viewer& v) { v.resetParameters(); }},
      {"Compare",
       "v",
       {"v"},
       "concatenated, PCL's grids, published,\noutlier removal, the kept one, none",
       [](Viewer& v) { v.compareWithNext(); }},
      {"Compare", "Enter", {"Return", "KP_Enter"}, "with the setting as it is now", [](Viewer& v) { v.keepSetting(); }},
      {"Compare", "d", {"d"}, "side by side, or one dragged line", [](Viewer& v) { v.toggleLayout(); }},
      colorKey("4", ColorBy::Rgb, "rgb"),
      colorKey("5", ColorBy::Confidence, "confidence"),
      colorKey("6", ColorBy::Views, "number of views"),
      colorKey("7", ColorBy::Camera, "camera of origin"),
      colorKey("8", ColorBy::TruthDistance, "distance to truth, where known"),
      colorKey("9", ColorBy::Normal, "normal"),
      {"Colour by", "l", {"l"}, "list the colours and their keys", [](Viewer& v) { v.listColors(); }},
      {"Colour by", "u", {"u"}, "legend", [](Viewer& v) { v.toggleLegend(); }},
      {"View", "r", {"r"}, "reset the camera", [](Viewer& v) { v.resetView(); }},
      {"View", "Alt r", {"alt+r"}, "from the next of the rig's cameras", [](Viewer& v) { v.lookFromNextCamera(); }},
      {"View", "f", {"f"}, "fly to the point under the cursor", [](Viewer& v) { v.flyToCursor(); }},
      {"View", "+, -", {"plus", "KP_Add"}, "larger, smaller points", [](Viewer& v) { v.changePointSize(1); }},
      {"View", "", {"minus", "KP_Subtract"}, "", [](Viewer& v) { v.changePointSize(-1); }},
      pclKey("Alt+, Alt-", {"alt+plus", "alt+minus"}, "zoom in, out"),
      pclKey("Alt f", {"alt+f"}, "largest window, and back"),
      pclKey("Alt s", {"alt+s"}, "stereo for coloured glasses"),
      pclKey("o", {"o"}, "perspective, parallel projection"),
      formKey("p, w, s", "p", Form::Points, "cameras, boxes: dots, lines, solid"),
      formKey("", "w", Form::Lines, ""),
      formKey("", "s", Form::Solid, ""),
      {"View", "g", {"g"}, "grid of metres", [](Viewer& v) { v.toggleGrid(); }},
      pclKey("c", {"c"}, "print the camera"),
      pclKey("Ctrl s, Ctrl r", {"ctrl+s", "ctrl+r"}, "save, restore the camera"),
      {"View", "a", {"a"}, "axes of the world", [](Viewer& v) { v.toggleAxes(); }},
      {"View", "n", {"n"}, "background: night, day", [](Viewer& v) { v.toggleBackground(); }},
      {"View", "y", {"y"}, "cameras and their names", [](Viewer& v) { v.toggleFrusta(); }},
      {"View", "i", {"i"}, "images of the cameras", [](Viewer& v) { v.toggleImages(); }},
      {"View", "t", {"t"}, "text", [](Viewer& v) { v.toggleText(); }},
      {"Measure", "m", {"m"}, "mark the point under the cursor", [](Viewer& v) { v.markCursor(); }},
      {"Measure", "x", {"x"}, "drag a rectangle: what is in it", [](Viewer& v) { v.toggleSelecting(); }},
      {"Measure", "Esc", {"Escape"}, "forget the marks, the rectangle", [](Viewer& v) { v.clearMarks(); }},
      {"Export",
       "Ctrl w",
       {"ctrl+w"},
       "write the clouds into --folder,\nas --format says",
       [](Viewer& v) { v.exportClouds(); }},
      {"Export", "j", {"j"}, "screenshot, and its camera", [](Viewer& v) { v.exportScreenshot(); }},
      {"Export",
       "Ctrl p",
       {"ctrl+p"},
       "film: once around (again: stop),\nor pictures: --film-format",
       [](Viewer& v) { v.toggleOrbit(); }},
      {"Program", "h", {"h"}, "this help", [](Viewer& v) { v.toggleHelp(); }},
      {"Program", "q, e", {"q", "e"}, "quit", [](Viewer& v) { v.quit(); }},
  };
}

void addLine(std::vector<std::string>& lines, const std::string& label, const std::string& help) {
  std::string shown = label;
  for (const std::string& part : linesOf(help)) {
    std::ostringstream line;
    line << "  " << std::left << std::setw(16) << shown << part;
    lines.push_back(line.str());
    shown.clear();
  }
}

std::vector<std::string> helpLines() {
  std::vector<std::string> lines;
  std::string group;
  for (const KeyBinding& binding : keyBindings()) {
    if (binding.label.empty()) continue;  // listed with its counterpart
    if (binding.group != group) lines.push_back(binding.group);
    group = binding.group;
    addLine(lines, binding.label, binding.help);
  }
  lines.push_back("Mouse");
  for (const auto& [label, help] : mouseBindings()) addLine(lines, label, help);
  lines.push_back("Unlike in pcl_viewer");
  addLine(lines, "0 ... 9", "there: its handlers of colours");
  addLine(lines, "g", "there: a scale without units");
  return lines;
}

}  // namespace

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream rest(text);
  for (std::string line; std::getline(rest, line);) lines.push_back(line);
  return lines;
}

const std::vector<KeyBinding>& keyBindings() {
  static const std::vector<KeyBinding> bindings = makeBindings();
  return bindings;
}

const KeyBinding* findBinding(const std::string& key) {
  for (const KeyBinding& binding : keyBindings())
    if (std::find(binding.keys.begin(), binding.keys.end(), key) != binding.keys.end()) return &binding;
  return nullptr;
}

const std::vector<std::pair<std::string, std::string>>& mouseBindings() {
  static const std::vector<std::pair<std::string, std::string>> bindings{
      {"left", "turn; on line, slider, handle: drag"},
      {"Ctrl left", "roll"},
      {"middle", "move"},
      {"right, wheel", "zoom"},
      {"Shift left", "mark a point; two: their distance"},
      {"rest", "what is under the cursor"},
  };
  return bindings;
}

std::string helpText() {
  const std::vector<std::string> lines = helpLines();
  // The second column begins with the group that begins nearest to the middle.
  const std::size_t middle = lines.size() / 2;
  std::size_t left = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const auto away = [middle](std::size_t line) { return line > middle ? line - middle : middle - line; };
    if (lines[k].front() != ' ' && away(k) < away(left)) left = k;
  }
  std::ostringstream text;
  for (std::size_t row = 0; row < left || left + row < lines.size(); ++row) {
    const std::string second = left + row < lines.size() ? lines[left + row] : "";
    text << (row > 0 ? "\n " : " ") << std::left << std::setw(56) << (row < left ? lines[row] : "") << std::setw(56)
         << second;
  }
  return text.str();
}

}  // namespace fuse_flow::viewing
