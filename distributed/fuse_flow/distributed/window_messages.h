#pragma once

#include <fuse_flow/distributed/coded_message.h>
#include <fuse_flow/distributed/part_pipeline.h>

#include <array>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief What is sent of one view to the rank that fuses some of the cells that it sees: depth where these cells look, and the points that
 *  lie in them. A message is a table of windows, and then the pixels of each: D; D^r where depth is smoothed; the view's own confidence where
 *  contradictions are weighed; a bit for each pixel that is a point; C of these points; their colours. */
struct WindowHeader {
  std::uint32_t view;
  PixelWindow window;
  std::uint32_t points;
};

/** \brief How many bytes each of a window's parts takes. */
struct WindowLayout {
  std::size_t depth, refined, confidence, bits, weights, colors;

  WindowLayout(const WindowHeader& header, bool smooths, bool with_confidence, std::size_t bytes_a_color) {
    const std::size_t pixels = header.window.pixels();
    depth = pixels * sizeof(float);
    refined = smooths ? depth : 0;
    confidence = with_confidence ? depth : 0;
    bits = (pixels + 7) / 8;
    weights = header.points * sizeof(float);
    colors = header.points * bytes_a_color;
  }
  std::size_t size() const { return depth + refined + confidence + bits + weights + colors; }

  /** \brief Of which kind these bytes are. Depth is as a sensor gave it, of few values, which a codec finds as they are; smoothed depth and C are
   *  of all values, like their neighbours'. */
  void addTo(MessageParts& parts) const {
    parts.push_back({depth});
    parts.push_back({refined, ByteKind::Words});
    parts.push_back({confidence});
    parts.push_back({bits});
    parts.push_back({weights, ByteKind::Words});
    parts.push_back({colors, colors == weights / sizeof(float) * sizeof(Rgb8) ? ByteKind::Colors : ByteKind::Any});
  }
};

/** \brief Rows of a window as they follow each other in a message. */
template <typename T, typename RowOf>
char* writeRows(const PixelWindow& window, const RowOf& row_of, char* to) {
  const std::size_t bytes = window.width() * sizeof(T);
  for (int v = window.top; v < window.bottom; ++v, to += bytes) std::memcpy(to, row_of(v) + window.left, bytes);
  return to;
}
template <typename T, typename RowOf>
const char* readRows(const PixelWindow& window, const char* from, const RowOf& row_of) {
  const std::size_t bytes = window.width() * sizeof(T);
  for (int v = window.top; v < window.bottom; ++v, from += bytes) std::memcpy(row_of(v) + window.left, from, bytes);
  return from;
}

/** \brief Writes the messages of one rank to all others, on many threads; keeps their memory. */
class WindowWriter {
 public:
  /** \param pipeline has measured the rank's views  \param own rank  \param ranks how many \returns the messages, by rank; the own one is
   *  empty */
  const std::vector<Message>& write(PartPipeline& pipeline, const BlockOwners& owners, const PartSummary& summary,
                                    int own, int ranks) {
    pipeline_ = &pipeline;
    ranks_ = static_cast<std::size_t>(ranks);
    views_.clear();
    for (const PartSummary::View& view : summary.views) views_.push_back(view.view);
    windows_.resize(views_.size() * ranks_);
    for (Window& window : windows_) window.header = {0, {}, 0};
    findWindows(owners, own);
    host::parallelFor(pipeline.resolvedThreads(), views_.size(),
                      [&](std::size_t k, int) { markPoints(owners, own, k); });
    layOut();
    host::parallelFor(pipeline.resolvedThreads(), windows_.size(), [&](std::size_t w, int) {
      if (!windows_[w].header.window.empty())
        writePixels(windows_[w], messages_[w % ranks_].data() + windows_[w].place);
    });
    return messages_;
  }

  /** \brief Of the last messages, what their bytes are, by rank. */
  const std::vector<MessageParts>& parts() const { return parts_; }

  /** \brief Of the last messages, what points take: D^r, C, colour. */
  std::size_t bytesOfPoints() const {
    std::size_t bytes = 0;
    for (const Window& window : windows_)
      if (window.header.points > 0)
        bytes += window.header.points * (2 * sizeof(float) + bytesAColor(window.header.view));
    return bytes;
  }

 private:
  struct Window {
    WindowHeader header;
    std::vector<std::uint8_t> bits;
    std::size_t place;  ///< of its pixels in the message
  };

  Window& windowOf(std::size_t k, int owner) { return windows_[k * ranks_ + static_cast<std::size_t>(owner)]; }

  /** \brief Of each view, what the cells of each rank ask for. */
  void findWindows(const BlockOwners& owners, int own) {
    const std::vector<ViewSet> askers = pipeline_->askers();
    const float side = static_cast<float>(1 << kBlockBits) * pipeline_->parameters.aggregation.cell_size;
    host::parallelFor(pipeline_->resolvedThreads(), views_.size(), [&](std::size_t k, int) {
      const std::size_t view = views_[k];
      const BoxProjection& project = pipeline_->projection(view);
      for (const BlockOwners::Block& block : owners.blocks()) {
        if (block.owner == own || !block.views.meets(askers[view])) continue;
        const host::Bounds box = blockBounds(block.key, side);
        if (pipeline_->geometry(view).frustum.mayShow(box))
          windowOf(k, block.owner).header.window.add(project(box, pipeline_->margin()));
      }
    });
  }

  /** \brief Which pixels of a view are points of whose cells. */
  void markPoints(const BlockOwners& owners, int own, std::size_t k) {
    const std::uint32_t view = views_[k];
    for (int r = 0; r < static_cast<int>(ranks_); ++r) {
      Window& window = windowOf(k, r);
      window.header.view = view;
      window.bits.assign((window.header.window.pixels() + 7) / 8, 0);
    }
    const auto width = static_cast<std::uint32_t>(pipeline_->geometry(view).intrinsics.width);
    std::uint64_t last = ~std::uint64_t{0};
    int owner = own;
    pipeline_->forEachRun(view, [&](std::uint32_t first, std::uint32_t count, std::uint64_t cell) {
      if (cell != last) owner = owners.ownerOf(cell);
      last = cell;
      if (owner == own) return;
      Window& window = windowOf(k, owner);
      const PixelWindow& at = window.header.window;
      for (std::uint32_t p = first; p < first + count; ++p) {
        const int u = static_cast<int>(p % width), v = static_cast<int>(p / width);
        if (u < at.left || u >= at.right || v < at.top || v >= at.bottom)
          throw std::logic_error("fuse_flow::distributed: a point lies outside of what is sent of its view");
        const std::size_t bit =
            static_cast<std::size_t>(v - at.top) * at.width() + static_cast<std::size_t>(u - at.left);
        window.bits[bit / 8] = static_cast<std::uint8_t>(window.bits[bit / 8] | 1u << bit % 8);
      }
      window.header.points += count;
    });
  }

  /** \brief Tables, and room for the pixels. */
  void layOut() {
    messages_.resize(ranks_);
    parts_.resize(ranks_);
    for (std::size_t r = 0; r < ranks_; ++r) {
      MessageWriter out(messages_[r]);
      std::uint32_t count = 0;
      for (std::size_t k = 0; k < views_.size(); ++k) count += windows_[k * ranks_ + r].header.window.empty() ? 0 : 1;
      out.put(count);
      for (std::size_t k = 0; k < views_.size(); ++k)
        if (!windows_[k * ranks_ + r].header.window.empty()) out.put(windows_[k * ranks_ + r].header);
      parts_[r] = {{messages_[r].size()}};
      for (std::size_t k = 0; k < views_.size(); ++k) {
        Window& window = windows_[k * ranks_ + r];
        if (window.header.window.empty()) continue;
        window.place = messages_[r].size();
        const WindowLayout layout = layoutOf(window.header);
        layout.addTo(parts_[r]);
        out.room(layout.size());
      }
    }
  }

  WindowLayout layoutOf(const WindowHeader& header) const {
    return {header, pipeline_->smooths(), static_cast<bool>(pipeline_->confidenceImage(header.view)),
            bytesAColor(header.view)};
  }
  std::size_t bytesAColor(std::size_t view) const {
    if (!pipeline_->with_color || !pipeline_->colorImage(view)) return 0;
    return pipeline_->resolvesColors(view) ? sizeof(ViewColor) : sizeof(Rgb8);
  }

  void writePixels(const Window& window, char* to) const {
    const std::size_t view = window.header.view;
    const PixelWindow& at = window.header.window;
    to = writeRows<float>(
        at, [&](int v) { return pipeline_->measured(view).row(v); }, to);
    if (pipeline_->smooths())
      to = writeRows<float>(
          at, [&](int v) { return pipeline_->refined(view).row(v); }, to);
    if (const ImageView<float> confidence = pipeline_->confidenceImage(view))
      to = writeRows<float>(
          at, [&](int v) { return confidence.row(v); }, to);
    std::memcpy(to, window.bits.data(), window.bits.size());
    to += window.bits.size();
    const float* weights = pipeline_->weights(view);
    const int width = pipeline_->geometry(view).intrinsics.width;
    forEachPoint(at, window.bits.data(), [&](int u, int v) {
      std::memcpy(to, weights + static_cast<std::ptrdiff_t>(v) * width + u, sizeof(float));
      to += sizeof(float);
    });
    const std::size_t bytes = bytesAColor(view);
    if (bytes == 0) return;
    const bool resolves = pipeline_->resolvesColors(view);
    forEachPoint(at, window.bits.data(), [&](int u, int v) {
      if (resolves) {
        const ViewColor color = pipeline_->color({static_cast<std::uint32_t>(view), u, v});
        std::memcpy(to, &color, bytes);
      } else {
        std::memcpy(to, pipeline_->colorImage(view).row(v) + u, bytes);
      }
      to += bytes;
    });
  }

 public:
  /** \brief Calls visit(u, v) for the pixels of a window whose bits are set, row by row. */
  template <typename Visit>
  static void forEachPoint(const PixelWindow& window, const std::uint8_t* bits, const Visit& visit) {
    std::size_t bit = 0;
    for (int v = window.top; v < window.bottom; ++v)
      for (int u = window.left; u < window.right; ++u, ++bit) {
        if (bit % 8 == 0 && bits[bit / 8] == 0 && u + 8 <= window.right) {
          u += 7;
          bit += 7;
          continue;
        }
        if ((bits[bit / 8] >> bit % 8 & 1) != 0) visit(u, v);
      }
  }

 private:
  PartPipeline* pipeline_{nullptr};
  std::size_t ranks_{1};
  std::vector<std::uint32_t> views_;
  std::vector<Window> windows_;  ///< view by view, rank by rank
  std::vector<Message> messages_;
  std::vector<MessageParts> parts_;
};

/** \brief Puts what others have sent into a rank's pipeline, on many threads. */
class WindowReader {
 public:
  /** \param messages by the rank that sent them, of \p from  \param parts of all ranks, by rank */
  void read(PartPipeline& pipeline, const std::vector<Message>& messages, const std::vector<int>& from,
            const std::vector<PartSummary>& parts) {
    pixels_.clear();
    for (std::size_t k = 0; k < messages.size(); ++k) readTable(pipeline, messages[k], from[k]);
    pipeline.beginLanding();
    std::vector<bool> landed(pipeline.cameras().size(), false);
    for (Pixels& pixels : pixels_) {
      pixels.landing = pipeline.land(pixels.header.view, pixels.header.window);
      landed[pixels.header.view] = true;
    }
    for (const int rank : from)
      for (const PartSummary::View& view : parts[static_cast<std::size_t>(rank)].views)
        if (!landed[view.view]) pipeline.land(view.view, {});
    host::parallelFor(pipeline.resolvedThreads(), pixels_.size(), [&](std::size_t k, int) {
      readPixels(pixels_[k], pipeline.geometry(pixels_[k].header.view).intrinsics.width);
    });
  }

  /** \brief That came with the last messages. */
  std::size_t points() const {
    std::size_t points = 0;
    for (const Pixels& pixels : pixels_) points += pixels.header.points;
    return points;
  }

 private:
  struct Pixels {
    int from;
    WindowHeader header;
    const char* begin;
    std::size_t size;
    PartPipeline::Landing landing;
  };

  void readTable(const PartPipeline& pipeline, const Message& message, int from) {
    MessageReader in(message, from);
    const std::size_t first = pixels_.size();
    const auto count = in.get<std::uint32_t>();
    if (count > pipeline.cameras().size()) in.fail("windows of more views than the rig has cameras");
    std::vector<bool> seen(pipeline.cameras().size(), false);
    for (std::uint32_t k = 0; k < count; ++k) {
      Pixels pixels{from, in.get<WindowHeader>(), nullptr, 0, {}};
      const WindowHeader& header = pixels.header;
      if (header.view >= seen.size() || seen[header.view] || pipeline.originOf(header.view) != from)
        in.fail("a window of a view that it does not have");
      seen[header.view] = true;
      const Intrinsics& K = pipeline.geometry(header.view).intrinsics;
      const PixelWindow& window = header.window;
      if (window.left < 0 || window.top < 0 || window.right > K.width || window.bottom > K.height || window.empty() ||
          header.points > window.pixels())
        in.fail("a window that is not within its view");
      pixels_.push_back(pixels);
    }
    for (std::size_t k = first; k < pixels_.size(); ++k) {
      const std::size_t view = pixels_[k].header.view;
      const std::size_t color = !pipeline.receivesColor(view)   ? 0
                                : pipeline.resolvesColors(view) ? sizeof(ViewColor)
                                                                : sizeof(Rgb8);
      pixels_[k].size =
          WindowLayout(pixels_[k].header, pipeline.smooths(), pipeline.receivesConfidence(view), color).size();
      pixels_[k].begin = in.take(pixels_[k].size, 1);
    }
    in.finish();
  }

  static void readPixels(const Pixels& pixels, int width) {
    const PartPipeline::Landing& to = pixels.landing;
    const PixelWindow& at = pixels.header.window;
    const char* from = readRows<float>(at, pixels.begin, [&](int v) { return to.measured->row(v); });
    if (to.refined) from = readRows<float>(at, from, [&](int v) { return to.refined->row(v); });
    const auto row_of = [&](auto* image) {
      return [image, width](int v) { return image + static_cast<std::ptrdiff_t>(v) * width; };
    };
    if (to.confidence) from = readRows<float>(at, from, row_of(to.confidence));
    const auto* bits = reinterpret_cast<const std::uint8_t*>(from);
    std::size_t points = 0;
    WindowWriter::forEachPoint(at, bits, [&](int, int) { ++points; });
    if (points != pixels.header.points) throw RankError(pixels.from, "sent another number of points than it said");
    from += (at.pixels() + 7) / 8;
    for (int v = at.top; v < at.bottom; ++v)
      std::fill(row_of(to.weights)(v) + at.left, row_of(to.weights)(v) + at.right, 0.0f);
    from = readPoints(at, bits, from, row_of(to.weights));
    if (to.color) from = readPoints(at, bits, from, row_of(to.color));
    if (to.resolved) readPoints(at, bits, from, row_of(to.resolved));
  }

  template <typename RowOf>
  static const char* readPoints(const PixelWindow& at, const std::uint8_t* bits, const char* from,
                                const RowOf& row_of) {
    WindowWriter::forEachPoint(at, bits, [&](int u, int v) {
      auto& value = row_of(v)[u];
      std::memcpy(static_cast<void*>(&value), from, sizeof value);
      from += sizeof value;
    });
    return from;
  }

  std::vector<Pixels> pixels_;
};

}  // namespace distributed
}  // namespace fuse_flow
