#include "live/live_rig.h"

#include "recordings/messages/rig_messages.h"

#include <algorithm>
#include <cstdio>
#include <set>
#include <utility>

namespace fuse_flow::io {
namespace {

constexpr std::chrono::microseconds kRateWindow{2000000};

double secondsOf(std::chrono::microseconds duration) { return 1e-6 * static_cast<double>(duration.count()); }

std::string seconds(std::chrono::microseconds duration) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", secondsOf(duration));
  return text;
}

/** \brief What stamps of a recording should be, and does not jump when somebody sets the clock. */
std::function<std::chrono::microseconds()> timeOfDay() {
  const auto day = std::chrono::system_clock::now().time_since_epoch();
  const auto start = std::chrono::steady_clock::now();
  return [day, start] {
    return std::chrono::duration_cast<std::chrono::microseconds>(day + (std::chrono::steady_clock::now() - start));
  };
}

/** \brief Of a colour camera, whose description may be that of a depth camera with colour. */
void takeIntrinsics(const std::string& file, const Camera& calibrated, Camera& camera) {
  const Intrinsics& K = calibrated.color ? calibrated.color->intrinsics : calibrated.intrinsics;
  const auto sizeOf = [](const Intrinsics& of) { return std::to_string(of.width) + "x" + std::to_string(of.height); };
  if (K.width != camera.intrinsics.width || K.height != camera.intrinsics.height)
    throw InputError(file + ": has the intrinsics of " + sizeOf(K) + " pixels for camera '" + camera.name +
                     "', which delivers " + sizeOf(camera.intrinsics) + "; must be of the same size");
  camera.intrinsics = calibrated.intrinsics;
  camera.color = calibrated.color;
}

/** \brief Names the cameras that are calibrated and do not run, a line; empty: all run. Of two cameras that are called alike the second has a number, see
 *  unused(): without one of them nobody knows which is left, and where it stands. */
std::string notRunning(const std::string& file, const std::vector<Camera>& cameras,
                       const std::vector<RigCamera>& calibrated) {
  std::set<std::string> run;
  for (const Camera& camera : cameras) run.insert(camera.name);
  std::string names;
  for (const RigCamera& entry : calibrated) {
    const std::string& name = entry.camera.name;
    if (calibrated.size() <= cameras.size() || run.count(name) > 0) continue;
    names += (names.empty() ? "'" : ", '") + name + "'";
    const std::size_t number = name.rfind('_');
    if (number == std::string::npos || name.find_first_not_of("0123456789", number + 1) != std::string::npos) continue;
    if (const std::string alike = name.substr(0, number); run.count(alike) > 0)
      throw InputError(file + ": has cameras '" + alike + "' and '" + name +
                       "', and not all of this name run: nobody knows which; cameras of several computers that may be "
                       "left out must have different names");
  }
  return names.empty() ? "" : file + ": has cameras that do not run: " + names + "; the others are fused without them";
}

/** \brief "left", or "left_2" if that is taken. */
std::string unused(const std::string& name, const std::set<std::string>& taken) {
  if (taken.count(name) == 0) return name;
  for (int k = 2;; ++k)
    if (std::string other = name + "_" + std::to_string(k); taken.count(other) == 0) return other;
}

}  // namespace

void LiveInstant::setView(std::size_t camera, std::shared_ptr<const LoadedView> images) {
  held[camera] = std::move(images);
  DepthView& view = rig.views[camera];
  view.depth16 = held[camera]->depth16.view();
  view.depth32 = held[camera]->depth32.view();
  view.color = held[camera]->color.view();
  view.confidence = held[camera]->confidence.view();
}

LiveRig::LiveRig(std::vector<std::unique_ptr<CameraSource>> sources, const Options& options)
    : sources_(std::move(sources)), options_(options) {
  if (!options_.clock) options_.clock = timeOfDay();
  std::set<std::string> names;
  for (const std::unique_ptr<CameraSource>& source : sources_)
    for (std::size_t k = 0; k < source->cameras().size(); ++k) {
      Camera camera = source->cameras()[k];
      // A device's name becomes that which a recording of it will have.
      camera.name = unused(source->hasPoses() ? camera.name : nameInRos(camera.name), names);
      names.insert(camera.name);
      cameras_.push_back(std::move(camera));
      posed_.push_back(source->hasPoses());
      has_color_.push_back(source->hasColor(k));
      has_intrinsics_.push_back(source->hasIntrinsics(k));
      lacks_depth_.push_back(!source->hasDepth(k));
      source_of_.push_back(source.get());
    }
  if (cameras_.empty()) throw InputError("there is no camera");
  streams_.resize(cameras_.size());
  const bool shared = (sources_.size() == 1 || options_.one_clock) &&
                      std::all_of(sources_.begin(), sources_.end(), [](const std::unique_ptr<CameraSource>& source) {
                        return source->clocks() == ClockModel::Shared;
                      });
  options_.synchronizer.clocks = shared ? ClockModel::Shared : ClockModel::Separate;
  synchronizer_ = std::make_unique<ViewSynchronizer<Payload>>(cameras_.size(), options_.synchronizer, options_.clock);
}

LiveRig::~LiveRig() { stop(); }

void LiveRig::setPoses(const std::string& file, const std::vector<RigCamera>& calibrated) {
  std::vector<const RigCamera*> entries;
  for (const Camera& camera : cameras_) {
    const auto same = std::find_if(calibrated.begin(), calibrated.end(),
                                   [&](const RigCamera& entry) { return entry.camera.name == camera.name; });
    if (same != calibrated.end()) entries.push_back(&*same);
  }
  if (entries.empty() && calibrated.size() == cameras_.size()) {  // named by somebody: in the order of the cameras
    for (const RigCamera& entry : calibrated) entries.push_back(&entry);
    warnings_.push_back(file + ": has other names than the cameras, '" + cameras_[0].name +
                        "' and so on, and is taken to be in their order");
  }
  if (entries.size() != cameras_.size()) {
    std::string names;
    for (const Camera& camera : cameras_) names += (names.empty() ? "'" : ", '") + camera.name + "'";
    throw InputError(file + ": must have the cameras that run: " + names);
  }
  if (std::string missing = notRunning(file, cameras_, calibrated); !missing.empty())
    warnings_.push_back(std::move(missing));
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    const RigCamera& entry = *entries[k];
    if (!entry.depth.isZ())
      throw InputError(file + ": camera '" + entry.camera.name +
                       "' has depth_is or depth_offset, which cameras that run must not have: their depth is z");
    Camera& camera = cameras_[k];
    camera.T_world_camera = entry.camera.T_world_camera;
    camera.depth_correction = entry.camera.depth_correction;
    camera.multipath = entry.camera.multipath;
    if (entry.camera.noise) camera.noise = entry.camera.noise;
    if (!has_intrinsics_[k]) takeIntrinsics(file, entry.camera, camera);
    posed_[k] = has_intrinsics_[k] = true;
  }
}

std::vector<std::string> LiveRig::withoutPoses() const {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < cameras_.size(); ++k)
    if (!posed_[k] && cameras_.size() > 1) names.push_back(cameras_[k].name);
  return names;
}

std::vector<std::string> LiveRig::withoutIntrinsics() const {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < cameras_.size(); ++k)
    if (!has_intrinsics_[k]) names.push_back(cameras_[k].name);
  return names;
}

std::vector<std::string> LiveRig::inputs() const {
  std::vector<std::string> files;
  for (const std::unique_ptr<CameraSource>& source : sources_)
    for (std::string& file : source->inputs()) files.push_back(std::move(file));
  return files;
}

std::vector<std::string> LiveRig::warnings() const {
  std::vector<std::string> lines = warnings_;
  for (const std::unique_ptr<CameraSource>& source : sources_)
    lines.insert(lines.end(), source->warnings().begin(), source->warnings().end());
  return lines;
}

void LiveRig::start() {
  const auto begin = [this] {
    const std::lock_guard<std::mutex> lock(mutex_);
    started_ = now();
  };
  begin();
  std::size_t first = 0;
  for (const std::unique_ptr<CameraSource>& source : sources_) {
    CameraSource::Receiver receiver;
    receiver.view = [this, first](CameraView view) {
      view.camera += first;
      receive(std::move(view));
    };
    receiver.notice = [this](const std::string& line) { notice(line); };
    source->start(receiver);
    first += source->cameras().size();
  }
  begin();  // some take their time
}

void LiveRig::stop() {
  for (const std::unique_ptr<CameraSource>& source : sources_) source->stop();
}

bool LiveRig::running() const {
  bool any = false;
  for (const std::unique_ptr<CameraSource>& source : sources_) {
    const bool runs = source->running();
    if (!runs)
      if (const std::string failure = source->failure(); !failure.empty()) throw InputError(failure);
    any = any || runs;
  }
  return any;
}

void LiveRig::receive(CameraView view) {
  const Microseconds arrival = now() - view.age;
  const std::size_t camera = view.camera;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Stream& stream = streams_[camera];
    ++stream.received;
    stream.arrivals.push_back(arrival);
    while (stream.arrivals.front() + kRateWindow < arrival) stream.arrivals.pop_front();
    if (stream.silent)
      notices_.push_back("camera '" + cameras_[camera].name + "' delivers" + (stream.last ? " again" : "") +
                         ", after " + seconds(arrival - stream.last.value_or(started_)));
    if (stream.last && !stream.silent) {
      const Microseconds gap = arrival - *stream.last;
      stream.usual_gap = stream.usual_gap.count() == 0 ? gap : stream.usual_gap + (gap - stream.usual_gap) / 8;
    }
    stream.silent = false;
    stream.last = arrival;
    if (stream.stamp && view.stamp > *stream.stamp && view.stamp - *stream.stamp < (std::uint64_t{1} << 62))
      stream.lost +=
          static_cast<std::uint64_t>(stream.period.lostIn(static_cast<std::int64_t>(view.stamp - *stream.stamp)));
    stream.stamp = view.stamp;
  }
  synchronizer_->push(camera, view.stamp, {view.images, arrival}, arrival);
  if (!listener_) return;
  std::uint64_t time = view.stamp;
  if (options_.synchronizer.clocks == ClockModel::Separate) {
    time += static_cast<std::uint64_t>(synchronizer_->getStatistics().cameras[camera].offset.count());
    const std::lock_guard<std::mutex> lock(mutex_);
    // The estimate of the offset falls as views come that were on their way for a shorter time.
    time = streams_[camera].heard = std::max(time, streams_[camera].heard + 1);
  }
  listener_(camera, time, view);
}

LiveRig::Microseconds LiveRig::patience(const Stream& stream) const {
  return std::max(Microseconds(static_cast<std::int64_t>(1e6 * options_.silent_after)), 3 * stream.usual_gap);
}

void LiveRig::notice(const std::string& line) {
  const std::lock_guard<std::mutex> lock(mutex_);
  notices_.push_back(line);
}

bool LiveRig::next(std::chrono::milliseconds timeout, LiveInstant& instant) {
  auto set = synchronizer_->wait(timeout);
  if (!set) return false;
  instant.rig.stamp = set->stamp;
  instant.rig.cameras = cameras_;
  instant.rig.views.assign(cameras_.size(), {});
  instant.held.assign(cameras_.size(), nullptr);
  instant.stamps.assign(cameras_.size(), std::nullopt);
  instant.arrived = Microseconds(0);
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    if (!set->views[k]) continue;
    instant.stamps[k] = set->views[k]->stamp;
    Payload& payload = set->views[k]->payload;
    instant.arrived = std::max(instant.arrived, payload.arrival);
    if (payload.images) instant.setView(k, std::move(payload.images));
  }
  return true;
}

std::vector<CameraStatus> LiveRig::status() const {
  const SynchronizerStatistics statistics = synchronizer_->getStatistics();
  const Microseconds time = now();
  std::vector<CameraStatus> all(cameras_.size());
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Stream& stream = streams_[k];
    const SynchronizerStatistics::Camera& counts = statistics.cameras[k];
    CameraStatus& status = all[k];
    status.name = cameras_[k].name;
    const auto recent = std::count_if(stream.arrivals.begin(), stream.arrivals.end(),
                                      [&](Microseconds arrival) { return arrival + kRateWindow >= time; });
    const Microseconds window = std::min(kRateWindow, time - started_);
    if (window.count() > 0) status.rate = static_cast<double>(recent) / secondsOf(window);
    status.received = stream.received;
    status.lost = stream.lost;
    status.used = counts.used;
    status.unused = counts.unmatched + counts.late + counts.overrun + counts.repeated;
    status.clock_offset = counts.offset - statistics.cameras[0].offset;
    if (stream.silent) status.silent = secondsOf(time - stream.last.value_or(started_));
  }
  return all;
}

std::vector<std::string> LiveRig::takeNotices() {
  std::vector<bool> runs;
  for (const CameraSource* source : source_of_) runs.push_back(source->running());
  const Microseconds time = now();
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t k = 0; k < streams_.size(); ++k) {
    Stream& stream = streams_[k];
    const Microseconds silence = time - stream.last.value_or(started_);
    if (stream.silent || !runs[k] || silence < patience(stream)) continue;
    stream.silent = true;
    notices_.push_back("camera '" + cameras_[k].name + "' " +
                       (stream.last ? "has delivered nothing for " + seconds(silence)
                                    : "has not delivered anything yet, " + seconds(silence) + " after the start") +
                       (streams_.size() > 1 ? "; the others are fused without it" : ""));
  }
  return std::exchange(notices_, {});
}

std::string describe(const CameraStatus& status) {
  char text[256];
  int length =
      std::snprintf(text, sizeof text, "%5.1f a second, %llu lost, %llu unused", status.rate,
                    static_cast<unsigned long long>(status.lost), static_cast<unsigned long long>(status.unused));
  if (status.clock_offset.count() != 0)
    length += std::snprintf(text + length, sizeof text - static_cast<std::size_t>(length), ", clock %+.1f ms",
                            1e-3 * static_cast<double>(status.clock_offset.count()));
  if (status.silent)
    std::snprintf(text + length, sizeof text - static_cast<std::size_t>(length), ", SILENT for %.1f s", *status.silent);
  return status.name + ": " + text;
}

}  // namespace fuse_flow::io
