#include "../../choices.h"
#include "../../fuzz_target.h"

#include <fuse_flow/live/view_synchronizer.h>

#include <algorithm>
#include <map>
#include <set>

namespace {

using namespace fuse_flow;
using fuse_flow_fuzz::Choices;
using fuse_flow_fuzz::require;
using std::chrono::microseconds;

/** \brief What the synchroniser's documentation says, in the plainest way, for cameras that share a clock, run at a steady rate, and whose clock jumps back
 *  together: no frame is ever lost between two that come. Every window that begins at a view is tried. */
class Model {
 public:
  struct View {
    std::int64_t stamp, arrival;
    int payload;
  };
  using Set = std::map<std::size_t, View>;

  Model(std::size_t cameras, const SynchronizerParameters& parameters) : parameters_(parameters), cameras_(cameras) {}

  void push(std::size_t camera, std::int64_t stamp, std::int64_t now, int payload) {
    Camera& c = cameras_[camera];
    ++c.received;
    if (c.newest && stamp == *c.newest) {
      ++c.repeated;
      return;
    }
    c.waited_for = true;
    if (c.newest && stamp < *c.newest) {
      if (*c.newest - stamp <= parameters_.max_wait.count()) {
        ++c.late;
        return;
      }
      restart(c, stamp);
    }
    c.newest = stamp;
    if (last_ && stamp <= *last_) {
      ++c.late;
      return;
    }
    if (c.views.size() == parameters_.capacity) {
      ++c.overrun;
      c.views.erase(c.views.begin());
    }
    c.views.push_back({stamp, now, payload});
  }

  std::optional<Set> take(std::int64_t now) {
    const bool overdue = std::any_of(cameras_.begin(), cameras_.end(), [&](const Camera& c) {
      return !c.views.empty() && now - c.views.front().arrival >= parameters_.max_wait.count();
    });
    std::size_t with_views = 0;
    for (const Camera& c : cameras_) {
      if (c.views.empty() && c.waited_for && !overdue) return std::nullopt;
      with_views += c.views.empty() ? 0 : 1;
    }
    if (with_views == 0) return std::nullopt;
    const Set set = best();
    if (set.size() < with_views && !overdue) return std::nullopt;
    const auto [first, last] = range(set);
    last_ = first + (last - first) / 2;
    for (std::size_t k = 0; k < cameras_.size(); ++k) {
      Camera& c = cameras_[k];
      const auto used = set.find(k);
      while (!c.views.empty() &&
             (c.views.front().stamp <= *last_ || (used != set.end() && c.views.front().stamp <= used->second.stamp))) {
        const bool is_used = used != set.end() && c.views.front().stamp == used->second.stamp;
        ++(is_used ? c.used : c.unmatched);
        c.views.erase(c.views.begin());
      }
      if (overdue && used == set.end() && c.views.empty()) c.waited_for = false;
    }
    return set;
  }

  void compare(const SynchronizerStatistics& statistics) const {
    for (std::size_t k = 0; k < cameras_.size(); ++k) {
      const Camera& c = cameras_[k];
      const SynchronizerStatistics::Camera& s = statistics.cameras[k];
      require(s.received == c.received && s.used == c.used && s.overrun == c.overrun && s.unmatched == c.unmatched &&
                  s.late == c.late && s.repeated == c.repeated && s.waiting == c.views.size() &&
                  s.restarts == c.restarts && s.waited_for == c.waited_for,
              "other counts than the model's");
    }
  }

 private:
  struct Camera {
    std::vector<View> views;
    std::optional<std::int64_t> newest;
    std::uint64_t received{0}, used{0}, overrun{0}, unmatched{0}, late{0}, repeated{0}, restarts{0};
    bool waited_for{true};
  };

  void restart(Camera& c, std::int64_t stamp) {
    ++c.restarts;
    c.unmatched += c.views.size();
    c.views.clear();
    last_.reset();
    for (Camera& other : cameras_)
      while (!other.views.empty() && other.views.back().stamp - stamp > parameters_.max_wait.count()) {
        ++other.unmatched;
        other.views.pop_back();
      }
  }

  static std::pair<std::int64_t, std::int64_t> range(const Set& set) {
    std::pair<std::int64_t, std::int64_t> result{set.begin()->second.stamp, set.begin()->second.stamp};
    for (const auto& [k, view] : set) {
      result.first = std::min(result.first, view.stamp);
      result.second = std::max(result.second, view.stamp);
    }
    return result;
  }

  /** \brief Of each camera the latest view in a window that ends at a time. */
  Set endingAt(std::int64_t end) const {
    Set set;
    for (std::size_t k = 0; k < cameras_.size(); ++k)
      for (const View& view : cameras_[k].views)
        if (view.stamp <= end && end - view.stamp <= 2 * parameters_.tolerance.count()) set[k] = view;
    return set;
  }

  /** \brief With the most cameras, of those the latest; or the views around its earliest one, if these are nearer to one another. */
  Set best() const {
    std::set<std::int64_t> ends;
    for (const Camera& c : cameras_)
      for (const View& view : c.views) ends.insert(view.stamp);
    Set most;
    for (const std::int64_t end : ends)
      if (Set set = endingAt(end); set.size() >= most.size()) most = std::move(set);
    const std::int64_t earliest = range(most).first;
    Set around = most;
    for (auto& [k, chosen] : around)
      for (const View& view : cameras_[k].views)
        if (std::abs(view.stamp - earliest) < std::abs(chosen.stamp - earliest)) chosen = view;
    const auto spread = [](const Set& set) { return range(set).second - range(set).first; };
    return spread(around) < spread(most) ? around : most;
  }

  SynchronizerParameters parameters_;
  std::vector<Camera> cameras_;
  std::optional<std::int64_t> last_;
};

SynchronizerParameters drawParameters(Choices& choices) {
  SynchronizerParameters p;
  p.tolerance = microseconds(1 + choices.below(20000));
  p.max_wait = microseconds(1000 * (1 + choices.below(200)));
  p.capacity = 1 + choices.below(9);
  return p;
}

/** \brief Steady cameras: the same sets and counts as the model's. */
void compareWithModel(Choices& choices) {
  SynchronizerParameters parameters = drawParameters(choices);
  parameters.clocks = ClockModel::Shared;
  const std::size_t cameras = 1 + choices.below(4);
  std::int64_t now = 1'000'000, shift = 0;
  ViewSynchronizer<int> synchronizer(cameras, parameters, [&now] { return microseconds(now); });
  Model model(cameras, parameters);
  std::vector<std::int64_t> stamps(cameras, 0), periods(cameras);
  std::vector<bool> pushed(cameras, false);  // whether the camera's stamp is that of its last view
  for (std::int64_t& period : periods) period = 1000 * (10 + static_cast<std::int64_t>(choices.below(60)));
  for (int payload = 0; choices.left() && payload < 300; ++payload) {
    const std::size_t camera = choices.below(cameras);
    switch (choices.below(16)) {
      case 0:
        now += static_cast<std::int64_t>(choices.below(65536)) * 4;
        break;
      case 1:  // the clock of all is set back
        shift += 1000 * static_cast<std::int64_t>(choices.below(65536));
        // By less it is no new start but a view that is late, and what comes then looks as if frames had been lost.
        if (shift <= parameters.max_wait.count() + 2 * periods[camera]) break;
        stamps[camera] -= shift;
        pushed[camera] = false;
        break;
      case 2:  // out of order
        if (!pushed[camera]) break;
        synchronizer.push(camera, static_cast<std::uint64_t>(stamps[camera] - 100), payload);
        model.push(camera, stamps[camera] - 100, now, payload);
        break;
      case 3:  // twice
        synchronizer.push(camera, static_cast<std::uint64_t>(stamps[camera]), payload);
        model.push(camera, stamps[camera], now, payload);
        pushed[camera] = true;
        break;
      default:
        // Up to 1.4 times the period: a gap from half a period more is that of a lost frame.
        stamps[camera] += periods[camera] + periods[camera] * static_cast<std::int64_t>(choices.below(40)) / 100;
        now += static_cast<std::int64_t>(choices.below(40)) * 500;
        synchronizer.push(camera, static_cast<std::uint64_t>(stamps[camera]), payload);
        model.push(camera, stamps[camera], now, payload);
        pushed[camera] = true;
    }
    if (choices.below(4) == 0) continue;
    const auto set = synchronizer.take();
    const auto expected = model.take(now);
    require(set.has_value() == expected.has_value(), "a set where the model has none, or none where it has one");
    if (!set) continue;
    for (std::size_t k = 0; k < cameras; ++k) {
      const auto found = expected->find(k);
      require(set->views[k].has_value() == (found != expected->end()), "another camera in a set than in the model's");
      if (set->views[k])
        require(set->views[k]->payload == found->second.payload, "another view in a set than in the model's");
    }
    model.compare(synchronizer.getStatistics());
  }
}

/** \brief Any stamps and times: what always holds. */
void checkInvariants(Choices& choices) {
  SynchronizerParameters parameters = drawParameters(choices);
  parameters.clocks = choices.oneIn(2) ? ClockModel::Shared : ClockModel::Separate;
  parameters.offset_window = microseconds(1 + choices.below(65536));
  if (choices.oneIn(8)) parameters.tolerance = microseconds::max();
  if (choices.oneIn(8)) parameters.max_wait = microseconds::max();
  const std::size_t cameras = 1 + choices.below(4);
  std::int64_t now = choices.oneIn(4) ? static_cast<std::int64_t>(choices.number()) : 0;
  ViewSynchronizer<std::size_t> synchronizer(cameras, parameters, [&now] { return microseconds(now); });
  std::vector<std::uint64_t> stamps(cameras, 0);
  std::vector<std::pair<std::size_t, std::uint64_t>> pushed;  // camera and stamp of each payload
  std::set<std::size_t> delivered;
  std::optional<std::uint64_t> last;
  std::uint64_t sets = 0;
  while (choices.left() && pushed.size() < 300) {
    const std::size_t camera = choices.below(cameras);
    stamps[camera] = choices.oneIn(16) ? choices.number() : stamps[camera] + 1000 * choices.below(256);
    if (choices.oneIn(16)) now = static_cast<std::int64_t>(choices.number());
    if (now < std::int64_t{1} << 62) now += static_cast<std::int64_t>(choices.below(65536));
    synchronizer.push(camera, stamps[camera], pushed.size());
    pushed.emplace_back(camera, stamps[camera]);
    while (const auto set = synchronizer.take()) {
      ++sets;
      require(std::any_of(set->views.begin(), set->views.end(), [](const auto& view) { return view.has_value(); }),
              "an empty set");
      require(set->spread.count() >= 0 &&
                  (parameters.tolerance.count() > std::int64_t{1} << 40 || set->spread <= 2 * parameters.tolerance),
              "a set of a larger spread than twice the tolerance");
      require(!last || static_cast<std::int64_t>(set->stamp - *last) > 0,
              "a set that is not later than the one before");
      last = set->stamp;
      for (std::size_t k = 0; k < cameras; ++k) {
        if (!set->views[k]) continue;
        const std::size_t payload = set->views[k]->payload;
        require(pushed.at(payload) == std::pair(k, set->views[k]->stamp),
                "a view of another camera, or with another stamp");
        require(delivered.insert(payload).second, "a view that was delivered twice");
      }
    }
    const SynchronizerStatistics statistics = synchronizer.getStatistics();
    std::uint64_t received = 0, used = 0;
    for (const SynchronizerStatistics::Camera& c : statistics.cameras) {
      require(c.received == c.used + c.overrun + c.unmatched + c.late + c.repeated + c.waiting,
              "counts that do not add up");
      require(c.waiting <= parameters.capacity, "more views wait than may");
      received += c.received;
      used += c.used;
    }
    require(received == pushed.size() && used == delivered.size(), "counts that are not those of the views");
    require(statistics.complete_sets + statistics.incomplete_sets == sets,
            "another number of sets than were delivered");
  }
}

}  // namespace

/** \brief Random pushes into ViewSynchronizer, against a model of it. */
FUSE_FLOW_FUZZ_TARGET(synchronizer, 1 << 20, 1024, 2000) {
  Choices choices(input);
  if (choices.oneIn(2))
    checkInvariants(choices);
  else
    compareWithModel(choices);
  ++fuse_flow_fuzz::acceptedInputs();
}
