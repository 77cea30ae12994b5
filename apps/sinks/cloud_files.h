#pragma once

#include "sinks/frame_sink.h"

#include <set>

namespace fuse_flow::io {

/** \brief Writes the cloud of each frame to a file: of a single frame to the one that is named, of several into a folder of that name. */
class CloudFiles : public FrameSink {
 public:
  /** \param output a .ply or .pcd file, or a folder  \param format of the files in a folder, "ply" or "pcd"  \param frames how many will come
   *  \param times timestamps.txt in the folder says when each frame was taken, a line "000000.ply SECONDS"
   *  \throws OptionError if it names one file for several frames, or a file of another kind */
  CloudFiles(std::string output, std::string format, std::size_t frames, bool times = false);

  /** \brief Where the cloud of a frame goes. */
  std::string pathOf(std::size_t frame) const;
  /** \brief The cloud of a frame comes from another process of this run. */
  void leaveToAnother(std::size_t frame) { left_.insert(pathOf(frame)); }
  void take(const std::shared_ptr<const FusedFrame>& frame) override;
  /** \brief Clouds in the folder that an earlier run has left and this one has not replaced: a reader of the folder would take them for
   *  frames of this recording. */
  std::vector<std::string> finish() override;

 private:
  std::string output_;
  std::string format_;
  bool names_file_{false};
  bool times_;
  std::set<std::string> written_, left_;
};

/** \brief Adds a line to the timestamps.txt beside a cloud's file: "000000.ply SECONDS". \param stamp microseconds \throws OutputError */
void addTime(const std::string& cloud, std::uint64_t stamp);

}  // namespace fuse_flow::io
