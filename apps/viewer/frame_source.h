#pragma once

#include "simulation/simulator.h"

#include <fuse_flow/point_types.h>
#include <fuse_flow/recordings/recording.h>

#include <pcl/point_cloud.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief A cloud that came fused. */
struct FinishedCloud {
  std::shared_ptr<const pcl::PointCloud<PointFused>> cloud;  ///< null: there is none, frames are to be fused
  bool has_confidence{false}, counts_views{false};           ///< whether it came with these; else they are 0
};

/** \brief Where frames come from: a recording, or cameras that are simulated as it plays. */
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /** \brief For the window's title. */
  virtual std::string name() const = 0;
  /** \brief Absent: it never ends. */
  virtual std::optional<std::size_t> frameCount() const = 0;
  /** \brief At which frames were taken, Hz; > 0. Absent: nobody knows. */
  virtual std::optional<double> framesPerSecond() const = 0;
  /** \brief See io::Recording::inputs(). */
  virtual std::vector<std::string> inputs() const { return {}; }
  /** \brief Of cameras that run: how each of them does, a line each. */
  virtual std::vector<std::string> status() const { return {}; }
  /** \brief Throws io::InputError if the frame cannot be read. What was read last, into another object, stays valid until the next call. */
  virtual void read(std::size_t frame, io::LoadedFrame& out) = 0;
  /** \brief The cloud of the frame that was read last, of a source whose frames come fused. */
  virtual FinishedCloud finished() const { return {}; }
  /** \brief Whether finished() has clouds. */
  virtual bool isFinished() const { return false; }
  /** \brief Whether truth() can be asked. */
  virtual bool knowsTruth() const = 0;
  /** \brief The exact surfaces of a frame; valid until the next call of either. */
  virtual const simulation::RayScene& truth(std::size_t frame) = 0;
};

/** \brief Whether what was named is a link to a stream, or a file of one: ws://, wss://, http://, https:// or .ffs. See streamed_frames.h. */
bool isStream(const std::string& input);

/** \brief A recording of any kind; its truth is known if the folder holds one. Throws io::InputError. \param input the first of its paths */
std::unique_ptr<FrameSource> makeSource(std::unique_ptr<io::Recording> recording, const std::string& input);

/** \brief Simulated cameras, without an end. Throws io::InputError. */
std::unique_ptr<FrameSource> makeSimulatedSource(const simulation::SimulationOptions& options);

}  // namespace fuse_flow::viewing
