#pragma once

#include <fuse_flow/distributed/communicator.h>
#include <fuse_flow/distributed/gpu/device_exchange.h>

#include <nccl.h>

#include <cstring>
#include <string>

namespace fuse_flow {
namespace distributed {

/** \brief From device to device by NCCL: over NVLink where there is one. A GPU for each rank; what is launched on a rank's stream runs in its
 *  order, so the host does not wait. NCCL itself waits without end for a rank that is gone. */
class NcclExchange : public DeviceExchange {
 public:
  /** \brief All ranks of the communicator together, each with its device current. \param communicator tells all ranks what the first one has
   *  been given by NCCL; it is not needed afterwards */
  explicit NcclExchange(Communicator& communicator) {
    ncclUniqueId id;
    std::memset(&id, 0, sizeof id);
    std::vector<Communicator::Outgoing> out;
    std::vector<int> from;
    if (communicator.rank() == 0) {
      check(ncclGetUniqueId(&id), "ncclGetUniqueId");
      for (const int rank : otherRanks(communicator))
        out.push_back({rank, reinterpret_cast<const char*>(&id), sizeof id});
    } else {
      from.push_back(0);
    }
    std::vector<Message> in;
    communicator.exchange(out, from, in);
    if (!from.empty()) {
      if (in[0].size() != sizeof id) throw RankError(0, "sent something else than NCCL's number of the ranks");
      std::memcpy(&id, in[0].data(), sizeof id);
    }
    check(ncclCommInitRank(&ranks_, communicator.size(), id, communicator.rank()), "ncclCommInitRank");
  }
  ~NcclExchange() override { (void)ncclCommDestroy(ranks_); }
  NcclExchange(const NcclExchange&) = delete;
  NcclExchange& operator=(const NcclExchange&) = delete;

  void exchange(gpu::Execution& run, const std::vector<DeviceMessage>& sends,
                const std::vector<DeviceMessage>& receives) override {
    if (sends.empty() && receives.empty()) return;
    check(ncclGroupStart(), "ncclGroupStart");
    for (const DeviceMessage& message : sends)
      check(ncclSend(message.data, message.bytes, ncclUint8, message.rank, ranks_, run.stream), "ncclSend");
    for (const DeviceMessage& message : receives)
      check(ncclRecv(message.data, message.bytes, ncclUint8, message.rank, ranks_, run.stream), "ncclRecv");
    check(ncclGroupEnd(), "ncclGroupEnd");
  }

 private:
  static void check(ncclResult_t result, const char* what) {
    if (result == ncclSuccess) return;
    throw pcl::PCLException(std::string("fuse_flow::distributed: ") + what + ": " + ncclGetErrorString(result));
  }

  ncclComm_t ranks_{nullptr};
};

}  // namespace distributed
}  // namespace fuse_flow
