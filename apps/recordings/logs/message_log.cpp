#include "recordings/logs/message_log.h"

#include <algorithm>

namespace fuse_flow::io {
namespace {

class JoinedLog : public MessageLog {
 public:
  JoinedLog(const std::string& path, std::vector<std::unique_ptr<MessageLog>> parts) : parts_(std::move(parts)) {
    path_ = path;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      warnings_.insert(warnings_.end(), parts_[p]->warnings().begin(), parts_[p]->warnings().end());
      for (std::size_t t = 0; t < parts_[p]->topics().size(); ++t) add(p, t);
    }
  }

  void read(std::size_t topic, std::size_t message, std::string& bytes) override {
    const Place& place = placeOf(topic, message);
    parts_[place.part]->read(place.topic, message - place.first, bytes);
  }
  void readStart(std::size_t topic, std::size_t message, std::size_t count, std::string& bytes) override {
    const Place& place = placeOf(topic, message);
    parts_[place.part]->readStart(place.topic, message - place.first, count, bytes);
  }

 private:
  /** \brief Where the messages of a topic are from a number on. */
  struct Place {
    std::size_t first, part, topic;
  };

  void add(std::size_t part, std::size_t topic) {
    const Topic& more = parts_[part]->topics()[topic];
    std::optional<std::size_t> known = find(more.name);
    if (!known) {
      known = topics_.size();
      topics_.push_back(more);
      topics_.back().times.clear();
      places_.emplace_back();
    }
    Topic& whole = topics_[*known];
    if (whole.type != more.type || whole.wire != more.wire)
      throw InputError(parts_[part]->path() + ": " + more.name + " is " + more.type + ", in the file before " +
                       whole.type);
    places_[*known].push_back({whole.times.size(), part, topic});
    whole.times.insert(whole.times.end(), more.times.begin(), more.times.end());
  }

  const Place& placeOf(std::size_t topic, std::size_t message) const {
    const std::vector<Place>& places = places_.at(topic);
    return *std::prev(std::upper_bound(places.begin(), places.end(), message,
                                       [](std::size_t number, const Place& place) { return number < place.first; }));
  }

  std::vector<std::unique_ptr<MessageLog>> parts_;
  std::vector<std::vector<Place>> places_;  // of each topic
};

}  // namespace

std::optional<std::size_t> MessageLog::find(const std::string& name) const {
  const auto found =
      std::find_if(topics_.begin(), topics_.end(), [&](const Topic& topic) { return topic.name == name; });
  if (found == topics_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - topics_.begin());
}

std::unique_ptr<MessageLog> joinLogs(const std::string& path, std::vector<std::unique_ptr<MessageLog>> parts) {
  return std::make_unique<JoinedLog>(path, std::move(parts));
}

}  // namespace fuse_flow::io
