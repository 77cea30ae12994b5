#include "viewer/viewer.h"

#include "io/tool.h"
#include "viewer/key_bindings.h"

#include <algorithm>
#include <cmath>
#include <thread>

namespace fuse_flow::viewing {
namespace {

constexpr std::chrono::milliseconds kTick{5};  // between two looks for events
constexpr double kRest = 0.08;                 // seconds: a cursor that rests so long asks what is under it
constexpr double kRefine = 0.25;               // seconds: all points again, so long after the view moved
constexpr double kMoving = 0.02;               // seconds that a picture of a moving view may take
constexpr double kSettling = 0.1;              // weight of the newest in a running mean
constexpr std::size_t kFewPoints = 20000;      // too few to tell how fast points are drawn

/** \brief A running mean, which begins with its first value. */
void average(double& mean, double value) { mean = mean > 0 ? mean + kSettling * (value - mean) : value; }

double seconds(std::chrono::steady_clock::duration d) { return std::chrono::duration<double>(d).count(); }

}  // namespace

Viewer::Viewer(std::unique_ptr<FrameSource> source, const ViewerOptions& options)
    : options_(options),
      knows_truth_(source->knowsTruth()),
      playback_(source->frameCount(), options.frames_per_second),
      controls_(options.method, options.method_options),
      window_("FUSE-Flow: " + source->name(), options.width, options.height, options.offscreen),
      panes_(window_),
      overlay_(window_),
      frusta_(panes_),
      axes_(panes_),
      probe_(panes_),
      sliders_(window_,
               [this](const SliderParameter& parameter, float value) {
                 changeParameters([&](FuseFlowParameters& p) { parameter.member(p) = value; });
               }),
      crop_box_(window_, panes_,
                [this](const Eigen::AlignedBox3f& box) {
                  changeParameters([&](FuseFlowParameters& p) { p.crop_box = box; });
                }),
      worker_(std::move(source)),
      color_by_(options.color_by),
      point_size_(options.point_size),
      last_tick_(Clock::now()),
      last_cloud_(Clock::now()) {
  playback_.setSpeed(options.speed);
  playback_.setLoop(options.loop);
  playback_.seek(options.first_frame);
  if (options.play) playback_.play();
  controls_.compareWith(options.compare);
  panes_.setLayout(options.layout);
  panes_.setSplit(options.split);
  panes_.setComparing(controls_.comparison() != nullptr);
  panes_.setPointSize(point_size_);
  day_ = true;
  toggleBackground();
  sliders_.setValues(controls_.parameters());
  updateLegend();
  connectEvents();
}

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

/** \brief An event loop of our own: VTK's, once told to end, still asks a display that it has closed. */
void Viewer::run() {
  last_tick_ = Clock::now();
  while (!quitting_ && !io::interrupt_requested) {
    window_.interactor()->ProcessEvents();
    const Clock::time_point now = Clock::now();
    try {
      tick(seconds(now - last_tick_));
    } catch (const std::exception& error) {
      say(error.what());
    }
    last_tick_ = now;
    std::this_thread::sleep_for(kTick);
  }
}

void Viewer::onExit(vtkObject*, unsigned long, void*) { quit(); }

void Viewer::tick(double elapsed) {
  if (quitting_) return;
  if (!orbit_) playback_.advance(elapsed);
  postWhatIsWanted();
  if (const auto answer = worker_.take()) show(**answer);
  if (arranged_size_ != std::array<int, 2>{window_.width(), window_.height()}) arrange();
  rest_seconds_ += elapsed;
  if (!cursor_probed_ && !interacting_ && rest_seconds_ > kRest) probeCursor();
  if (message_seconds_ > 0 && (message_seconds_ -= elapsed) <= 0) say(error_);
  if (refine_in_ >= 0 && !interacting_ && (refine_in_ -= elapsed) < 0) {
    panes_.setCoarse(false);
    dirty_ = true;
  }
  if (orbit_) stepOrbit();
  if (dirty_) render();
}

FusionRequest Viewer::wanted() const {
  FusionRequest request;
  request.frame = playback_.frame();
  request.settings = {controls_.fused(), controls_.comparison()};
  request.color_by = color_by_;
  request.measure_quality = show_text_;
  request.coarse_points = coarse_points_;
  return request;
}

void Viewer::postWhatIsWanted() {
  FusionRequest request = wanted();
  if (posted_ && request.frame == posted_->frame && request.settings == posted_->settings &&
      request.color_by == posted_->color_by && request.measure_quality == posted_->measure_quality &&
      request.coarse_points == posted_->coarse_points)
    return;
  request.number = posted_ ? posted_->number + 1 : 1;
  posted_ = request;
  worker_.post(std::move(request));
}

void Viewer::settle() {
  postWhatIsWanted();
  while (answered_ != posted_->number)
    if (const auto answer = worker_.wait()) show(**answer);
  panes_.setCoarse(false);
  refine_in_ = -1;
  arrange();
  render();
}

void Viewer::show(const FusedFrame& frame) {
  answered_ = frame.number;
  error_ = frame.error;
  if (!frame.error.empty()) {
    say(frame.error);
    if (frame.ended && frame.frame > 0) {
      playback_.endAt(frame.frame);
      say(frame.error + "; the recording is played up to there");
    }
    return;
  }
  if (message_seconds_ <= 0) say("");
  const bool first = !shown_;
  shown_ = std::make_shared<const FusedFrame>(frame);
  const Clock::time_point now = Clock::now();
  average(rates_.clouds, 1 / std::max(1e-3, seconds(now - last_cloud_)));
  last_cloud_ = now;
  for (std::size_t k = 0; k < kPanes; ++k) {
    panes_.setCloud(k, frame.clouds[k]);
    overlay_.setTitle(k, frame.clouds[k] ? frame.clouds[k]->setting->title : "");
  }
  frusta_.setCameras(frame.cameras);
  std::vector<std::string> names;
  for (const Camera& camera : frame.cameras) names.push_back(camera.name);
  if (show_images_) overlay_.setImages(frame.thumbnails, names);
  if (color_by_ == ColorBy::Camera) updateLegend();
  cursor_probed_ = false;
  if (frame.clouds[0]) axes_.setExtent(*frame.clouds[0]->cloud);
  first ? resetView() : panes_.fitClippingRange();
  updateStatus();
  if (first) arrange();
  dirty_ = true;
}

void Viewer::render() {
  dirty_ = false;
  window_.renderWindow()->Render();
}

void Viewer::onRenderStart(vtkObject*, unsigned long, void*) { render_start_ = Clock::now(); }

/** \brief Learns how many points can be drawn while the view moves. */
void Viewer::onRenderEnd(vtkObject*, unsigned long, void*) {
  window_.renderWindow()->WaitForCompletion();
  const double taken = std::max(1e-4, seconds(Clock::now() - render_start_));
  average(rates_.pictures, 1 / taken);
  std::size_t drawn = 0;
  for (std::size_t k = 0; k < kPanes; ++k)
    if (panes_.cloud(k)) drawn += panes_.cloud(k)->points->GetNumberOfPoints();
  if (drawn < kFewPoints || refine_in_ >= 0 || interacting_) return;
  const double budget = static_cast<double>(drawn) * kMoving / taken;
  const double change = budget / static_cast<double>(coarse_points_);
  const auto most = static_cast<double>(drawn);
  if (change > 1.5 || change < 0.7)
    coarse_points_ = static_cast<std::size_t>(std::clamp(budget, static_cast<double>(kFewPoints), 2 * most));
}

void Viewer::onInteractionStart(vtkObject*, unsigned long, void*) {
  interacting_ = true;
  panes_.setCoarse(true);
}

void Viewer::onInteractionEnd(vtkObject*, unsigned long, void*) {
  interacting_ = false;
  refine_in_ = kRefine;
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
  if (!dragging_split_) return false;
  panes_.setSplit(static_cast<double>(window_.interactor()->GetEventPosition()[0]) / window_.width());
  arrange();
  return true;
}

bool Viewer::onRelease() { return std::exchange(dragging_split_, false); }

void Viewer::arrange() {
  arranged_size_ = {window_.width(), window_.height()};
  overlay_.arrange(panes_);
  sliders_.arrange();
  dirty_ = true;
}

void Viewer::probeCursor() {
  cursor_probed_ = true;
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

void Viewer::updateStatus() {
  if (shown_ && show_text_) overlay_.setStatus(statusText(playback_, rates_, controls_, *shown_));
}

void Viewer::updateLegend() {
  std::vector<std::string> names;
  if (shown_)
    for (const Camera& camera : shown_->cameras) names.push_back(camera.name);
  overlay_.setLegend(legendOf(color_by_, names));
}

void Viewer::say(const std::string& message) {
  message_ = message;
  message_seconds_ = message.empty() ? 0 : 6;
  overlay_.setMessage(message);
  dirty_ = true;
}

}  // namespace fuse_flow::viewing
