#pragma once

#include <fuse_flow/distributed/communicator.h>
#include <fuse_flow/distributed/part_statistics.h>
#include <fuse_flow/distributed/part_summary.h>
#include <fuse_flow/rig_frame.h>

#include <algorithm>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Sends a message to every other rank, and waits for theirs. \param out one for all, or one for each by rank
 *  \param plain what they were before they were coded, or the same  \param in receives them in the order of otherRanks()
 *  \param statistics counts the bytes */
inline void exchangeWithAll(Communicator& communicator, const std::vector<Message>& out,
                            const std::vector<Message>& plain, std::vector<Message>& in, PartStatistics& statistics) {
  const std::vector<int> others = otherRanks(communicator);
  std::vector<Communicator::Outgoing> outgoing;
  for (const int r : others) {
    const std::size_t k = out.size() == 1 ? 0 : static_cast<std::size_t>(r);
    outgoing.push_back({r, out[k].data(), out[k].size()});
    statistics.bytes_sent += out[k].size();
    statistics.bytes_plain += plain[k].size();
    ++statistics.messages;
  }
  communicator.exchange(outgoing, others, in);
  for (const Message& message : in) statistics.bytes_received += message.size();
}

/** \brief As the rest of a sentence that begins with another rank. */
inline std::string whyOtherCodec(int own) {
  return "compresses messages otherwise than rank " + std::to_string(own) + ": all must have the same codec, or none";
}

/** \brief \throws RankError if another rank could not do its part, or has another rig or other parameters. \param parts by rank */
inline void checkParts(const std::vector<PartSummary>& parts, int own) {
  const PartSummary& mine = parts[static_cast<std::size_t>(own)];
  for (std::size_t r = 0; r < parts.size(); ++r) {
    const int rank = static_cast<int>(r);
    if (!parts[r].error.empty()) throw RankError(rank, "cannot do its part of the frame: " + parts[r].error);
    const std::string than = " than rank " + std::to_string(own);
    if (parts[r].rig != mine.rig)
      throw RankError(rank, "has other cameras" + than + ": all must have the same calibration");
    if (parts[r].parameters != mine.parameters) throw RankError(rank, "has other parameters" + than);
    if (parts[r].codec != mine.codec) throw RankError(rank, whyOtherCodec(own));
  }
}

/** \brief Whose view that of each camera is; −1: nobody's. \throws RankError if two ranks have one */
inline void findOrigins(const std::vector<PartSummary>& parts, const std::vector<Camera>& cameras,
                        std::vector<int>& origin) {
  origin.assign(cameras.size(), -1);
  for (std::size_t r = 0; r < parts.size(); ++r)
    for (const PartSummary::View& view : parts[r].views) {
      if (origin[view.view] >= 0)
        throw RankError(static_cast<int>(r), "has a view of camera '" + cameras[view.view].name +
                                                 "', and so has rank " + std::to_string(origin[view.view]));
      origin[view.view] = static_cast<int>(r);
    }
}

/** \brief Of the whole frame. \param origin of findOrigins() */
inline void combineStatistics(const std::vector<PartSummary>& parts, const std::vector<int>& origin,
                              FrameStatistics& statistics) {
  statistics.measured_points = statistics.gated_points = 0;
  statistics.missing_cameras.clear();
  statistics.out_of_range.clear();
  for (const PartSummary& part : parts) {
    statistics.gated_points += static_cast<std::size_t>(part.gated);
    for (const PartSummary::View& view : part.views) {
      statistics.measured_points += view.measured;
      statistics.noise_scales[view.view] = view.noise_scale;
      if (view.out_of_range) statistics.out_of_range.push_back(view.range);
    }
  }
  std::sort(statistics.out_of_range.begin(), statistics.out_of_range.end(),
            [](const DepthOutOfRange& a, const DepthOutOfRange& b) { return a.camera < b.camera; });
  for (std::size_t i = 0; i < origin.size(); ++i)
    if (origin[i] < 0) statistics.missing_cameras.push_back(i);
}

}  // namespace distributed
}  // namespace fuse_flow
