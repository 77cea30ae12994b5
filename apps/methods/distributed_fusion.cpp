#include "methods/distributed_fusion.h"

#include "methods/plain_fusion.h"

#include <fuse_flow/distributed/fuse_flow.h>
#include <fuse_flow/recordings/error.h>

#if defined(FUSE_FLOW_WITH_ZSTD)
#include <fuse_flow/distributed/zstd_codec.h>
#endif

#include <chrono>
#include <cstdio>

namespace fuse_flow::io {
namespace {

/** \brief Of one rank, since the beginning. */
struct Totals {
  std::uint64_t frames{0}, bytes_sent{0}, bytes_plain{0}, bytes_of_points{0}, messages{0}, points{0};
  double imbalance{0};  ///< the sum of all frames'

  void add(const distributed::PartStatistics& frame) {
    ++frames;
    bytes_sent += frame.bytes_sent;
    bytes_plain += frame.bytes_plain;
    bytes_of_points += frame.bytes_of_points;
    messages += frame.messages;
    points += frame.points;
    imbalance += frame.imbalance;
  }
};

std::shared_ptr<const distributed::Codec> makeCodec() {
#if defined(FUSE_FLOW_WITH_ZSTD)
  return std::make_shared<distributed::ZstdCodec>();
#else
  throw InputError("--rank-compression zstd: built without Zstandard; install libzstd-dev, and build again");
#endif
}

template <typename PointT>
class DistributedFusion : public DistributedMethod {
 public:
  DistributedFusion(distributed::Communicator& communicator, const MethodOptions& options, const RankShare& share)
      : communicator_(communicator), fusion_(communicator), compresses_(share.compresses) {
    fusion_.setParameters(options.parameters);
    fusion_.setNumberOfThreads(options.threads);
    fusion_.setComputeNormals(options.normals);
    fusion_.setFusing(share.fuses);
    if (share.compresses) fusion_.setCodec(makeCodec());
  }

  void fuse(const RigFrame& frame, Cloud& output) override {
    fusion_.fuse(frame, part_);
    const auto fused = std::chrono::steady_clock::now();
    if constexpr (point::has_normal<PointT>) {
      fusion_.gather(part_, with_normals_, 0);
      withoutNormals(with_normals_, output);
    } else {
      fusion_.gather(part_, output, 0);
    }
    totals_.add(fusion_.getPartStatistics());
    statistics_ = fusion_.getStatistics();
    const std::chrono::duration<double, std::milli> gathering = std::chrono::steady_clock::now() - fused;
    statistics_.output_ms += gathering.count();
    statistics_.total_ms += gathering.count();
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
      all.bytes_plain += rank.bytes_plain;
      all.bytes_of_points += rank.bytes_of_points;
      all.messages += rank.messages;
    }
    const auto frames = static_cast<double>(totals_.frames);
    const auto megabytes = [&](std::uint64_t bytes) { return 1e-6 * static_cast<double>(bytes) / frames; };
    char line[240], compressed[60] = "";
    if (compresses_) std::snprintf(compressed, sizeof compressed, ", compressed to %.2f MB", megabytes(all.bytes_sent));
    std::snprintf(
        line, sizeof line,
        "%d ranks: %.0f messages and %.2f MB a frame between them (%.2f MB of it points)%s; the busiest fuses %.2f "
        "times the mean",
        communicator_.size(), static_cast<double>(all.messages) / frames, megabytes(all.bytes_plain),
        megabytes(all.bytes_of_points), compressed, totals_.imbalance / frames);
    return line;
  }

 private:
  distributed::Communicator& communicator_;
  distributed::FuseFlow<PointT> fusion_;
  bool compresses_;
  pcl::PointCloud<PointT> part_;
  Totals totals_;
};

}  // namespace

std::unique_ptr<DistributedMethod> makeDistributedFusion(distributed::Communicator& communicator,
                                                         const MethodOptions& options, const RankShare& share) {
  if (options.morePerPoint())
    return std::make_unique<DistributedFusion<PointFusedNormal>>(communicator, options, share);
  return std::make_unique<DistributedFusion<PointFused>>(communicator, options, share);
}

}  // namespace fuse_flow::io
