#include "viewer/viewer.h"

#include "drawing/display.h"
#include "recordings/files/interrupt.h"

#include <algorithm>
#include <thread>

namespace fuse_flow::viewing {
namespace {

constexpr std::chrono::milliseconds kTick{5};  // between two looks for events
constexpr double kRest = 0.08;                 // seconds: a cursor that rests so long asks what is under it
constexpr double kRefine = 0.25;               // seconds: all points again, so long after the view moved
constexpr double kAwaited = 0.3;               // seconds: a picture that takes longer is said to be awaited

}  // namespace

Viewer::Viewer(std::unique_ptr<FrameSource> source, const ViewerOptions& options)
    : options_(options),
      knows_truth_(source->knowsTruth()),
      finished_(source->isFinished()),
      playback_(source->frameCount(),
                options.frames_per_second.value_or(source->framesPerSecond().value_or(kFramesPerSecond))),
      controls_(options.method, options.method_options),
      window_("FUSE-Flow: " + source->name(), options.width, options.height, options.offscreen),
      panes_(window_, [this] { onSlice(); }),
      overlay_(window_),
      frusta_(panes_),
      axes_(panes_),
      probe_(panes_),
      rubber_band_(window_),
      sliders_(window_,
               [this](const SliderParameter& parameter, float value) {
                 changeParameters([&](FuseFlowParameters& p) { setParameter(parameter, value, p); });
                 sliders_.setValues(controls_.parameters());
               }),
      crop_box_(window_, panes_,
                [this](const Eigen::AlignedBox3f& box) {
                  changeParameters([&](FuseFlowParameters& p) { p.crop_box = box; });
                }),
      timeline_(window_, [this](std::size_t frame) { playback_.seek(frame); }),
      worker_(std::move(source)),
      refine_extrinsics_(options.refine_extrinsics),
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
  connectEvents();
}

/** \brief The viewer's own event loop: after its end, VTK's loop still asks a display that it has closed. */
void Viewer::run(const std::function<bool()>& ended) {
  last_tick_ = Clock::now();
  if (!somebody_waits_) setInterrupt([this] { return drawing::eventsWait(window_.renderWindow()); });
  if (!shown_) overlay_.setStatus("the first frame is being read and fused ...");
  if (message_.empty()) say("h: what keys and mouse do");
  while (!quitting_ && !io::interrupt_requested && !(ended && ended())) {
    window_.interactor()->ProcessEvents();
    const Clock::time_point now = Clock::now();
    try {
      tick(std::chrono::duration<double>(now - last_tick_).count());
    } catch (const std::exception& error) {
      say(error.what());
    }
    last_tick_ = now;
    std::this_thread::sleep_for(kTick);
  }
  orbit_.reset();                         // a film ends here, and is whole
  drawing::hide(window_.renderWindow());  // the rest may take its time on a busy machine
}

void Viewer::tick(double elapsed) {
  if (quitting_) return;
  if (!orbit_) playback_.advance(elapsed);
  postWhatIsWanted();
  if (const auto answer = worker_.take()) show(*answer);
  if (arranged_size_ != std::array<int, 2>{window_.width(), window_.height()}) arrange();
  rest_seconds_ += elapsed;
  await(elapsed);
  if (!cursor_probed_ && !interacting_ && rest_seconds_ > kRest) probeCursor();
  if (message_seconds_ > 0 && (message_seconds_ -= elapsed) <= 0) say(error_);
  if (refine_in_ >= 0 && !interacting_ && (refine_in_ -= elapsed) < 0) {
    panes_.setCoarse(false);
    dirty_ = true;
  }
  if (orbit_) stepOrbit();
  if (dirty_) renderUnlessInterrupted();
}

void Viewer::renderUnlessInterrupted() {
  interruptible_ = !panes_.coarse();
  render();
  interruptible_ = false;
  if (!window_.renderWindow()->GetAbortRender()) return;
  refine_in_ = kRefine;  // the window still shows the picture before
  if (!outdated_) return;
  panes_.setCoarse(true);
  dirty_ = true;
}

void Viewer::onSlice() {
  if (!interruptible_ || !somebody_waits_) return;
  // Else all slices wait in the driver's queue soon, and none can be called back.
  window_.renderWindow()->WaitForCompletion();
  if (somebody_waits_()) window_.renderWindow()->SetAbortRender(1);
}

FusionRequest Viewer::wanted() const {
  FusionRequest request;
  request.frame = playback_.frame();
  request.settings = {controls_.fused(), controls_.comparison()};
  request.color_by = color_by_;
  request.refine_extrinsics = refine_extrinsics_;
  request.measure_quality = show_text_ && options_.measure;
  return request;
}

void Viewer::postWhatIsWanted() {
  FusionRequest request = wanted();
  if (posted_ && request.frame == posted_->frame && request.settings == posted_->settings &&
      request.color_by == posted_->color_by && request.refine_extrinsics == posted_->refine_extrinsics &&
      request.measure_quality == posted_->measure_quality)
    return;
  request.number = posted_ ? posted_->number + 1 : 1;
  posted_ = request;
  worker_.post(std::move(request));
}

bool Viewer::awaited() const { return posted_ && answered_ != posted_->number; }

/** \brief Where frames follow each other, a next one is always awaited. */
void Viewer::await(double elapsed) {
  const double before = awaited_seconds_;
  awaited_seconds_ = awaited() && !playback_.playing() ? before + elapsed : 0;
  if (!(awaited_seconds_ > kAwaited) || before > kAwaited) return;
  updateStatus();
  dirty_ = true;
}

void Viewer::viewMoves() {
  panes_.setCoarse(true);
  refine_in_ = kRefine;
}

void Viewer::settle() {
  postWhatIsWanted();
  while (answered_ != posted_->number)
    if (const auto answer = worker_.wait()) show(*answer);
  panes_.setCoarse(false);
  refine_in_ = -1;
  if (!cursor_probed_) probeCursor();
  arrange();
  render();
}

void Viewer::show(const std::shared_ptr<const FusedFrame>& answer) {
  const FusedFrame& frame = *answer;
  answered_ = frame.number;
  error_ = frame.error;
  for (const std::string& damage : frame.damaged) complain(frameName(frame.frame) + ": " + damage);
  if (!frame.error.empty()) {
    complain(frame.error);
    updateStatus();
    return;
  }
  if (message_seconds_ <= 0) say("");
  const bool first = !shown_;
  const bool colored_anew = first || shown_->color_by != frame.color_by || frame.color_by == ColorBy::Camera;
  shown_ = answer;
  const Clock::time_point now = Clock::now();
  cloud_rate_.add(now - last_cloud_);
  last_cloud_ = now;
  for (std::size_t k = 0; k < kPanes; ++k) panes_.setCloud(k, frame.clouds[k]);
  frusta_.setCameras(frame.cameras);
  std::vector<std::string> names;
  for (const Camera& camera : frame.cameras) names.push_back(camera.name);
  overlay_.setImages(frame.thumbnails, frame.thumbnails.empty() ? std::vector<std::string>() : names);
  if (colored_anew) overlay_.setLegend(legendOf(frame.color_by, names));
  updateReadout(std::nullopt);  // what it said is of the cloud before; the next tick() asks again
  cursor_probed_ = false;
  if (const auto bounds = panes_.bounds(0)) axes_.setExtent(bounds->data());
  first ? resetView() : panes_.fitClippingRange();
  timeline_.setFrame(frame.frame, playback_.frames());
  updateStatus();
  arrange();
}

void Viewer::render() {
  dirty_ = false;
  window_.renderWindow()->Render();
}

void Viewer::arrange() {
  arranged_size_ = {window_.width(), window_.height()};
  updateHeadings();
  overlay_.arrange(panes_, sliders_.visible() ? sliders_.takenWidth() : 0);
  sliders_.arrange(overlay_.aboveTitles());
  timeline_.arrange(overlay_.aboveImages() + 18);
  redraw();
}

void Viewer::updateStatus() {
  if (playback_.playing()) rates_ = {cloud_rate_.perSecond(), picture_rate_.perSecond()};
  if (shown_ && show_text_)
    overlay_.setStatus(statusText(playback_, rates_, *shown_, awaited() && !playback_.playing()));
}

/** \brief Of what is in the panes, which may not be yet what was asked for. */
void Viewer::updateHeadings() {
  for (std::size_t k = 0; k < kPanes; ++k) {
    const std::shared_ptr<const FusedCloud>& cloud = panes_.cloud(k);
    const bool drawn = shown_ && cloud && (k == 0 || panes_.comparing());
    const bool awaited = shown_ && !cloud && k == 1 && controls_.comparison();
    overlay_.setTitle(k, drawn     ? headingOf(*cloud, shown_->color_by, panes_.comparing())
                         : awaited ? controls_.comparison()->title + ": being fused ..."
                                   : "");
  }
}

void Viewer::complain(const std::string& problem) {
  if (std::find(problems_.begin(), problems_.end(), problem) == problems_.end()) problems_.push_back(problem);
  say(problem);
}

void Viewer::say(const std::string& message) {
  message_ = message;
  message_seconds_ = message.empty() ? 0 : 6;
  overlay_.setMessage(message);
  dirty_ = true;
}

}  // namespace fuse_flow::viewing
