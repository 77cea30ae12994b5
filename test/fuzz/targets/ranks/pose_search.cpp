#include "../../fuzz_target.h"
#include "../../small_pose_rig.h"

#include <algorithm>

namespace {

using namespace fuse_flow::distributed;

/** \brief One of two ranks; what the other sends is in the input, each message behind its length. */
class FedRank : public Communicator {
 public:
  FedRank(int rank, std::string_view input) : rank_(rank), input_(input) {}
  int rank() const override { return rank_; }
  int size() const override { return 2; }
  void exchange(const std::vector<Outgoing>&, const std::vector<int>& from, std::vector<Message>& in) override {
    in.resize(from.size());
    for (Message& message : in) {
      if (input_.size() < 3) throw RankError(1 - rank_, "has ended");
      std::size_t size = 0;
      for (int k = 2; k >= 0; --k) size = size << 8 | static_cast<unsigned char>(input_[static_cast<std::size_t>(k)]);
      input_.remove_prefix(3);
      size = std::min(size, input_.size());
      message.assign(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(size));
      input_.remove_prefix(size);
    }
  }

 private:
  int rank_;
  std::string_view input_;
};

}  // namespace

/** \brief What the other of two ranks sends while they search for poses; the first byte says which of the two this one is. */
FUSE_FLOW_FUZZ_TARGET(pose_search, 8 << 20, 64, 150) {
  if (input.empty()) return;
  static const fuse_flow_fuzz::SmallPoseRig rig;
  FedRank rank(input[0] & 1, input.substr(1));
  fuse_flow_fuzz::accepts<pcl::PCLException>([&] {
    const fuse_flow::ExtrinsicResult result = rig.estimate(rank);
    fuse_flow_fuzz::require(result.T_world_camera.size() == 2 && result.corrections.size() == 2,
                            "poses of other cameras than the rig has");
  });
}
