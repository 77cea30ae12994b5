#pragma once

#include <fuse_flow/distributed/gpu/device_exchange.h>
#include <fuse_flow/distributed/pixel_window.h>
#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/rig_frame.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Pixels of a row that lie in windows together: windows begin and end at multiples of them, so that few of the device's lines of
 *  memory are read or written in part. */
constexpr std::uint32_t kPixelGroup = 8;

/** \brief The smallest window of whole groups that holds another. It may end beyond the image, in the padding of its rows. */
inline PixelWindow wholeGroups(const PixelWindow& window) {
  constexpr auto group = static_cast<std::int32_t>(kPixelGroup);
  return {window.left / group * group, window.top, (window.right + group - 1) / group * group, window.bottom};
}

/** \brief What comes with the pixels of a view besides D and C. */
struct PlanesOfView {
  bool refined{false};     ///< D^r, where depth is smoothed
  bool confidence{false};  ///< the view's own, where contradictions are weighed
  bool color{false};

  /** \brief Bytes of a window: the planes one after the other. */
  std::size_t bytes(std::size_t pixels) const {
    const std::size_t floats = 2 + (refined ? 1u : 0u) + (confidence ? 1u : 0u);
    const std::size_t sum = pixels * (floats * sizeof(float) + (color ? sizeof(Rgb8) : 0));
    return (sum + 31) / 32 * 32;
  }
};

/** \brief A window in a message, in device memory. */
struct DeviceWindow {
  std::uint32_t view;
  std::int32_t left, top;
  std::uint32_t groups_in_row;
  std::int32_t rank;  ///< that sends or receives it
  std::uint32_t padding;
  ///@{
  /** \brief D; D^r; C of the points that are the receiver's, 0 elsewhere; the view's confidence; colour. Null where there is none. */
  float *depth, *refined, *weights, *confidence;
  Rgb8* color;
  ///@}
};

/** \brief Windows as the device sees them. Groups of pixels are numbered window by window, row by row. */
struct WindowList {
  const DeviceWindow* windows;
  const std::uint32_t* offsets;  ///< number of the first group of each
  std::uint32_t count;

  /** \brief Where a group is: its window, its number in it and its first pixel. */
  struct Place {
    const DeviceWindow* window;
    std::uint32_t group;
    int u, v;
  };
  FUSE_FLOW_HD Place placeOf(std::uint32_t group) const {
    const std::uint32_t w = gpu::lastUpTo(offsets, count, group);
    const DeviceWindow* const window = windows + w;
    const std::uint32_t local = group - offsets[w], row = local / window->groups_in_row;
    return {window, local, window->left + static_cast<int>((local - row * window->groups_in_row) * kPixelGroup),
            window->top + static_cast<int>(row)};
  }
};

/** \brief The windows that a rank sends, or those that it receives, and the memory of their pixels: one message for each other rank. */
class WindowBatch {
 public:
  struct Window {
    int rank;
    std::uint32_t view;
    PixelWindow window;  ///< of whole groups, not empty
  };

  /** \brief The stream must have been waited for. \param windows rank by rank  \param planes of each view */
  void layOut(gpu::Execution& run, const std::vector<Window>& windows, const std::vector<PlanesOfView>& planes) {
    std::vector<std::size_t> places;
    std::size_t bytes = 0;
    messages_.clear();
    for (const Window& of : windows) {
      if (messages_.empty() || messages_.back().rank != of.rank) {
        bytes = (bytes + 255) / 256 * 256;
        messages_.push_back({of.rank, nullptr, 0});
      }
      const std::size_t size = planes[of.view].bytes(of.window.pixels());
      places.push_back(bytes);
      bytes += size;
      messages_.back().bytes += size;
    }
    memory_.resize(bytes);
    std::size_t begin = 0;
    for (DeviceMessage& message : messages_) {
      begin = (begin + 255) / 256 * 256;
      message.data = memory_.data() + begin;
      begin += message.bytes;
    }
    putTable(run, windows, planes, places);
  }

  WindowList list() const { return {table_.data(), offsets_.data(), count_}; }
  /** \brief Of all windows. */
  std::size_t groups() const { return groups_; }
  std::size_t pixels() const { return groups_ * kPixelGroup; }
  const std::vector<DeviceMessage>& messages() const { return messages_; }
  std::size_t bytesOfMessages() const {
    std::size_t sum = 0;
    for (const DeviceMessage& message : messages_) sum += message.bytes;
    return sum;
  }

  std::size_t bytes() const { return memory_.bytes() + table_.bytes() + offsets_.bytes(); }

 private:
  /** \brief By view, so that the numbers of the pixels ascend from window to window. */
  void putTable(gpu::Execution& run, const std::vector<Window>& windows, const std::vector<PlanesOfView>& planes,
                const std::vector<std::size_t>& places) {
    order_.clear();
    for (std::size_t w = 0; w < windows.size(); ++w) order_.push_back(w);
    std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
      return std::make_pair(windows[a].view, a) < std::make_pair(windows[b].view, b);
    });
    count_ = static_cast<std::uint32_t>(windows.size());
    host_table_.resize(windows.size());
    host_offsets_.resize(windows.size());
    groups_ = 0;
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const Window& of = windows[order_[k]];
      const std::size_t pixels = of.window.pixels();
      char* place = memory_.data() + places[order_[k]];
      const auto plane = [&](bool there) {
        auto* const here = reinterpret_cast<float*>(place);
        if (there) place += pixels * sizeof(float);
        return there ? here : nullptr;
      };
      const PlanesOfView& with = planes[of.view];
      DeviceWindow& to = host_table_.data()[k];
      to = {of.view,       of.window.left,
            of.window.top, static_cast<std::uint32_t>(of.window.width() / kPixelGroup),
            of.rank,       0,
            nullptr,       nullptr,
            nullptr,       nullptr,
            nullptr};
      to.depth = plane(true);
      to.refined = plane(with.refined);
      to.weights = plane(true);
      to.confidence = plane(with.confidence);
      if (with.color) to.color = reinterpret_cast<Rgb8*>(place);
      host_offsets_.data()[k] = static_cast<std::uint32_t>(groups_);
      groups_ += pixels / kPixelGroup;
    }
    table_.resize(windows.size());
    offsets_.resize(windows.size());
    run.copy(table_.data(), std::as_const(host_table_).data(), windows.size());
    run.copy(offsets_.data(), std::as_const(host_offsets_).data(), windows.size());
  }

  std::vector<DeviceMessage> messages_;
  std::vector<std::size_t> order_;
  std::uint32_t count_{0};
  std::size_t groups_{0};
  gpu::PinnedBuffer<DeviceWindow> host_table_;
  gpu::PinnedBuffer<std::uint32_t> host_offsets_;
  gpu::DeviceBuffer<DeviceWindow> table_;
  gpu::DeviceBuffer<std::uint32_t> offsets_;
  gpu::DeviceBuffer<char> memory_;
};

}  // namespace distributed
}  // namespace fuse_flow
