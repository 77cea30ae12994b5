#pragma once

#include "stream/codec/frame_layout.h"
#include "stream/gpu/layer_steps.h"
#include "stream/gpu/run_teams.h"

#include <fuse_flow/gpu/runtime/on_error.h>
#include <fuse_flow/gpu/runtime/stage_times.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace fuse_flow::stream {

/** \brief What GpuFrameEncoder does, on whatever the device is: CUDA where nvcc compiles it, else Thrust on the CPU, as the tests do. */
class DeviceFrameEncoder {
 public:
  explicit DeviceFrameEncoder(const EncodingOptions& options) : on_host_(options) {}

  const EncodingOptions& options() const { return on_host_.options(); }
  /** \brief Milliseconds of the last frame's stages, where they are measured. */
  gpu::StageTimes& times() { return times_; }

  std::shared_ptr<const EncodedFrame> encode(const CloudView& cloud, const FrameTimes& frame_times,
                                             gpu::Stream stream = {}) {
    const gpu::HomeDevice::Visit visit(home_);
    run_.stream = stream;
    const gpu::OnError settle([this] { run_.settle(); });
    times_.start(stream);
    if (cloud.size > kMostPoints || cloud.stride % 4 != 0) return encodeOnHost(cloud, frame_times);
    auto frame = std::make_shared<EncodedFrame>();
    frame->times = frame_times;
    frame->step = options().step;
    frame->fields = fieldsOf(cloud, options());
    frame->chroma_step = frame->fields & kColor ? options().chroma_step : 0;
    frame->layers = options().layers;
    frame->mask_bytes = frame->fields & kCameras ? 1 : 0;
    if (cloud.size == 0) return frame;

    Few<double, 3> first{};  // the origin in steps
    int bits = 0;
    if (!measure(cloud, *frame, first, bits)) return encodeOnHost(cloud, frame_times);
    if (frame->points == 0) return frame;
    sort(cloud, *frame, first, bits);
    const LayerGrid grid(frame->points, static_cast<std::uint32_t>(options().chunk_points),
                         static_cast<std::uint32_t>(options().layers), frame->fields, frame->mask_bytes,
                         frame->chroma_step);
    const PackLayers layers = write(cloud, grid);
    const std::uint32_t* report = join(layers);
    if (report[kTooManyAlike] != 0) return encodeOnHost(cloud, frame_times);
    take(grid, report, *frame);
    return frame;
  }

 private:
  /** \brief Beyond it, offsets would be more than a word, and what is needed more memory than there is. */
  static constexpr std::size_t kMostPoints = std::size_t{1} << 26;
  static constexpr double kMostOrigin =
      1e12;  ///< steps; further away, what rounding does to a point is more than a part of a step
  /** \brief What goes to the host beside the bytes: a flag, the boxes of the chunks, where each block begins. */
  enum Report : std::uint32_t { kTooManyAlike, kBoxes };

  /** \brief For clouds that are rare: so large that a lattice has no room for them, or with thousands of points in one place. */
  std::shared_ptr<const EncodedFrame> encodeOnHost(const CloudView& cloud, const FrameTimes& frame_times) {
    std::vector<unsigned char> points(cloud.size * cloud.stride);
    run_.copy(points.data(), cloud.points, points.size());
    run_.wait();
    CloudView here = cloud;
    here.points = points.data();
    return on_host_.encode(here, frame_times);
  }

  /** \brief Origin, number of points, size of masks. \param bits of a code \returns false: some points are too far from others */
  bool measure(const CloudView& cloud, EncodedFrame& frame, Few<double, 3>& first, int& bits) {
    extent_.resize(1);
    found_.resize(1);
    run_.fill(extent_.data(), 1, 0);
    const auto teams = static_cast<std::uint32_t>((cloud.size + MeasureCloud::kPoints - 1) / MeasureCloud::kPoints);
    forEachTeam(run_, "MeasureCloud", teams, MeasureCloud{cloud, (frame.fields & kCameras) != 0, extent_.data()});
    run_.copy(found_.data(), extent_.data(), 1);
    run_.wait();
    times_.mark("measure");
    const CloudExtent& found = *found_.data();
    frame.points = found.finite;
    frame.left_out = cloud.size - found.finite;
    if (frame.fields & kCameras)
      frame.mask_bytes =
          std::max(1, (bitLength(found.mask[0] | static_cast<std::uint64_t>(found.mask[1]) << 32) + 7) / 8);
    if (found.finite == 0) return true;
    const double step = options().step;
    for (int axis = 0; axis < 3; ++axis) {
      const float least = found.least(axis), most = found.most(axis);
      const auto k = static_cast<std::size_t>(axis);
      first[k] = originInSteps(least, step);
      if (!fitsLattice(least, most, step) || std::abs(first[k]) > kMostOrigin) return false;
      frame.origin[k] = first[k] * step;
      // One more than the last point can have, however that is rounded.
      const double steps = static_cast<double>(most) * (1 / step) - first[k] + 2;
      bits = std::max(bits, 3 * bitLength(static_cast<std::uint64_t>(steps)));
    }
    return true;
  }

  void sort(const CloudView& cloud, const EncodedFrame& frame, const Few<double, 3>& first, int bits) {
    for (gpu::DeviceBuffer<std::uint64_t>* buffer : {&codes_, &other_codes_}) buffer->resize(cloud.size);
    for (gpu::DeviceBuffer<std::uint32_t>* buffer : {&numbers_, &other_numbers_}) buffer->resize(cloud.size);
    const std::uint64_t nowhere = std::uint64_t{1} << bits;
    run_.forEach(cloud.size, CodePoint{cloud, 1 / options().step, first, nowhere, codes_.data(), numbers_.data()});
    times_.mark("codes");
    run_.sortByKey(codes_, other_codes_, numbers_, other_numbers_, cloud.size, bits + (frame.left_out > 0 ? 1 : 0));
    times_.mark("sort");
  }

  /** \brief All layers as they are, and then packed. */
  PackLayers write(const CloudView& cloud, const LayerGrid& grid) {
    const std::uint32_t points = grid.points, blocks = grid.frames() * grid.blocks;
    report_.resize(reportSize(grid));
    run_.fill(report_.data(), kBoxes + boxWords(grid), 0);
    values_.resize(points);
    masks_.resize(grid.fields & kCameras ? points : 0);
    run_.forEach(points, GatherPoint{cloud, grid.fields, grid.chroma_step, points, codes_.data(), numbers_.data(),
                                     values_.data(), masks_.data(), report_.data() + kTooManyAlike});
    const MeasureChunk boxes{points, grid.chunk_points, codes_.data(),
                             reinterpret_cast<ChunkBox*>(report_.data() + kBoxes)};
    forEachTeam(run_, "MeasureChunk", grid.chunks * boxes.teamsOfChunk(), boxes);
    times_.mark("gather");

    bytes_.resize(grid.firstByte(grid.frames()));
    packed_.resize(grid.firstPackedByte(grid.frames()));
    bits_.resize(points);
    bit_counts_.resize(points);
    bit_sums_.resize(std::size_t{points} + 1);
    run_.fill(bytes_.data(), grid.firstByte(grid.frames()), 0);
    run_.forEach(
        points,
        WritePoint{
            grid, {codes_.data(), values_.data(), masks_.data()}, bytes_.data(), bits_.data(), bit_counts_.data()});
    times_.mark("predict");
    run_.sumUp(bit_counts_.data(), points, bit_sums_.data());
    run_.forEach(points, PutBits{grid, bits_.data(), {bit_sums_.data()}, bytes_.data()});
    times_.mark("raw bits");

    arrays_.resize(blocks);
    checksums_.resize(grid.frames());
    sizes_.resize(blocks);
    const PackLayers layers{grid,           {bit_sums_.data()}, bytes_.data(), packed_.data(),
                            arrays_.data(), checksums_.data(),  sizes_.data()};
    forEachTeam(run_, "PackLayers", layers.teams(), layers);
    times_.mark("pack");
    return layers;
  }

  /** \brief The bytes to the host, with a report of what they are. */
  const std::uint32_t* join(const PackLayers& layers) {
    const LayerGrid& grid = layers.grid;
    const std::uint32_t blocks = grid.frames() * grid.blocks;
    std::uint32_t* begins = report_.data() + kBoxes + boxWords(grid);
    run_.sumUp(sizes_.data(), blocks, begins);
    message_.resize(grid.firstPackedByte(grid.frames()));
    forEachTeam(run_, "JoinBlocks", blocks, JoinBlocks{layers, begins, message_.data()});
    report_here_.resize(reportSize(grid));
    run_.copy(report_here_.data(), report_.data(), reportSize(grid));
    run_.wait();
    times_.mark("join");
    const std::uint32_t* report = report_here_.data();
    const std::uint32_t bytes = report[reportSize(grid) - 1];
    message_here_.resize(bytes);
    run_.copy(message_here_.data(), message_.data(), bytes);
    run_.wait();
    times_.mark("download");
    return report;
  }

  void take(const LayerGrid& grid, const std::uint32_t* report, EncodedFrame& frame) const {
    const auto* boxes = reinterpret_cast<const ChunkBox*>(report + kBoxes);
    const std::uint32_t* begins = report + kBoxes + boxWords(grid);
    const auto begin_of_layer = [&](std::uint32_t layer) { return begins[layer * grid.blocks]; };
    frame.chunks.resize(grid.chunks);
    for (std::uint32_t k = 0; k < grid.chunks; ++k) {
      EncodedChunk& chunk = frame.chunks[k];
      chunk.points = grid.pointsOfChunk(k);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        chunk.least[axis] = ~boxes[k].below[axis];
        chunk.greatest[axis] = boxes[k].greatest[axis];
      }
      for (std::uint32_t layer = 0; layer < grid.layers; ++layer) {
        const std::uint32_t number = grid.frame(k, layer);
        chunk.layer_points.push_back(grid.pointsOfLayer(number));
        chunk.layer_bytes.push_back(begin_of_layer(number + 1) - begin_of_layer(number));
      }
      chunk.bytes.assign(message_here_.data() + begin_of_layer(grid.frame(k, 0)),
                         message_here_.data() + begin_of_layer(grid.frame(k + 1, 0)));
    }
  }

  static std::uint32_t boxWords(const LayerGrid& grid) {
    return grid.chunks * static_cast<std::uint32_t>(sizeof(ChunkBox) / 4);
  }
  static std::uint32_t reportSize(const LayerGrid& grid) {
    return kBoxes + boxWords(grid) + grid.frames() * grid.blocks + 1;
  }

  gpu::HomeDevice home_{"fuse_flow::stream::GpuFrameEncoder"};  // first: nothing else is made without a device
  FrameEncoder on_host_;
  gpu::Execution run_;
  gpu::StageTimes times_;
  gpu::DeviceBuffer<CloudExtent> extent_;
  gpu::PinnedBuffer<CloudExtent> found_;
  gpu::DeviceBuffer<std::uint64_t> codes_, other_codes_, masks_, bits_;
  gpu::DeviceBuffer<std::uint32_t> numbers_, other_numbers_, bit_counts_, bit_sums_, checksums_, sizes_, report_;
  gpu::DeviceBuffer<PackedValues> values_;
  gpu::DeviceBuffer<std::uint8_t> bytes_, packed_, message_;
  gpu::DeviceBuffer<PackedArray> arrays_;
  gpu::PinnedBuffer<std::uint32_t> report_here_;
  gpu::PinnedBuffer<std::uint8_t> message_here_;
};

}  // namespace fuse_flow::stream
