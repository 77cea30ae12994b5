#pragma once

#include <fuse_flow/distributed/fuse_flow.h>
#include <fuse_flow/impl/fusion/point_writer.hpp>

namespace fuse_flow {
namespace distributed {

/** \brief As exchange(), but what goes over the wire is coded where there is a codec. \param parts what the bytes of each message are */
template <typename PointT>
void FuseFlow<PointT, device::Host>::exchangeCoded(const std::vector<Message>& out,
                                                   const std::vector<MessageParts>& parts) {
  if (codec_) {
    coded_.resize(out.size());
    for (std::size_t r = 0; r < out.size(); ++r)
      if (out.size() == 1 || static_cast<int>(r) != own())
        coding_.code(*codec_, out[r], parts[r], pipeline_.resolvedThreads(), coded_[r]);
  }
  exchange(codec_ ? coded_ : out, out);
  const std::vector<int> others = otherRanks(*communicator_);
  checkCodecs(others);
  decodeIncoming(others);
}

/** \brief Before anything that has come is read: that another rank has another codec all see in the same exchange, so that all end it. */
template <typename PointT>
void FuseFlow<PointT, device::Host>::checkCodecs(const std::vector<int>& from) const {
  for (std::size_t k = 0; k < in_.size(); ++k) {
    const bool right = CodedMessage::isOne(in_[k]) ? codec_ && CodedMessage::formatOf(in_[k]) == codec_->format()
                                                   : !codec_ || !RefinedMessages::isOne(in_[k]);
    if (!right) throw RankError(from[k], whyOtherCodec(own()));
  }
}

/** \brief Puts what others have coded back into its place among what came in. */
template <typename PointT>
void FuseFlow<PointT, device::Host>::decodeIncoming(const std::vector<int>& from) {
  // Nobody has more to say of a pixel than its depths, C, colour, and a point and a cell of its own.
  std::size_t limit = 4096;
  for (std::size_t i = 0; i < pipeline_.cameraCount(); ++i) {
    const Intrinsics& K = pipeline_.geometry(i).intrinsics;
    limit += 64 + (64 + sizeof(PointT)) * static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height);
  }
  plain_.resize(in_.size());
  for (std::size_t k = 0; k < in_.size(); ++k) {
    if (!CodedMessage::isOne(in_[k])) continue;
    coding_.decode(codec_.get(), in_[k], from[k], limit, pipeline_.resolvedThreads(), plain_[k]);
    in_[k].swap(plain_[k]);
  }
}

/** \brief D^r of all views to all ranks. */
template <typename PointT>
void FuseFlow<PointT, device::Host>::shareRefined() {
  std::vector<Message> out(1);
  RefinedMessages::write(pipeline_, out[0]);
  if (ranks() == 1) return;
  exchangeCoded(out, {{{out[0].size(), ByteKind::Words}}});
  const std::vector<int> others = otherRanks(*communicator_);
  for (std::size_t k = 0; k < others.size(); ++k) {
    if (!RefinedMessages::isOne(in_[k])) {
      PartSummary failed;
      failed.read(in_[k], others[k], pipeline_.cameraCount());
      throw RankError(others[k], "cannot do its part of the frame: " + failed.error);
    }
    RefinedMessages::read(pipeline_, in_[k], others[k]);
  }
}

/** \brief This rank's part, and what the others say of theirs. */
template <typename PointT>
void FuseFlow<PointT, device::Host>::meet(const RigFrame& frame) {
  parts_.resize(static_cast<std::size_t>(ranks()));
  PartSummary& summary = parts_[static_cast<std::size_t>(own())];
  summary = {};
  std::exception_ptr failure;
  try {
    pipeline_.measure(frame, summary, [this] { shareRefined(); });
  } catch (const RankError&) {
    throw;  // of shareRefined(): all others have it too
  } catch (const std::exception& error) {
    failure = std::current_exception();
    summary.error = error.what();
    summary.views.clear();
    summary.blocks.clear();
  }
  summary.parameters = FrameDigest()
                           .add(pipeline_.parameters)
                           .addAll(ownership_, compute_normals_, weight_in_intensity_, sizeof(PointT))
                           .value();
  summary.codec = codec_ ? codec_->format() : 0;
  summary.fuses = fusing_ ? 1 : 0;
  part_statistics_.views = summary.views.size();
  std::vector<Message> out(1);
  summary.write(out[0]);
  exchange(out, out);
  if (failure) std::rethrow_exception(failure);  // and where it did not come to shareRefined(), this stood for it
  const std::vector<int> others = otherRanks(*communicator_);
  for (std::size_t k = 0; k < others.size(); ++k)
    parts_[static_cast<std::size_t>(others[k])].read(in_[k], others[k], frame.cameras.size());
  checkParts(parts_, own());
  pipeline_.meet(parts_, own());
}

/** \brief What the cells of others look at goes to them, and what this rank's cells look at comes. */
template <typename PointT>
void FuseFlow<PointT, device::Host>::exchangeWindows() {
  const std::vector<Message>& out =
      window_writer_.write(pipeline_, owners_, parts_[static_cast<std::size_t>(own())], own(), ranks());
  if (ranks() == 1) {
    pipeline_.beginLanding();
    return;
  }
  exchangeCoded(out, window_writer_.parts());
  part_statistics_.bytes_of_points = window_writer_.bytesOfPoints();
  window_reader_.read(pipeline_, in_, otherRanks(*communicator_), parts_);
  pipeline_.takeUp();
}

template <typename PointT>
void FuseFlow<PointT, device::Host>::fuseCells(PointCloud& output) {
  host::PointWriter<PointT>& writer = *writer_;
  writer.setComputeNormals(compute_normals_);
  pipeline_.fuseOwned(writer, [&](std::uint64_t cell) { return owners_.ownerOf(cell) == own(); });
  const host::HashAggregation& aggregation = pipeline_.aggregation();
  output.resize(aggregation.size());
  aggregation.forEachBlock(pipeline_.resolvedThreads(),
                           [&](std::size_t position, int thread, std::size_t begin, std::size_t n) {
                             writer.copy(thread, begin, n, output.points.data() + position);
                           });
  output.header = {};
  for (const PartSummary& part : parts_) output.header.stamp = std::max(output.header.stamp, part.stamp);
  output.width = static_cast<std::uint32_t>(output.size());
  output.height = 1;
  output.is_dense = !writer.anyUnknownNormal();
  output.sensor_origin_.setZero();
  output.sensor_orientation_.setIdentity();
  pipeline_.statistics.fused_points = output.size();
  part_statistics_.cells = aggregation.grid.cells().size();
  part_statistics_.points = part_statistics_.foreign_points = 0;
  for (const host::CoarseGrid::Cell& cell : aggregation.grid.cells()) part_statistics_.points += cell.points;
  part_statistics_.foreign_points = window_reader_.points();
}

template <typename PointT>
void FuseFlow<PointT, device::Host>::gather(const PointCloud& part, PointCloud& whole, int root) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::distributed::FuseFlow");
  const std::vector<std::uint32_t>& counts = pipeline_.aggregation().pointsOfCells();
  if (part.size() != pipeline_.aggregation().size())
    throw pcl::PCLException("fuse_flow::distributed::FuseFlow: gather() takes the cloud of the last fuse()");
  // Of each cell its first point, which orders it among those of all ranks, and how many points were fused of it.
  GatheredCells cells(counts.size());
  for (std::size_t c = 0; c < counts.size(); ++c) cells[c] = {pipeline_.firstPointOf(c), counts[c]};
  whole.clear();
  std::vector<Communicator::Outgoing> out;
  std::vector<int> from;
  Message message;
  std::size_t plain_size = 0;
  if (own() == root) {
    from = otherRanks(*communicator_);
  } else {
    MessageParts parts;
    writeGathered(cells, part, message, parts);
    plain_size = message.size();
    if (codec_) {
      coded_.resize(1);
      coding_.code(*codec_, message, parts, pipeline_.resolvedThreads(), coded_[0]);
      message.swap(coded_[0]);
    }
    out.push_back({root, message.data(), message.size()});
  }
  for (const Communicator::Outgoing& sent : out) {
    part_statistics_.bytes_sent += sent.size;
    part_statistics_.bytes_plain += plain_size;
    part_statistics_.bytes_of_points += part.size() * sizeof(PointT);
    ++part_statistics_.messages;
  }
  communicator_->exchange(out, from, in_);
  for (const Message& received : in_) part_statistics_.bytes_received += received.size();
  decodeIncoming(from);
  if (own() == root) mergeGathered(cells, part, from, in_, whole);
}

}  // namespace distributed
}  // namespace fuse_flow
