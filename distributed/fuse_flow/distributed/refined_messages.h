#pragma once

#include <fuse_flow/distributed/part_pipeline.h>

namespace fuse_flow {
namespace distributed {

/** \brief D^r of a rank's own views, for the measurements of others that need views that agree (AgreementParameters): every view may be
 *  asked about every point, so that all of it is sent. */
class RefinedMessages {
 public:
  /** \brief While PartPipeline::measure() runs. */
  static void write(const PartPipeline& pipeline, Message& message) {
    MessageWriter out(message);
    out.put(kMagic);
    const std::vector<std::uint32_t> own = pipeline.ownViews();
    out.put(static_cast<std::uint32_t>(own.size()));
    for (const std::uint32_t view : own) {
      const Intrinsics& K = pipeline.geometry(view).intrinsics;
      out.put(view);
      char* to = out.room(static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height) * sizeof(float));
      for (int v = 0; v < K.height; ++v)
        for (int u = 0; u < K.width; ++u, to += sizeof(float)) {
          const float z = pipeline.refinedToAgree(view, u, v);
          std::memcpy(to, &z, sizeof z);
        }
    }
  }

  /** \brief Whether a message is one; a rank that could not measure its views sends its PartSummary instead. */
  static bool isOne(const Message& message) {
    std::uint32_t magic = 0;
    if (message.size() >= sizeof magic) std::memcpy(&magic, message.data(), sizeof magic);
    return magic == kMagic;
  }

  static void read(PartPipeline& pipeline, const Message& message, int from) {
    MessageReader in(message, from);
    in.get<std::uint32_t>();
    const auto count = in.get<std::uint32_t>();
    const std::size_t cameras = pipeline.cameraCount();
    const std::vector<std::uint32_t> own = pipeline.ownViews();
    for (std::uint32_t k = 0; k < count; ++k) {
      const auto view = in.get<std::uint32_t>();
      if (view >= cameras) in.fail("a view of a camera that the rig does not have");
      if (pipeline.hasLanded(view) || std::count(own.begin(), own.end(), view) > 0)
        throw RankError(from, "has a view of camera " + std::to_string(view) + ", and so has another rank");
      host::DepthMap& refined = pipeline.landRefined(view);
      for (int v = 0; v < refined.height(); ++v) in.get(refined.row(v), static_cast<std::size_t>(refined.width()));
    }
    in.finish();
  }

 private:
  static constexpr std::uint32_t kMagic = 0x46465244;  // "DRFF"
};

}  // namespace distributed
}  // namespace fuse_flow
