// A rig that misbehaves for as long as you like: fuse_flow_soak MINUTES [CAMERAS] [SEED]. Its cameras come and go, change their size, stall, and deliver
// late, twice, garbage, or images that do not fit. Their views are synchronised, tracked, fused and, where streams are built, sent to clients that come
// and go. Prints each minute what the process has. Ends with 1 if
// - a view is lost without being counted, a frame with fitting views is refused, or one with a view that does not fit is fused,
// - a frame is not fused as an object fuses it that has seen no other frame, byte by byte,
// - memory grows, or descriptors or threads remain.
// Compiled by nvcc, the frames are fused and tracked on the GPU.

#include "process_state.h"
#include "room.h"
#ifdef FUSE_FLOW_WITH_STREAM
#include "restless_clients.h"
#endif

#ifdef __CUDACC__
#include <fuse_flow/gpu/calibration/extrinsic_tracking.h>
#include <fuse_flow/gpu/fuse_flow.h>
#else
#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/fuse_flow.h>
#endif
#include <fuse_flow/live/view_synchronizer.h>
#include <fuse_flow/point_types.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace fuse_flow;
using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;
using std::chrono::milliseconds;

#ifdef __CUDACC__
using Where = device::Thrust;
#else
using Where = device::Host;
#endif
using Fusion = FuseFlow<PointFused, Where>;
using Tracking = ExtrinsicTracking<PointFused, Where>;

/** \brief What a camera delivers. */
struct Images {
  Intrinsics intrinsics;
  std::vector<std::uint16_t> depth;
  std::vector<Rgb8> color;
  bool fits{true};  ///< the depth image has the size of the intrinsics
};
using Payload = std::shared_ptr<const Images>;

/** \brief Images of all cameras, in two sizes, at some instants. */
class Scene {
 public:
  static constexpr std::size_t kSizes = 2, kInstants = 4;

  explicit Scene(int cameras) {
    constexpr std::array<std::array<int, 2>, kSizes> sizes{{{320, 240}, {160, 120}}};
    for (std::size_t s = 0; s < kSizes; ++s) {
      const bench::Room room(cameras, sizes[s][0], sizes[s][1]);
      std::vector<char> memory(room.bytes());
      for (std::size_t k = 0; k < kInstants; ++k) {
        const RigFrame frame = room.render(memory.data(), static_cast<std::uint32_t>(k));
        if (s == 0 && k == 0) cameras_ = frame.cameras;
        for (std::size_t c = 0; c < frame.cameras.size(); ++c) {
          auto images = std::make_shared<Images>();
          images->intrinsics = frame.cameras[c].intrinsics;
          const std::size_t pixels = room.pixelsOfCamera();
          images->depth.assign(frame.views[c].depth16.data, frame.views[c].depth16.data + pixels);
          images->color.assign(frame.views[c].color.data, frame.views[c].color.data + pixels);
          images_[s][k].push_back(std::move(images));
        }
      }
    }
  }

  const std::vector<Camera>& cameras() const { return cameras_; }
  const Payload& images(std::size_t camera, std::size_t size, std::uint64_t instant) const {
    return images_[size][instant % kInstants][camera];
  }

 private:
  std::vector<Camera> cameras_;
  std::array<std::array<std::vector<Payload>, kInstants>, kSizes> images_;
};

/** \brief A camera of 30 Hz in its own thread, which does something else every few seconds, and counts what it delivers. */
class RestlessCamera {
 public:
  RestlessCamera(const Scene& scene, std::size_t number, std::uint32_t seed, ViewSynchronizer<Payload>& into)
      : scene_(scene), number_(number), random_(seed), into_(into), thread_([this] { run(); }) {}
  ~RestlessCamera() { stop(); }
  RestlessCamera(const RestlessCamera&) = delete;
  RestlessCamera& operator=(const RestlessCamera&) = delete;

  void stop() {
    ending_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::uint64_t pushed() const { return pushed_; }

 private:
  enum class Mood { Well, Small, Away, Stalled, Late, Twice, Garbage, Misfit };

  Mood drawMood() {
    constexpr std::array<Mood, 12> moods{Mood::Well,  Mood::Well,  Mood::Well,    Mood::Well,
                                         Mood::Small, Mood::Small, Mood::Away,    Mood::Stalled,
                                         Mood::Late,  Mood::Twice, Mood::Garbage, Mood::Misfit};
    return moods[random_() % moods.size()];
  }

  void run() {
    Clock::time_point due = Clock::now();
    while (!ending_) {
      const Mood mood = drawMood();
      const std::uint64_t frames = 1 + random_() % (mood == Mood::Misfit ? 3 : 90);
      for (std::uint64_t k = 0; k < frames && !ending_; ++k) {
        due += microseconds(33333);
        if (due < Clock::now() - std::chrono::seconds(1)) due = Clock::now();  // this machine does something else
        std::this_thread::sleep_until(due + (mood == Mood::Late ? milliseconds(random_() % 250) : milliseconds(0)));
        stamp_ += 33333;
        ++instant_;
        if (mood == Mood::Away || mood == Mood::Stalled) continue;
        push(stamp_, imagesIn(mood));
        if (mood == Mood::Twice) push(stamp_, imagesIn(mood));
      }
      if (mood == Mood::Away && random_() % 2) stamp_ = random_() % 1000000;  // it was started again
      if (mood == Mood::Stalled)                                              // what its driver has kept, all at once
        for (std::uint64_t k = std::min<std::uint64_t>(frames, 8); k > 0; --k)
          push(stamp_ - (k - 1) * 33333, imagesIn(Mood::Well));
    }
  }

  void push(std::uint64_t stamp, Payload images) {
    into_.push(number_, stamp, std::move(images));
    ++pushed_;
  }

  Payload imagesIn(Mood mood) {
    const Payload& well = scene_.images(number_, mood == Mood::Small ? 1 : 0, instant_);
    if (mood != Mood::Garbage && mood != Mood::Misfit) return well;
    auto images = std::make_shared<Images>(*well);
    if (mood == Mood::Garbage) {
      for (std::uint16_t& depth : images->depth) depth = static_cast<std::uint16_t>(random_());
    } else {
      images->intrinsics.width += 1 + static_cast<int>(random_() % 100);
      images->fits = false;
    }
    return images;
  }

  const Scene& scene_;
  std::size_t number_;
  std::mt19937 random_;
  ViewSynchronizer<Payload>& into_;
  std::uint64_t stamp_{0}, instant_{0};
  std::atomic<std::uint64_t> pushed_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

bool sameBytes(const pcl::PointCloud<PointFused>& a, const pcl::PointCloud<PointFused>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const PointFused &p = a[i], &q = b[i];
    if (std::memcmp(p.data, q.data, 3 * sizeof(float)) != 0 || p.rgba != q.rgba || p.view_count != q.view_count ||
        std::memcmp(&p.confidence, &q.confidence, sizeof(float)) != 0)
      return false;
  }
  return true;
}

/** \brief What is found wrong, a line each, and how often. */
class Findings {
 public:
  void add(const std::string& what) { ++counts_[what]; }
  bool none() const { return counts_.empty(); }
  void print() const {
    for (const auto& [what, count] : counts_)
      std::printf("WRONG, %llu times: %s\n", static_cast<unsigned long long>(count), what.c_str());
  }

 private:
  std::map<std::string, std::uint64_t> counts_;
};

/** \brief The thread that fuses, and its counts. */
class Consumer {
 public:
  explicit Consumer(const Scene& scene)
      : frame_{scene.cameras(), {}, 0}, tracking_(scene.cameras()), used_(scene.cameras().size()) {
    frame_.views.resize(frame_.cameras.size());
  }

  /** \brief The cloud of a set; null if it was refused. */
  const pcl::PointCloud<PointFused>* fuse(const ViewSynchronizer<Payload>::Set& set, Findings& findings) {
    bool fits = true;
    for (std::size_t c = 0; c < used_.size(); ++c) {
      frame_.views[c] = {};
      if (!set.views[c]) continue;
      ++used_[c];
      const Images& images = *set.views[c]->payload;
      const int width = images.fits ? images.intrinsics.width : 320, height = images.intrinsics.height;
      frame_.cameras[c].intrinsics = images.intrinsics;
      frame_.views[c].depth16 = {images.depth.data(), width, height};
      frame_.views[c].color = {images.color.data(), width, height};
      fits = fits && images.fits;
    }
    frame_.stamp = set.stamp;
    ++sets_;
    try {
      offered_ += tracking_.push(frame_) ? 1 : 0;
    } catch (const pcl::BadArgumentException&) {
      if (fits) findings.add("the tracker refuses a frame whose views fit");
    }
    tracking_.apply(frame_);
    for (const Camera& camera : frame_.cameras)
      if (!camera.T_world_camera.matrix().allFinite()) findings.add("a tracked pose is not finite");
    try {
      fusion_.fuse(frame_, cloud_);
    } catch (const pcl::BadArgumentException&) {
      if (fits) findings.add("a frame whose views fit is refused");
      ++refused_;
      return nullptr;
    }
    if (!fits) findings.add("a view that does not fit is fused");
    if (++fused_ % 20 == 0) {
      Fusion fresh;
      fresh.fuse(frame_, expected_);
      if (!sameBytes(cloud_, expected_)) findings.add("a frame is fused differently by an object that has seen others");
      ++compared_;
    }
    return &cloud_;
  }

  const std::vector<std::uint64_t>& used() const { return used_; }
  std::string text() {
    return std::to_string(sets_) + " sets, " + std::to_string(fused_) + " fused, " + std::to_string(refused_) +
           " refused, " + std::to_string(compared_) + " compared, " + std::to_string(offered_) + " tracked";
  }
  void finish() { tracking_.finish(); }

 private:
  RigFrame frame_;
  Fusion fusion_;
  Tracking tracking_;
  pcl::PointCloud<PointFused> cloud_, expected_;
  std::vector<std::uint64_t> used_;
  std::uint64_t sets_{0}, fused_{0}, refused_{0}, compared_{0}, offered_{0};
};

void checkCounts(const SynchronizerStatistics& statistics, const std::vector<std::unique_ptr<RestlessCamera>>& cameras,
                 const std::vector<std::uint64_t>& used, Findings& findings) {
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const auto& counts = statistics.cameras[c];
    if (counts.received != cameras[c]->pushed()) findings.add("a view was delivered, and not received");
    if (counts.received !=
        counts.used + counts.overrun + counts.unmatched + counts.late + counts.repeated + counts.waiting)
      findings.add("a view was received, and is in no count");
    if (counts.used != used[c]) findings.add("a view counts as used, and was in no set");
  }
}

/** \brief By an object that goes away again. */
void fuseOnce(const Scene& scene) {
  RigFrame frame;
  frame.cameras = scene.cameras();
  for (std::size_t c = 0; c < frame.cameras.size(); ++c) {
    const Images& images = *scene.images(c, 0, 0);
    const Intrinsics& K = images.intrinsics;
    DepthView& view = frame.views.emplace_back();
    view.depth16 = {images.depth.data(), K.width, K.height};
    view.color = {images.color.data(), K.width, K.height};
  }
  pcl::PointCloud<PointFused> cloud;
  Fusion().fuse(frame, cloud);
}

int run(double minutes, int count, std::uint32_t seed) {
  const Scene scene(count);
  Findings findings;
  fuseOnce(scene);  // CUDA keeps threads and descriptors of its own from its first use on
  const bench::ProcessState before = bench::processState();
  bench::ProcessState first, last;  // the most memory in the second and in the last quarter
  std::uint64_t dropped = 0;
  {
    Consumer consumer(scene);
    ViewSynchronizer<Payload> synchronizer(scene.cameras().size());
    std::vector<std::unique_ptr<RestlessCamera>> cameras;
    for (std::size_t c = 0; c < scene.cameras().size(); ++c)
      cameras.push_back(std::make_unique<RestlessCamera>(scene, c, seed + static_cast<std::uint32_t>(c), synchronizer));
#ifdef FUSE_FLOW_WITH_STREAM
    stream::ServerOptions options;
    options.port = 0;
    options.connections_per_second = 1000;
    stream::Server server(options);
    bench::RestlessClients clients(server, 4);
#endif
    const Clock::time_point start = Clock::now();
    Clock::time_point report = start;
    for (bool ended = false;;) {
      const double past = std::chrono::duration<double>(Clock::now() - start).count() / 60;
      if (past > minutes && !ended) {
        ended = true;
        for (const auto& camera : cameras) camera->stop();
      }
      const auto set = synchronizer.wait(milliseconds(300));  // longer than max_wait: without a set now, none will come
      if (!set && ended) break;
      if (set)
        if (const auto* cloud = consumer.fuse(*set, findings)) {
#ifdef FUSE_FLOW_WITH_STREAM
          server.publish(*cloud, {set->stamp, 0, 0});
#else
          (void)cloud;
#endif
        }
      const bench::ProcessState now = bench::processState();
      if (past > 0.25 * minutes && past <= 0.5 * minutes) first.megabytes = std::max(first.megabytes, now.megabytes);
      if (past > 0.75 * minutes) last.megabytes = std::max(last.megabytes, now.megabytes);
      if (Clock::now() >= report) {
        report += std::chrono::minutes(1);
        std::printf("%6.1f min: %.1f MB, %zu descriptors, %zu threads; %s", past, now.megabytes, now.descriptors,
                    now.threads, consumer.text().c_str());
#ifdef FUSE_FLOW_WITH_STREAM
        server.takeNotices();
        std::printf("; %llu clients came, %llu frames, %llu that were none",
                    static_cast<unsigned long long>(clients.came()), static_cast<unsigned long long>(clients.frames()),
                    static_cast<unsigned long long>(clients.intruders()));
#endif
        std::printf("\n");
        std::fflush(stdout);
      }
    }
    consumer.finish();
    const SynchronizerStatistics statistics = synchronizer.getStatistics();
    checkCounts(statistics, cameras, consumer.used(), findings);
    std::uint64_t received = 0, used = 0;
    for (const auto& counts : statistics.cameras) {
      received += counts.received;
      used += counts.used;
      dropped += counts.overrun + counts.unmatched + counts.late + counts.repeated;
    }
    std::printf("views: %llu received, %llu used, %llu dropped and counted; %s\n",
                static_cast<unsigned long long>(received), static_cast<unsigned long long>(used),
                static_cast<unsigned long long>(dropped), consumer.text().c_str());
  }
  // Memory of a few garbled images, more or less, and what allocators keep.
  if (last.megabytes > 1.1 * first.megabytes + 64) findings.add("memory grows");
  const bench::ProcessState after = bench::processState();
  if (after.descriptors > before.descriptors) findings.add("descriptors remain");
  std::printf(
      "memory: %.1f MB at most in the second quarter, %.1f in the last; descriptors %zu before, %zu after; threads "
      "%zu, %zu\n",
      first.megabytes, last.megabytes, before.descriptors, after.descriptors, before.threads, after.threads);
  if (after.threads > before.threads + std::thread::hardware_concurrency()) findings.add("threads remain");
  findings.print();
  return findings.none() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  const int cameras = argc > 2 ? std::atoi(argv[2]) : 6;
  if (argc < 2 || argc > 4 || !(std::atof(argv[1]) > 0) || cameras < 2 || cameras > 64) {
    std::fprintf(stderr, "usage: fuse_flow_soak MINUTES [CAMERAS] [SEED]\n");
    return 2;
  }
  return run(std::atof(argv[1]), cameras, argc > 3 ? static_cast<std::uint32_t>(std::atoll(argv[3])) : 1);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
