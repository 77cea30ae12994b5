#pragma once

#include <fuse_flow/distributed/communicator.h>
#include <fuse_flow/distributed/gpu/device_exchange.h>

#include <cstring>
#include <deque>
#include <string>

namespace fuse_flow {
namespace distributed {

/** \brief Through pinned host memory and a Communicator: for devices that do not reach each other's memory, and for tests. */
class StagedExchange : public DeviceExchange {
 public:
  /** \param communicator of this rank; must outlive this object */
  explicit StagedExchange(Communicator& communicator) : communicator_(&communicator) {}

  void exchange(gpu::Execution& run, const std::vector<DeviceMessage>& sends,
                const std::vector<DeviceMessage>& receives) override {
    while (out_.size() < sends.size()) out_.emplace_back();
    std::vector<Communicator::Outgoing> outgoing;
    for (std::size_t k = 0; k < sends.size(); ++k) {
      out_[k].resize(sends[k].bytes);
      run.copy(out_[k].data(), static_cast<const char*>(sends[k].data), sends[k].bytes);
      outgoing.push_back({sends[k].rank, out_[k].data(), sends[k].bytes});
    }
    run.wait();
    std::vector<int> from;
    for (const DeviceMessage& message : receives) from.push_back(message.rank);
    communicator_->exchange(outgoing, from, in_);
    std::size_t bytes = 0;
    for (std::size_t k = 0; k < receives.size(); ++k) {
      if (in_[k].size() != receives[k].bytes)
        throw RankError(from[k], "sent " + std::to_string(in_[k].size()) + " bytes of windows, not the " +
                                     std::to_string(receives[k].bytes) + " that it had said");
      bytes += in_[k].size();
    }
    staged_.resize(bytes);
    char* place = staged_.data();
    for (std::size_t k = 0; k < receives.size(); ++k) {
      std::memcpy(place, in_[k].data(), in_[k].size());
      run.copy(receives[k].data, static_cast<const char*>(place), in_[k].size());
      place += in_[k].size();
    }
  }

 private:
  Communicator* communicator_;
  std::deque<gpu::PinnedBuffer<char>> out_;
  gpu::PinnedBuffer<char> staged_;
  std::vector<Message> in_;
};

}  // namespace distributed
}  // namespace fuse_flow
