#include "viewer/key_bindings.h"
#include "viewer/viewer.h"

#include <algorithm>
#include <cctype>

namespace fuse_flow::viewing {
namespace {

constexpr double kRefine = 0.25;           // seconds: all points again, so long after the view moved
constexpr double kMoving = 0.02;           // seconds that a picture of a moving view may take
constexpr std::size_t kFewPoints = 20000;  // too few to tell how fast points are drawn

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
}

void Viewer::onExit(vtkObject*, unsigned long, void*) { quit(); }

void Viewer::onRenderStart(vtkObject*, unsigned long, void*) { render_start_ = Clock::now(); }

/** \brief Learns how many points can be drawn while the view moves. */
void Viewer::onRenderEnd(vtkObject*, unsigned long, void*) {
  window_.renderWindow()->WaitForCompletion();
  const Clock::duration taken = Clock::now() - render_start_;
  picture_rate_.add(taken);
  if (refine_in_ >= 0 || interacting_) return;
  std::size_t drawn = 0, largest = 0, clouds = 0;
  for (std::size_t k = 0; k < kPanes; ++k) {
    if (!panes_.cloud(k)) continue;
    ++clouds;
    drawn += panes_.cloud(k)->cloud->size();
    largest = std::max(largest, panes_.cloud(k)->cloud->size());
  }
  if (drawn < kFewPoints) return;
  const double budget = static_cast<double>(drawn) * kMoving / std::chrono::duration<double>(taken).count();
  const std::size_t each = std::max(kFewPoints, static_cast<std::size_t>(budget / static_cast<double>(clouds)));
  if (std::min(each, coarse_points_) >= largest) return;  // nothing is left out, then or now
  const double change = static_cast<double>(each) / static_cast<double>(coarse_points_);
  if (change > 1.5 || change < 0.7) coarse_points_ = each;  // else the clouds would be thinned anew all the time
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

void Viewer::viewMoves() {
  panes_.setCoarse(true);
  refine_in_ = kRefine;
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
  updateStatus();
  dirty_ = true;
}

bool Viewer::onPress() {
  const int x = window_.interactor()->GetEventPosition()[0];
  if (window_.interactor()->GetShiftKey()) {
    markCursor();
    return true;
  }
  dragging_split_ = panes_.nearSplit(x);
  return dragging_split_;
}

bool Viewer::onMove() {
  rest_seconds_ = 0;
  cursor_probed_ = false;
  cursor_seen_ = true;
  if (!dragging_split_) return false;
  panes_.setSplit(static_cast<double>(window_.interactor()->GetEventPosition()[0]) / window_.width());
  viewMoves();
  arrange();
  return true;
}

bool Viewer::onRelease() { return std::exchange(dragging_split_, false); }

void Viewer::probeCursor() {
  cursor_probed_ = true;
  if (!cursor_seen_) return;
  const int* at = window_.interactor()->GetEventPosition();
  const std::optional<PickedPoint> point = probe_.pick(at[0], at[1]);
  std::string text = point ? probe_.describe(*point) : "";
  if (const std::optional<double> distance = probe_.distance()) {
    char marked[64];
    std::snprintf(marked, sizeof(marked), "marked: %.1f mm apart", 1000 * *distance);
    text += (text.empty() ? "" : "\n") + std::string(marked);
  }
  overlay_.setReadout(text);
  dirty_ = true;
}

}  // namespace fuse_flow::viewing
