#pragma once

#include <fuse_flow/gpu/runtime/copy_threads.h>
#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/gpu/runtime/memory_of.h>
#include <fuse_flow/gpu/runtime/side_stream.h>
#include <fuse_flow/gpu/runtime/stream_copy.h>
#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/gpu/sensors/tiles.h>
#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief A view of a frame that is not here but elsewhere: see FrameViews::add(). */
struct RemoteView {
  std::uint32_t view;
  /** \brief 0: that of the model. */
  float noise_scale;
  bool has_color, has_confidence;
};

/** \brief What is known of the views of a frame once others are known too. What has been measured here stays. */
struct AddViews {
  const DeviceView* known;
  DeviceView* views;

  FUSE_FLOW_HD void operator()(std::uint32_t i) const {
    DeviceView view = known[i];
    if (views[i].present) {
      view.noise = views[i].noise;
      view.slope = views[i].slope;
    }
    views[i] = view;
  }
};

/** \brief Cameras and images of a frame on the device. Geometry is uploaded when the calibration changes; images that are on
 *  the device stay where they are, pinned ones are fetched by the copy engine, others go through a pinned staging buffer. */
class FrameViews {
 public:
  /** \brief Whether the frame is a part of one: its missing cameras may have views elsewhere, and their pixels have numbers. Views of others
   *  are known from add() on; nothing but what a view has measured itself can be asked before. */
  bool number_missing{false};
  /** \brief Whether colours are uploaded after all depth and beside what follows, on a stream of their own; nobody may ask for them before
   *  waitForColors(). */
  bool defer_colors{false};

  /** \brief Returns at once on CUDA; the frame's images must stay alive until the stream has passed. \param confidence null: the noise of
   *  cameras without a model of their own is not known */
  void assign(Execution& run, const RigFrame& frame, const ConfidenceParameters* confidence, bool with_color,
              int threads) {
    const std::size_t n = frame.cameras.size();
    // A frame that ran out of memory here may have left half of it: then all is uploaded again.
    const bool calibrated = rig_.update(frame) || !geometry_uploaded_;
    geometry_uploaded_ = false;
    if (calibrated) uploadGeometry(run);
    if (number_missing) {
      if (calibrated) present_.clear();
      neighbour_counts_.resize(n);
      neighbours_.resize(n * (n - 1));
    } else if (updatePresence([&](std::size_t i) { return !frame.views[i].missing(); }) || calibrated) {
      uploadNeighbours(run);
    }
    geometry_uploaded_ = true;
    views_.resize(n);
    has_multipath_ = false;
    layOutImages(frame, with_color);
    for (std::size_t i = 0; i < n; ++i) {
      DeviceView& view = views_.data()[i];
      const host::ViewGeometry& geometry = rig_[i];
      view = {};
      setGeometry(i);
      if (confidence != nullptr) {
        view.noise = viewNoise(*confidence, geometry.ownNoise());
        view.slope = slopeScale(*confidence, 1.0f / geometry.intrinsics.fx, view.noise);
      } else {
        view.noise = geometry.noise ? ViewNoise{*geometry.noise, 1.0f, 1.0f} : ViewNoise{{}, 0.0f, 1.0f};
      }
      view.depth_scale = frame.cameras[i].depth_scale;
      view.present = !frame.views[i].missing();
      has_multipath_ |= view.present && geometry.multipath.modulation_frequency > 0;
    }
    offsets_.resize(2 * (n + 1));
    const GridSize size = layOutPixels(views_.data(), n, offsets_.data(), number_missing);
    if (size.pixels > kMaxPixels) throw pcl::PCLException("fuse_flow::gpu: a frame has more than 2^27 pixels");
    pixels_ = static_cast<std::uint32_t>(size.pixels);
    tiles_ = size.tiles;
    uploadImages(run, frame, with_color, threads);
    layOutColorDepth(frame, with_color);
    device_views_.resize(n);
    device_offsets_.resize(2 * (n + 1));
    run.copySmall(device_views_.data(), std::as_const(views_).data(), n);
    run.copySmall(device_offsets_.data(), std::as_const(offsets_).data(), 2 * (n + 1));
  }

  /** \brief Of a frame whose missing cameras are numbered: the views that others have. The stream must have been waited for; so must it be
   *  before the next frame. \param colors of all pixels by their numbers, null: without  \param confidences likewise */
  void add(Execution& run, const std::vector<RemoteView>& remote, const Rgb8* colors, const float* confidences) {
    const std::size_t n = rig_.size();
    bool tabulated = false;
    for (const RemoteView& of : remote) {
      tabulated |= !rig_[of.view].hasTables();
      rig_.tabulate(of.view);
      DeviceView& view = views_.data()[of.view];
      view.present = true;
      if (of.noise_scale > 0) view.noise.scale = of.noise_scale;
      const Intrinsics& K = view.model.intrinsics;
      if (colors != nullptr && of.has_color)
        view.color = {colors + view.offset, K.width, K.height, view.pitch * sizeof(Rgb8)};
      if (confidences != nullptr && of.has_confidence)
        view.confidence = {confidences + view.offset, K.width, K.height, view.pitch * sizeof(float)};
    }
    geometry_uploaded_ = false;
    if (tabulated) uploadGeometry(run);
    if (updatePresence([&](std::size_t i) { return views_.data()[i].present; })) uploadNeighbours(run);
    geometry_uploaded_ = true;
    for (std::size_t i = 0; i < n; ++i) setGeometry(i);
    known_views_.resize(n);
    run.copySmall(known_views_.data(), std::as_const(views_).data(), n);
    run.forEach(n, AddViews{known_views_.data(), device_views_.data()});
  }

  /** \brief What is launched from now on finds the colours. */
  void waitForColors(Execution& run) {
    if (!colors_under_way_) return;
    color_upload_->join(run.stream);
    colors_under_way_ = false;
  }
  /** \brief Of a frame that ends early: the host waits until nothing reads its images any more. */
  void stopUpload(Execution& run) noexcept {
    run.settle();
    if (color_upload_) color_upload_->run.settle();
    colors_under_way_ = false;
  }

  static constexpr std::size_t kMaxPixels = std::size_t{1} << 27;

  PixelGrid grid() const {
    return {device_views_.data(), device_offsets_.data(), static_cast<std::uint32_t>(rig_.size())};
  }
  /** \brief Whether the depth of any view that is there is to be corrected for multipath interference. */
  bool hasMultipath() const { return has_multipath_; }
  TileGrid tiles() const { return {grid(), device_offsets_.data() + rig_.size() + 1, tiles_}; }
  /** \brief As uploaded. */
  const DeviceView& hostView(std::size_t i) const { return views_.data()[i]; }
  /** \brief For what is measured on the device. */
  DeviceView* deviceViews() { return device_views_.data(); }
  /** \brief Padded pixels of all views: a multiple of kChunk. */
  std::uint32_t pixels() const { return pixels_; }
  /** \brief The cells of the ColorDepth of all views. */
  std::uint32_t* colorDepthCells() { return color_depth_.data(); }
  /** \brief How many there are: none where depth and colour cameras are the same. */
  std::size_t colorDepthCellCount() const { return color_depth_count_; }
  /** \brief Of the last frame's images, over the bus. */
  std::size_t uploadedBytes() const { return uploaded_; }
  const host::RigGeometry& rig() const { return rig_; }
  std::size_t bytes() const {
    return device_views_.bytes() + known_views_.bytes() + rays_.bytes() + corrections_.bytes() + neighbours_.bytes() +
           images_.bytes() + device_offsets_.bytes() + color_depth_.bytes();
  }

 private:
  /** \brief Cells for the views whose colour camera stands beside, one view after the other. */
  void layOutColorDepth(const RigFrame& frame, bool with_color) {
    std::size_t total = 0;
    const auto forEachOwn = [&](const auto& visit) {
      for (std::size_t i = 0; i < rig_.size(); ++i)
        if (with_color && rig_[i].own_color_camera && frame.views[i].color && !frame.views[i].missing())
          visit(views_.data()[i].color_depth, ColorDepth::of(rig_[i].color_intrinsics, rig_[i].intrinsics));
    };
    forEachOwn([&](ColorDepth&, const ColorDepth& cells) { total += cells.size(); });
    color_depth_.resize(total);
    color_depth_count_ = total;
    std::size_t place = 0;
    forEachOwn([&](ColorDepth& of_view, const ColorDepth& cells) {
      of_view = cells;
      of_view.nearest = color_depth_.data() + place;
      place += cells.size();
    });
  }

  /** \brief What a view looks like from its calibration, and whom its points ask. */
  void setGeometry(std::size_t i) {
    DeviceView& view = views_.data()[i];
    const host::ViewGeometry& geometry = rig_[i];
    view.model = geometry;
    view.rays = geometry.ideal ? nullptr : rays_.data() + ray_offsets_[i];
    view.corrections = geometry.corrections().empty() ? nullptr : corrections_.data() + correction_offsets_[i];
    view.neighbours = neighbours_.data() + i * (rig_.size() - 1);
    view.neighbour_count = neighbour_counts_[i];
  }

  /** \brief Whether the cameras that are there have changed. */
  template <typename IsThere>
  bool updatePresence(const IsThere& is_there) {
    bool changed = present_.size() != rig_.size();
    present_.resize(rig_.size());
    for (std::size_t i = 0; i < rig_.size(); ++i) {
      const std::uint8_t present = is_there(i) ? 1 : 0;
      changed |= present_[i] != present;
      present_[i] = present;
    }
    return changed;
  }

  void uploadGeometry(Execution& run) {
    uploadTables(
        run, [](const auto& view) -> const auto& { return view.rays(); }, ray_offsets_, rays_);
    uploadTables(
        run, [](const auto& view) -> const auto& { return view.corrections(); }, correction_offsets_, corrections_);
  }

  /** \brief Tables of all views, one after the other, of what geometry knows of each pixel; most views have none. */
  template <typename Entry, typename TableOf>
  void uploadTables(Execution& run, const TableOf& table_of, std::vector<std::size_t>& offsets,
                    DeviceBuffer<Entry>& on_device) {
    const std::size_t n = rig_.size();
    offsets.assign(n + 1, 0);
    for (std::size_t i = 0; i < n; ++i) offsets[i + 1] = offsets[i] + table_of(rig_[i]).size();
    PinnedBuffer<Entry> tables;
    tables.resize(offsets[n]);
    for (std::size_t i = 0; i < n; ++i)
      std::copy(table_of(rig_[i]).begin(), table_of(rig_[i]).end(), tables.data() + offsets[i]);
    run.wait();  // for the last frame that used what is there
    on_device.resize(offsets[n]);
    run.copy(on_device.data(), tables.data(), offsets[n]);
    run.wait();
  }

  /** \brief Without the missing cameras, so that no point has to skip them. */
  void uploadNeighbours(Execution& run) {
    const std::size_t n = rig_.size();
    host_neighbours_.resize(n * (n - 1));
    neighbour_counts_.assign(n, 0);
    for (std::size_t i = 0; i < n; ++i)
      for (const std::uint32_t j : rig_[i].neighbours)
        if (present_[j]) host_neighbours_.data()[i * (n - 1) + neighbour_counts_[i]++] = j;
    neighbours_.resize(n * (n - 1));
    run.copy(neighbours_.data(), host_neighbours_.data(), n * (n - 1));
  }

  /** \brief Visits every image of a frame that must be uploaded, one after the other; place: its position in the buffers. */
  template <typename Visit>
  void forEachImage(const RigFrame& frame, bool with_color, const Visit& visit) {
    for (std::size_t i = 0; i < frame.views.size(); ++i) {
      const DepthView& view = frame.views[i];
      if (view.missing()) continue;
      if (view.depth16) visit(view.depth16, views_.data()[i].depth16);
      if (view.depth32) visit(view.depth32, views_.data()[i].depth32);
      if (view.confidence) visit(view.confidence, views_.data()[i].confidence);
      if (view.color && with_color && !defer_colors) visit(view.color, views_.data()[i].color);
    }
    for (std::size_t i = 0; defer_colors && with_color && i < frame.views.size(); ++i)
      if (!frame.views[i].missing() && frame.views[i].color) visit(frame.views[i].color, views_.data()[i].color);
  }

  struct Transfer {
    const char* from;
    std::size_t row_bytes, rows, stride;
    std::size_t place;
    Memory memory;

    std::size_t bytes() const { return row_bytes * rows; }
  };
  /** \brief Rows of an image that one thread copies. */
  struct Block {
    std::size_t image, row, rows, piece;
  };
  /** \brief What is sent off at a time. */
  struct Piece {
    std::size_t begin, end, blocks;
  };

  void layOutImages(const RigFrame& frame, bool with_color) {
    transfers_.clear();
    std::size_t total = 0, staged = 0;
    forEachImage(frame, with_color, [&](const auto& image, auto&) {
      const std::size_t row_bytes = sizeof(*image.data) * static_cast<std::size_t>(image.width);
      const std::size_t rows = static_cast<std::size_t>(image.height);
      const Memory memory = memoryOf(image.data);
      transfers_.push_back(
          {reinterpret_cast<const char*>(image.data), row_bytes, rows, image.row_stride, total, memory});
      const std::size_t bytes = memory == Memory::Device ? 0 : (row_bytes * rows + 255) / 256 * 256;
      total += bytes;
      if (memory == Memory::Pageable) staged = total;
    });
    images_.resize(total);
    staging_.resize(staged);
    uploaded_ = total;
  }

  void uploadImages(Execution& run, const RigFrame& frame, bool with_color, int threads) {
    std::size_t t = 0;
    forEachImage(frame, with_color, [&](const auto& image, auto& on_device) {
      const Transfer& transfer = transfers_[t++];
      on_device = image;
      if (transfer.memory == Memory::Device) return;
      on_device.data = reinterpret_cast<decltype(image.data)>(images_.data() + transfer.place);
      on_device.row_stride = transfer.row_bytes;
    });
    const std::size_t colors = defer_colors ? firstColor(frame, with_color) : transfers_.size();
    uploadSome(run, 0, colors, threads);
    if (colors == transfers_.size()) return;
    if (!color_upload_) color_upload_ = std::make_unique<SideStream>();
    color_upload_->leave(run.stream);
    colors_under_way_ = true;
    uploadSome(color_upload_->run, colors, transfers_.size(), threads);
  }

  /** \brief Of the transfers; colours come last. */
  std::size_t firstColor(const RigFrame& frame, bool with_color) const {
    std::size_t colors = 0;
    for (const DepthView& view : frame.views) colors += with_color && !view.missing() && view.color ? 1 : 0;
    return transfers_.size() - colors;
  }

  void uploadSome(Execution& run, std::size_t begin, std::size_t end, int threads) {
    for (std::size_t k = begin; k < end;) {
      if (transfers_[k].memory == Memory::Pageable) {
        k = uploadThroughStaging(run, k, end, threads);
      } else {
        upload(run, transfers_[k++]);
      }
    }
  }

  /** \brief From where the device reaches it. */
  void upload(Execution& run, const Transfer& transfer) {
    if (transfer.memory == Memory::Device) return;
    char* to = images_.data() + transfer.place;
    if (transfer.stride == transfer.row_bytes) {
      run.copy(to, transfer.from, transfer.bytes());
      return;
    }
#if FUSE_FLOW_CUDA
    check(cudaMemcpy2DAsync(to, transfer.row_bytes, transfer.from, transfer.stride, transfer.row_bytes, transfer.rows,
                            cudaMemcpyHostToDevice, run.stream),
          "cudaMemcpy2DAsync");
#endif
  }

  /** \brief Pageable images, from number first on and before end, by all threads, some megabytes after the other: the calling thread sends off what has been
   *  staged, while the others go on. \return the number of the image after them */
  std::size_t uploadThroughStaging(Execution& run, std::size_t first, std::size_t end, int threads) {
    const std::size_t next = cutIntoPieces(first, end);
    std::size_t sent = 0;
    const auto send = [&] {
      for (; sent < pieces_.size() && pieces_left_[sent].load(std::memory_order_acquire) == 0; ++sent)
        run.copy(images_.data() + pieces_[sent].begin, std::as_const(staging_).data() + pieces_[sent].begin,
                 pieces_[sent].end - pieces_[sent].begin);
    };
    host::parallelFor(threads, blocks_.size(), [&](std::size_t k, int thread) {
      stage(blocks_[k]);
      pieces_left_[blocks_[k].piece].fetch_sub(1, std::memory_order_release);
      if (thread == 0) send();
    });
    send();
    return next;
  }

  /** \brief Consecutive pageable images, from number first on and before end, as blocks for a thread each and pieces for the bus. \return the number of
   *  the image after them */
  std::size_t cutIntoPieces(std::size_t first, std::size_t end) {
    constexpr std::size_t piece = 2 << 20, block = 1 << 17;
    blocks_.clear();
    pieces_.clear();
    std::size_t next = first;
    for (; next < end && transfers_[next].memory == Memory::Pageable; ++next) {
      const Transfer& image = transfers_[next];
      if (pieces_.empty() || image.place >= pieces_.back().begin + piece) pieces_.push_back({image.place, 0, 0});
      const std::size_t rows = std::max<std::size_t>(1, block / image.row_bytes);
      for (std::size_t row = 0; row < image.rows; row += rows) {
        blocks_.push_back({next, row, std::min(rows, image.rows - row), pieces_.size() - 1});
        ++pieces_.back().blocks;
      }
      pieces_.back().end = image.place + image.bytes();
    }
    if (pieces_left_size_ < pieces_.size()) {
      pieces_left_size_ = pieces_.size();
      pieces_left_ = std::make_unique<std::atomic<std::size_t>[]>(pieces_left_size_);
    }
    for (std::size_t k = 0; k < pieces_.size(); ++k) pieces_left_[k] = pieces_[k].blocks;
    return next;
  }

  void stage(const Block& block) {
    const Transfer& image = transfers_[block.image];
    char* to = staging_.data() + image.place + block.row * image.row_bytes;
    const char* from = image.from + block.row * image.stride;
    if (image.stride == image.row_bytes) {
      streamCopy(to, from, block.rows * image.row_bytes);
    } else {
      for (std::size_t row = 0; row < block.rows; ++row)
        streamCopy(to + row * image.row_bytes, from + row * image.stride, image.row_bytes);
    }
  }

  host::RigGeometry rig_;
  std::unique_ptr<SideStream> color_upload_;  ///< of colours that are deferred
  bool colors_under_way_{false};
  bool geometry_uploaded_{false}, has_multipath_{false};
  std::vector<std::size_t> ray_offsets_, correction_offsets_;
  std::vector<std::uint8_t> present_;
  std::vector<std::uint32_t> neighbour_counts_;
  PinnedBuffer<std::uint32_t> host_neighbours_;
  std::vector<Transfer> transfers_;
  std::vector<Block> blocks_;
  std::vector<Piece> pieces_;
  std::unique_ptr<std::atomic<std::size_t>[]> pieces_left_;  ///< blocks that are not staged
  std::size_t pieces_left_size_{0};
  PinnedBuffer<DeviceView> views_;
  PinnedBuffer<std::uint32_t> offsets_;
  PinnedBuffer<char> staging_;
  DeviceBuffer<DeviceView> device_views_, known_views_;
  DeviceBuffer<std::uint32_t> device_offsets_, neighbours_;
  DeviceBuffer<Ray> rays_;
  DeviceBuffer<DepthCorrectionTerms> corrections_;
  DeviceBuffer<char> images_;
  DeviceBuffer<std::uint32_t> color_depth_;
  std::size_t color_depth_count_{0};
  std::uint32_t pixels_{0};
  std::uint32_t tiles_{0};
  std::size_t uploaded_{0};
};

}  // namespace gpu
}  // namespace fuse_flow
