#pragma once

#include "live/live_rig.h"
#include "viewer/frame_source.h"
#include "viewer/fusing/latest_slot.h"

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief What cameras that run deliver, for the viewer: the latest instant, whatever frame is asked for. */
class LiveFrames : public FrameSource {
 public:
  using Instant = std::shared_ptr<const io::LiveInstant>;

  /** \brief The way from whoever takes instants from the rig, which is one thread, to this. */
  class Inlet {
   public:
    /** \brief Replaces one that nobody has looked at. */
    void put(Instant instant) { slot_.put(std::move(instant)); }
    /** \brief No more will come. */
    void end() { slot_.close(); }

   private:
    friend class LiveFrames;
    LatestSlot<Instant> slot_;
  };

  /** \param rig must stay  \param inlet where instants come from */
  LiveFrames(const io::LiveRig& rig, std::string name, std::shared_ptr<Inlet> inlet)
      : rig_(rig), name_(std::move(name)), inlet_(std::move(inlet)) {}

  std::string name() const override { return name_; }
  std::optional<std::size_t> frameCount() const override { return std::nullopt; }
  std::optional<double> framesPerSecond() const override { return std::nullopt; }
  std::vector<std::string> inputs() const override { return rig_.inputs(); }
  std::vector<std::string> status() const override;
  /** \brief Waits until there is a newer instant, for a second at most: then the last one is given again. \throws io::InputError if there has been
   *  none */
  void read(std::size_t frame, io::LoadedFrame& out) override;
  bool knowsTruth() const override { return false; }
  const simulation::RayScene& truth(std::size_t frame) override;

 private:
  const io::LiveRig& rig_;
  std::string name_;
  std::shared_ptr<Inlet> inlet_;
  Instant shown_;   ///< owns what the frame that was read points into
  Instant before_;  ///< owns what the frame before points into
};

}  // namespace fuse_flow::viewing
