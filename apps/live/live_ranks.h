#pragma once

#include "live/camera_source.h"
#include "live/live_rig.h"

#include <fuse_flow/distributed/communicator.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

/** \file
 *  \brief Cameras that run at several ranks, as one rig. Rank 0 puts views together by time, by their stamps alone: images stay at the rank
 *  that has the camera. All ranks take steps together, and rank 0 says which: to tell it what came, to fuse an instant, or to end. */

namespace fuse_flow::io {

class RankSource;

/** \brief Which part of something a rank has: of `parts` equal ones, number `part`. */
struct RankPart {
  int part{0};
  int parts{1};
};

/** \brief First of all: which ranks play a recording, and that it is the same. Every rank calls it.  \param played what is played, in any words; empty:
 *  this rank plays nothing  \returns this rank's part of the recording; no parts if it plays nothing
 *  \throws distributed::RankError if a rank plays something else */
RankPart partOfPlayed(distributed::Communicator& patient, const std::string& played);

/** \brief Rank 0. Its LiveRig has the cameras of all ranks: of the others', views come as stamps, see LiveInstant::stamps. Not thread-safe: the
 *  thread that fuses calls everything. */
class LeadingRank {
 public:
  /** \param communicator of rank 0; must outlive this */
  explicit LeadingRank(distributed::Communicator& communicator) : communicator_(communicator) {}

  distributed::Communicator& communicator() { return communicator_; }

  /** \brief First: waits until the other ranks have opened their cameras. \param patient a communicator of the same ranks, that waits for as long
   *  as devices take  \returns the sources of a LiveRig, first \p own, then one for each other rank that has cameras
   *  \throws distributed::RankError */
  std::vector<std::unique_ptr<CameraSource>> meet(std::vector<std::unique_ptr<CameraSource>> own,
                                                  distributed::Communicator& patient);
  /** \brief Then, once it is known where all cameras stand, and nothing more can go wrong here: tells the others, who start theirs while this
   *  rank calls LiveRig::start(). \param cameras of the LiveRig */
  void begin(const std::vector<Camera>& cameras, distributed::Communicator& patient);
  /** \brief After LiveRig::start(): waits until the others have started theirs. */
  void awaitOthers(distributed::Communicator& patient);

  /** \brief Asks the others what came, and hands it to the LiveRig, whose LiveRig::start() was called. Often: what is not asked for is late.
   *  \throws distributed::RankError */
  void poll();
  /** \brief All ranks fuse this instant, each with its own images. Before Method::fuse(). \param refines whether all search for poses before that */
  void fuse(const LiveInstant& instant, bool refines = false);
  /** \brief The others end. */
  void stop();

 private:
  struct Other {
    int rank;
    std::size_t cameras;
    std::size_t first;   ///< of its cameras, among the LiveRig's
    RankSource* source;  ///< owned by the LiveRig; null: it has no cameras
  };
  void sendToAll(const std::vector<distributed::Message>& out, distributed::Communicator& communicator) const;

  distributed::Communicator& communicator_;
  std::vector<Other> others_;
  std::vector<distributed::Message> in_;
};

/** \brief Any other rank: its cameras, and what rank 0 says. */
class FollowingRank {
 public:
  /** \brief Opens nothing: the cameras have been. \param communicator of this rank, not rank 0; must outlive this  \param sources may be none, of
   *  a rank that only takes a share of the fusion */
  FollowingRank(distributed::Communicator& communicator, std::vector<std::unique_ptr<CameraSource>> sources);
  ~FollowingRank();
  FollowingRank(const FollowingRank&) = delete;
  FollowingRank& operator=(const FollowingRank&) = delete;

  /** \brief First: tells rank 0 which cameras are here, learns of all, and starts its own. \param patient as LeadingRank::meet() has it
   *  \throws distributed::RankError; InputError if a source cannot be started */
  void meet(distributed::Communicator& patient);
  /** \brief Of all ranks, as rank 0 has them. */
  const std::vector<Camera>& cameras() const { return cameras_; }

  /** \brief Until rank 0 ends. \param fuse is given each instant, with the images that are here, and whether all ranks search for poses; must call
   *  Method::fuse()  \throws distributed::RankError, and what \p fuse throws */
  void run(const std::function<void(const LiveInstant& instant, bool refines)>& fuse);

 private:
  struct Kept;  ///< what has come of the cameras here

  void report();
  void stop();
  LiveInstant instantOf(const distributed::Message& order);

  distributed::Communicator& communicator_;
  std::vector<std::unique_ptr<CameraSource>> sources_;
  std::size_t own_{0};    ///< cameras here
  std::size_t first_{0};  ///< of them, among all
  std::vector<Camera> cameras_;
  std::unique_ptr<Kept> kept_;
};

}  // namespace fuse_flow::io
