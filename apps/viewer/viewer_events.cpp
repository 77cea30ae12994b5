#include "viewer/controls/key_bindings.h"
#include "viewer/viewer.h"

#include <algorithm>
#include <cctype>

namespace fuse_flow::viewing {
namespace {

constexpr double kMoving = 0.02;      // seconds that a picture of a moving view may take
constexpr double kFewPoints = 20000;  // too few to tell how fast points are drawn

}  // namespace

void Viewer::connectEvents() {
  ViewerStyle* style = window_.style();
  style->on_key = [this] { onKey(); };
  style->on_press = [this] { return onPress(); };
  style->on_move = [this] { return onMove(); };
  style->on_release = [this] { return onRelease(); };
  style->AddObserver(vtkCommand::StartInteractionEvent, this, &Viewer::onInteractionStart);
  style->AddObserver(vtkCommand::EndInteractionEvent, this, &Viewer::onInteractionEnd);
  window_.renderWindow()->AddObserver(vtkCommand::StartEvent, this, &Viewer::onRenderStart);
  window_.renderWindow()->AddObserver(vtkCommand::EndEvent, this, &Viewer::onRenderEnd);
  window_.interactor()->AddObserver(vtkCommand::ExitEvent, this, &Viewer::onExit);
  window_.interactor()->AddObserver(vtkCommand::LeaveEvent, this, &Viewer::onLeave);
}

void Viewer::onExit(vtkObject*, unsigned long, void*) { quit(); }

void Viewer::onLeave(vtkObject*, unsigned long, void*) {
  cursor_seen_ = false;
  updateReadout(std::nullopt);
}

void Viewer::onRenderStart(vtkObject*, unsigned long, void*) { render_start_ = Clock::now(); }

/** \brief Learns how many points can be drawn while the view moves. */
void Viewer::onRenderEnd(vtkObject*, unsigned long, void*) {
  window_.renderWindow()->WaitForCompletion();
  if (window_.renderWindow()->GetAbortRender()) return;
  const Clock::duration taken = Clock::now() - render_start_;
  picture_rate_.add(taken);
  if (!panes_.coarse()) outdated_ = false;
  const auto all = static_cast<double>(panes_.allPoints()), drawn = static_cast<double>(panes_.drawnPoints());
  if (drawn < kFewPoints) return;
  const double could = drawn * kMoving / std::chrono::duration<double>(taken).count();
  if (!panes_.coarse())
    coarse_points_ = could >= all ? std::max(all, coarse_points_) : std::min(could, coarse_points_);
  else if (could >= all)
    coarse_points_ = all;
  else if (could < drawn || could > 1.25 * drawn)
    coarse_points_ = drawn * std::clamp(could / drawn, 0.5, 1.5);
  coarse_points_ = std::max(coarse_points_, kFewPoints);
  panes_.setCoarsePoints(static_cast<std::size_t>(coarse_points_));
}

void Viewer::onInteractionStart(vtkObject*, unsigned long, void*) {
  interacting_ = true;
  panes_.setCoarse(true);
}

void Viewer::onInteractionEnd(vtkObject*, unsigned long, void*) {
  interacting_ = false;
  viewMoves();
  cursor_probed_ = false;
}

void Viewer::onKey() {
  vtkRenderWindowInteractor* interactor = window_.interactor();
  std::string key = interactor->GetKeySym() ? interactor->GetKeySym() : "";
  if (key.size() == 1) key[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(key[0])));
  if (interactor->GetControlKey()) key = "ctrl+" + key;
  if (interactor->GetAltKey()) key = "alt+" + key;
  const KeyBinding* binding = findBinding(key);
  if (!binding) return;
  try {
    binding->action(*this);
  } catch (const std::exception& error) {
    say(error.what());
  }
  cursor_probed_ = false;  // another pane, or another point, may be under it
  updateStatus();
  redraw();
}

bool Viewer::onPress() {
  const int* at = window_.interactor()->GetEventPosition();
  if (window_.interactor()->GetShiftKey()) {
    markCursor();
    return true;
  }
  if (selecting_) {
    rubber_band_.begin({at[0], at[1]});
    return true;
  }
  dragging_split_ = panes_.nearSplit(at[0]);
  return dragging_split_;
}

bool Viewer::onMove() {
  rest_seconds_ = 0;
  cursor_probed_ = false;
  cursor_seen_ = true;
  updateReadout(std::nullopt);
  if (rubber_band_.dragged()) {
    const int* at = window_.interactor()->GetEventPosition();
    rubber_band_.moveTo({at[0], at[1]});
    viewMoves();
    dirty_ = true;
    return true;
  }
  if (!dragging_split_) return false;
  panes_.setSplit(static_cast<double>(window_.interactor()->GetEventPosition()[0]) / window_.width());
  viewMoves();
  arrange();
  return true;
}

bool Viewer::onRelease() {
  if (rubber_band_.dragged()) {
    const auto [from, to] = rubber_band_.end();
    say(probe_.describe(probe_.select(from, to)));
    return true;
  }
  return std::exchange(dragging_split_, false);
}

void Viewer::probeCursor() {
  cursor_probed_ = true;
  const int* at = window_.interactor()->GetEventPosition();
  updateReadout(cursor_seen_ ? probe_.pick(at[0], at[1]) : std::nullopt);
}

void Viewer::updateReadout(const std::optional<PickedPoint>& point) {
  std::string text = point ? probe_.describe(*point) : "";
  std::string marked;
  if (const std::optional<double> distance = probe_.distance()) {
    char apart[64];
    std::snprintf(apart, sizeof(apart), "marked: %.1f mm apart", 1000 * *distance);
    marked = apart;
  } else if (probe_.marks() == 1) {
    marked = "marked: one point; a second one tells their distance";
  }
  if (selecting_) marked += std::string(marked.empty() ? "" : "\n") + "x: the left button drags a rectangle";
  if (!marked.empty()) text += (text.empty() ? "" : "\n") + marked;
  if (text == overlay_.readout()) return;
  overlay_.setReadout(text);
  dirty_ = true;
}

}  // namespace fuse_flow::viewing
