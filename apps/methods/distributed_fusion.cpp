#include "methods/distributed_fusion.h"

#include "methods/plain_fusion.h"

#include <fuse_flow/distributed/fuse_flow.h>

#include <cstdio>

namespace fuse_flow::io {
namespace {

/** \brief Of one rank, since the beginning. */
struct Totals {
  std::uint64_t frames{0}, bytes_sent{0}, bytes_of_points{0}, messages{0}, points{0};
  double imbalance{0};  ///< the sum of all frames'

  void add(const distributed::PartStatistics& frame) {
    ++frames;
    bytes_sent += frame.bytes_sent;
    bytes_of_points += frame.bytes_of_points;
    messages += frame.messages;
    points += frame.points;
    imbalance += frame.imbalance;
  }
};

template <typename PointT>
class DistributedFusion : public DistributedMethod {
 public:
  DistributedFusion(distributed::Communicator& communicator, const MethodOptions& options, bool fusing)
      : communicator_(communicator), fusion_(communicator) {
    fusion_.setParameters(options.parameters);
    fusion_.setNumberOfThreads(options.threads);
    fusion_.setComputeNormals(options.normals);
    fusion_.setFusing(fusing);
  }

  void fuse(const RigFrame& frame, Cloud& output) override {
    fusion_.fuse(frame, part_);
    totals_.add(fusion_.getPartStatistics());
    if constexpr (point::has_normal<PointT>) {
      fusion_.gather(part_, with_normals_, 0);
      withoutNormals(with_normals_, output);
    } else {
      fusion_.gather(part_, output, 0);
    }
    statistics_ = fusion_.getStatistics();
    statistics_.fused_points = output.size();
  }

  std::string summary() override {
    distributed::Message own;
    distributed::MessageWriter(own).put(totals_);
    std::vector<distributed::Message> others;
    const bool first = communicator_.rank() == 0;
    communicator_.exchange(first ? std::vector<distributed::Communicator::Outgoing>()
                                 : std::vector<distributed::Communicator::Outgoing>{{0, own.data(), own.size()}},
                           first ? distributed::otherRanks(communicator_) : std::vector<int>(), others);
    if (!first || totals_.frames == 0) return "";
    Totals all = totals_;
    const std::vector<int> from = distributed::otherRanks(communicator_);
    for (std::size_t k = 0; k < others.size(); ++k) {
      distributed::MessageReader in(others[k], from[k]);
      const auto rank = in.get<Totals>();
      in.finish();
      all.bytes_sent += rank.bytes_sent;
      all.bytes_of_points += rank.bytes_of_points;
      all.messages += rank.messages;
    }
    const auto frames = static_cast<double>(totals_.frames);
    char line[200];
    std::snprintf(
        line, sizeof line,
        "%d ranks: %.0f messages and %.2f MB a frame between them (%.2f MB of it points); the busiest fuses %.2f "
        "times the mean",
        communicator_.size(), static_cast<double>(all.messages) / frames,
        1e-6 * static_cast<double>(all.bytes_sent) / frames, 1e-6 * static_cast<double>(all.bytes_of_points) / frames,
        totals_.imbalance / frames);
    return line;
  }

 private:
  distributed::Communicator& communicator_;
  distributed::FuseFlow<PointT> fusion_;
  pcl::PointCloud<PointT> part_;
  Totals totals_;
};

}  // namespace

std::unique_ptr<DistributedMethod> makeDistributedFusion(distributed::Communicator& communicator,
                                                         const MethodOptions& options, bool fusing) {
  if (options.morePerPoint())
    return std::make_unique<DistributedFusion<PointFusedNormal>>(communicator, options, fusing);
  return std::make_unique<DistributedFusion<PointFused>>(communicator, options, fusing);
}

}  // namespace fuse_flow::io
