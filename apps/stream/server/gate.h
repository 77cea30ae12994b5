#pragma once

#include "stream/network/text.h"
#include "stream/server/access.h"
#include "stream/server/session.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::stream::network {

/** \brief A file that is served, as ServedFile. */
struct HeldFile {
  std::string content_type, bytes, policy;
};

/** \brief What each connection is given: who may come in, what there is, and how much of it. Many threads may use it. */
struct Gate {
  struct Limits {
    std::size_t clients, connections, header_bytes, messages_per_second;
    std::chrono::milliseconds handshake_time;
  };

  /** \brief A place among those that are counted, given back when it is destroyed. */
  class Place {
   public:
    explicit Place(std::shared_ptr<std::atomic<std::size_t>> taken) : taken_(std::move(taken)) {}
    Place(Place&&) = default;
    Place& operator=(Place&&) = delete;
    ~Place() {
      if (taken_) --*taken_;
    }

   private:
    std::shared_ptr<std::atomic<std::size_t>> taken_;
  };

  Gate(const Limits& of, Access who) : limits(of), access(std::move(who)) {}

  /** \brief Absent: all are taken. */
  std::optional<Place> admitClient() { return admit(clients, limits.clients); }
  std::optional<Place> admitConnection() { return admit(connections, limits.connections); }
  static std::optional<Place> admit(const std::shared_ptr<std::atomic<std::size_t>>& taken, std::size_t most) {
    if (++*taken <= most) return Place(taken);
    --*taken;
    return std::nullopt;
  }

  std::shared_ptr<const HeldFile> file(const std::string& path) {
    const std::lock_guard<std::mutex> lock(files_mutex);
    const auto found = files.find(path);
    return found == files.end() ? nullptr : found->second;
  }

  const Limits limits;
  const Access access;
  std::vector<Subprotocol> subprotocols;  ///< complete before the first connection
  Notices notices;
  std::shared_ptr<std::atomic<std::size_t>> clients{std::make_shared<std::atomic<std::size_t>>(0)};
  std::shared_ptr<std::atomic<std::size_t>> connections{std::make_shared<std::atomic<std::size_t>>(0)};
  std::atomic<std::uint64_t> refused{0}, dropped{0};
  std::mutex files_mutex;
  std::map<std::string, std::shared_ptr<const HeldFile>> files;
};

}  // namespace fuse_flow::stream::network
