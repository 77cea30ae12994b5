#pragma once

#include <fuse_flow/distributed/gpu/device_windows.h>
#include <fuse_flow/distributed/message.h>
#include <fuse_flow/gpu/sensors/frame_views.h>

#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief The tables of the windows that ranks are about to send each other, so that each knows what comes. */
class WindowTables {
 public:
  /** \param windows of each own view and rank, view by view  \param views the own ones  \param messages receives the table for each rank
   *  \param sent receives the same, rank by rank */
  static void write(const std::vector<PixelWindow>& windows, const std::vector<std::uint32_t>& views, int own,
                    int ranks, std::vector<Message>& messages, std::vector<WindowBatch::Window>& sent) {
    messages.resize(static_cast<std::size_t>(ranks));
    sent.clear();
    for (int r = 0; r < ranks; ++r) {
      MessageWriter out(messages[static_cast<std::size_t>(r)]);
      if (r == own) continue;
      for (std::size_t k = 0; k < views.size(); ++k) {
        const PixelWindow& window = windows[k * static_cast<std::size_t>(ranks) + static_cast<std::size_t>(r)];
        if (window.empty()) continue;
        sent.push_back({r, views[k], wholeGroups(window)});
        out.put(Entry{views[k], sent.back().window});
      }
    }
  }

  /** \param messages by the rank that sent them, of \p from  \param origin whose view that of each camera is
   *  \param received receives what they say, rank by rank \throws RankError for windows that cannot be */
  static void read(const std::vector<Message>& messages, const std::vector<int>& from, const gpu::FrameViews& views,
                   const std::vector<int>& origin, std::vector<WindowBatch::Window>& received) {
    received.clear();
    std::vector<bool> seen(origin.size(), false);
    for (std::size_t k = 0; k < messages.size(); ++k) {
      MessageReader in(messages[k], from[k]);
      const std::size_t count = messages[k].size() / sizeof(Entry);
      for (std::size_t e = 0; e < count; ++e) {
        const auto entry = in.get<Entry>();
        if (entry.view >= origin.size() || origin[entry.view] != from[k] || seen[entry.view])
          in.fail("a window of a view that it does not have");
        seen[entry.view] = true;
        const gpu::DeviceView& view = views.hostView(entry.view);
        const PixelWindow& at = entry.window;
        if (at.empty() || at.left < 0 || at.top < 0 || at.right > static_cast<std::int32_t>(view.pitch) ||
            at.bottom > view.model.intrinsics.height || at.left % kPixelGroup != 0 || at.right % kPixelGroup != 0)
          in.fail("a window that is not within its view");
        received.push_back({from[k], entry.view, at});
      }
      in.finish();
    }
  }

 private:
  struct Entry {
    std::uint32_t view;
    PixelWindow window;
  };
};

}  // namespace distributed
}  // namespace fuse_flow
