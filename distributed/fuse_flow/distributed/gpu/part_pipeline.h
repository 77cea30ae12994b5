#pragma once

#include <fuse_flow/distributed/asked_views.h>
#include <fuse_flow/distributed/block_owners.h>
#include <fuse_flow/distributed/frame_digest.h>
#include <fuse_flow/distributed/gpu/block_table.h>
#include <fuse_flow/distributed/gpu/enter_points.h>
#include <fuse_flow/distributed/gpu/move_windows.h>
#include <fuse_flow/distributed/gpu/window_messages.h>
#include <fuse_flow/distributed/gpu/window_search.h>
#include <fuse_flow/distributed/part_meeting.h>
#include <fuse_flow/gpu/fusion/frame_pipeline.h>

#include <exception>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief PartPipeline's counterpart on the device: a rank's own views there become depth maps and weighted points, what others' cells look
 *  at goes to them, and the cells that the rank owns are fused by the steps of gpu::FramePipeline. Every pixel of the rig has its number
 *  of one process, whoever measured it; of the views of others only what has come is ever touched. */
class DevicePartPipeline : public gpu::FramePipeline {
 public:
  ///@{
  /** \brief Of the same ranks: for small messages, and for pixels. */
  Communicator* communicator{nullptr};
  DeviceExchange* exchange{nullptr};
  ///@}
  /** \brief Who fuses which cells; the same on all ranks. */
  Ownership ownership{Ownership::Curve};
  /** \brief Whether this rank takes a share of them. */
  bool fusing{true};
  /** \brief Of the settings that must be the same on all ranks, parameters among them. */
  std::uint64_t settings{0};
  /** \brief Of the last frame. */
  PartStatistics part_statistics;

  DevicePartPipeline() { views_.number_missing = views_.defer_colors = true; }

  /** \brief As in gpu::FramePipeline, of the cells of this rank. */
  std::size_t fuse(const RigFrame& frame, bool with_color, gpu::CamerasWanted wanted) {
    try {
      return fuseParts(frame, with_color, wanted);
    } catch (...) {
      views_.stopUpload(run);
      exchange_stream_.run.settle();
      throw;
    }
  }

  /** \brief The latest of the ranks' frames, microseconds. */
  std::uint64_t stamp() const {
    std::uint64_t latest = 0;
    for (const PartSummary& part : parts_) latest = std::max(latest, part.stamp);
    return latest;
  }

  std::size_t bytes() const {
    return gpu::FramePipeline::bytes() + block_table_.bytes() + block_slots_.bytes() + search_.bytes() + sent_.bytes() +
           received_.bytes() + received_colors_.bytes() + received_confidences_.bytes();
  }

 private:
  int own() const { return communicator->rank(); }
  int ranks() const { return communicator->size(); }
  std::size_t cameras() const { return views_.rig().size(); }
  PartSummary& summary() { return parts_[static_cast<std::size_t>(own())]; }

  std::size_t fuseParts(const RigFrame& frame, bool with_color, gpu::CamerasWanted wanted) {
    const Clock::time_point start = Clock::now();
    part_statistics = {};
    meet(frame, with_color, wanted);
    part_statistics.summary_ms = milliseconds(start, Clock::now());
    const Clock::time_point met = Clock::now();
    shareOut();
    if (ranks() > 1) {
      exchangeWindows();
    } else {
      received_.layOut(run, {}, planes_);
      views_.waitForColors(run);
      enterOwn(usualCapacity());
    }
    enterReceived();
    part_statistics.exchange_ms = milliseconds(met, Clock::now());
    aggregate();
    countPoints();
    return point_count_;
  }

  /** \brief This rank's part, and what the others say of theirs. */
  void meet(const RigFrame& frame, bool with_color, gpu::CamerasWanted wanted) {
    parts_.resize(static_cast<std::size_t>(ranks()));
    summary() = {};
    std::exception_ptr failure;
    try {
      measure(frame, with_color, wanted);
    } catch (const std::exception& error) {
      failure = std::current_exception();
      summary() = {};
      summary().error = error.what();
    }
    summary().parameters = settings;
    summary().fuses = fusing ? 1 : 0;
    part_statistics.views = summary().views.size();
    out_.resize(1);
    summary().write(out_[0]);
    exchangeWithAll(*communicator, out_, out_, in_, part_statistics);
    if (failure) std::rethrow_exception(failure);
    const std::vector<int> others = otherRanks(*communicator);
    for (std::size_t k = 0; k < others.size(); ++k)
      parts_[static_cast<std::size_t>(others[k])].read(in_[k], others[k], frame.cameras.size());
    checkParts(parts_, own());
    findOrigins(parts_, frame.cameras, origin_);
    combineStatistics(parts_, origin_, statistics);
    addViews();
    times.mark("meeting");
  }

  /** \brief Eq. 3, 8 and 9 for the rank's own views, and in which blocks their points lie. */
  void measure(const RigFrame& frame, bool with_color, gpu::CamerasWanted wanted) {
    start(frame, with_color, wanted);
    checkSupported(frame, with_color);
    summary().rig = FrameDigest().add(frame.cameras).value();  // while images are uploaded
    block_slots_.resize(views_.pixels());
    generate(block_table_.table(), block_table_.capacity(), [this](std::size_t capacity) {
      gpu::Counters* const counters = counters_.device(run);
      const BlocksOfViews blocks = block_table_.start(run, capacity, &counters->cells, &counters->table_too_full);
      launchGenerate(blocks, block_slots_.data());
      block_table_.gather(run);
    });
    summarise(frame, with_color);
  }

  void checkSupported(const RigFrame& frame, bool with_color) const {
    if (frame.cameras.size() > std::size_t{kMaxViewGroups} * kViewsOfGroup)
      throw pcl::PCLException("fuse_flow::distributed: the rig has " + std::to_string(frame.cameras.size()) +
                              " cameras; ranks with GPUs share at most " +
                              std::to_string(kMaxViewGroups * kViewsOfGroup));
    for (std::size_t i = 0; i < frame.views.size(); ++i)
      if (with_color && frame.cameras[i].color && frame.views[i].color && !frame.views[i].missing())
        throw pcl::PCLException("fuse_flow::distributed: camera '" + frame.cameras[i].name +
                                "' has a colour camera beside it, whose colours ranks with GPUs do not exchange: bring "
                                "them into the depth image first, leave colour out, or use device::Host");
  }

  void summarise(const RigFrame& frame, bool with_color) {
    PartSummary& part = summary();
    part.stamp = frame.stamp;
    part.gated = statistics.gated_points;
    own_views_.clear();
    for (std::size_t i = 0; i < frame.views.size(); ++i) {
      if (frame.views[i].missing()) continue;
      PartSummary::View view;
      view.view = static_cast<std::uint32_t>(i);
      view.measured = measured_on_host_.data()[i];
      view.noise_scale = statistics.noise_scales[i];
      view.has_color = with_color && frame.views[i].color ? 1 : 0;
      view.has_confidence = frame.views[i].confidence ? 1 : 0;
      for (const DepthOutOfRange& range : statistics.out_of_range)
        if (range.camera == i) {
          view.out_of_range = 1;
          view.range = range;
        }
      part.views.push_back(view);
      own_views_.push_back(view.view);
    }
    block_table_.blocks(run, counters_.host().cells, part.blocks);
  }

  /** \brief The views of others, as far as they are known before their pixels come. */
  void addViews() {
    planes_.assign(cameras(), {});
    std::vector<gpu::RemoteView> remote;
    bool any_color = false, any_confidence = false;
    for (std::size_t r = 0; r < parts_.size(); ++r)
      for (const PartSummary::View& view : parts_[r].views) {
        PlanesOfView& planes = planes_[view.view];
        planes.refined = maps_.refined() != maps_.measured();
        planes.color = view.has_color != 0;
        planes.confidence = view.has_confidence != 0 && parameters.consistency.weigh_contradictions;
        if (static_cast<int>(r) == own()) continue;
        any_color |= planes.color;
        any_confidence |= planes.confidence;
        remote.push_back(
            {view.view, parameters.adapt_noise ? view.noise_scale : 0.0f, planes.color, planes.confidence});
      }
    if (any_color) received_colors_.resize(views_.pixels());
    if (any_confidence) received_confidences_.resize(views_.pixels());
    views_.add(run, remote, any_color ? received_colors_.data() : nullptr,
               any_confidence ? received_confidences_.data() : nullptr);
  }

  /** \brief Who fuses what. */
  void shareOut() {
    owners_.assign(parts_, cameras(), ownership);
    part_statistics.imbalance = owners_.imbalance();
    std::vector<std::int32_t>& owners = owners_of_blocks_;
    owners.clear();
    owners_.forEachOwner(own(), [&owners](int owner) { owners.push_back(owner); });
    block_table_.setOwners(run, owners);
  }

  /** \brief What the cells of others look at goes to them, and what this rank's cells look at comes. */
  void exchangeWindows() {
    const float side = static_cast<float>(1 << kBlockBits) * parameters.aggregation.cell_size;
    search_.find(run, views_.rig(), summary().rig, owners_, own_views_,
                 askersOfViews(views_.rig(), origin_, parameters), own(), ranks(), side, lookingMargin(parameters),
                 windows_);
    times.mark("windows");
    WindowTables::write(windows_, own_views_, own(), ranks(), out_, windows_to_send_);
    exchangeWithAll(*communicator, out_, out_, in_, part_statistics);
    WindowTables::read(in_, otherRanks(*communicator), views_, origin_, windows_to_receive_);
    sent_.layOut(run, windows_to_send_, planes_);
    received_.layOut(run, windows_to_receive_, planes_);
    times.mark("tables");
    views_.waitForColors(run);
    times.mark("colours");
    run.forEach(sent_.pixels(), PackWindows{sent_.list(), views_.grid().views, maps_.measured(), maps_.refined(),
                                            points_.data(), block_slots_.data(), block_table_.owners()});
    times.mark("pack", 2.0 * static_cast<double>(sent_.bytesOfMessages()));
    exchange_stream_.leave(run.stream);
    enterOwn(usualCapacity());  // while pixels are on their way
    exchange->exchange(exchange_stream_.run, sent_.messages(), received_.messages());
    exchange_stream_.join(run.stream);
    times.mark("exchange", 2.0 * static_cast<double>(received_.bytesOfMessages()));
    run.forEach(received_.pixels(),
                UnpackWindows{received_.list(), views_.grid().views, maps_.measuredToFill(), maps_.refinedToFill(),
                              points_.data(), received_confidences_.data(), received_colors_.data()});
    times.mark("unpack", 2.0 * static_cast<double>(received_.bytesOfMessages()));
    part_statistics.messages += sent_.messages().size();
    part_statistics.bytes_sent += sent_.bytesOfMessages();
    part_statistics.bytes_plain += sent_.bytesOfMessages();
    part_statistics.bytes_received += received_.bytesOfMessages();
  }

  std::size_t usualCapacity() const { return std::max(table_.capacity(), std::size_t{views_.pixels()} / 64); }

  EnterPoints enterStep() {
    return {{table_view_}, 1.0f / parameters.aggregation.cell_size, points_.data(), slots_.data()};
  }

  /** \brief The points of the rank's own views that lie in its cells, into these cells. \param capacity of their table */
  void enterOwn(std::size_t capacity) {
    slots_.resize(views_.pixels());
    run.fill(slots_.data(), views_.pixels(), 0xff);
    startTable(capacity);
    enterOwnPoints(run, {enterStep(), views_.tiles(), block_slots_.data(), block_table_.owners(), own()}, chunks());
    times.mark("own cells");
  }

  /** \brief After them the points that have come; all again where the table was too small. */
  void enterReceived() {
    for (;;) {
      enterReceivedPoints(run, {enterStep(), views_.grid().views, received_.list()}, received_.groups());
      times.mark("received cells");
      if (counters_.read(run).table_too_full == 0) return;
      enterOwn(4 * table_.capacity());
    }
  }

  void countPoints() {
    part_statistics.cells = counters_.host().cells;
    part_statistics.points = static_cast<std::size_t>(owners_.pointsOf(own()));
    std::size_t own_points = 0, given = 0;
    for (std::size_t b = 0; b < owners_of_blocks_.size(); ++b)
      (owners_of_blocks_[b] == own() ? own_points : given) += summary().blocks[b].points;
    part_statistics.foreign_points = part_statistics.points - own_points;
    bool color = false;
    for (const PartSummary::View& view : summary().views) color |= view.has_color != 0;
    part_statistics.bytes_of_points = given * (2 * sizeof(float) + (color ? sizeof(Rgb8) : 0));
  }

  std::vector<PartSummary> parts_;  ///< by rank
  std::vector<int> origin_;         ///< whose view that of each camera is
  std::vector<std::uint32_t> own_views_;
  std::vector<PlanesOfView> planes_;
  BlockOwners owners_;
  std::vector<std::int32_t> owners_of_blocks_;  ///< of PartSummary::blocks
  std::vector<PixelWindow> windows_;
  std::vector<WindowBatch::Window> windows_to_send_, windows_to_receive_;
  std::vector<Message> out_, in_;
  BlockTable block_table_;
  gpu::DeviceBuffer<std::uint32_t> block_slots_;
  WindowSearch search_;
  WindowBatch sent_, received_;
  gpu::SideStream exchange_stream_;
  gpu::DeviceBuffer<Rgb8> received_colors_;
  gpu::DeviceBuffer<float> received_confidences_;
};

}  // namespace distributed
}  // namespace fuse_flow
