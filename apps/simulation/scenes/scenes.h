#pragma once

#include "simulation/scene.h"
#include "simulation/scenes/furniture.h"

#include <memory>
#include <utility>

namespace fuse_flow::simulation {

/** \brief A scene in which nothing moves. */
class StaticScene : public Scene {
 public:
  StaticScene(Objects objects, const Eigen::AlignedBox3f& subject, const Eigen::AlignedBox3f& room)
      : objects_(std::move(objects)), subject_(subject), room_(room) {}
  Objects fixedObjects() const override { return objects_; }
  Eigen::AlignedBox3f subject() const override { return subject_; }
  Eigen::AlignedBox3f room() const override { return room_; }

 private:
  Objects objects_;
  Eigen::AlignedBox3f subject_;
  Eigen::AlignedBox3f room_;
};

/** \brief 5 m × 4 m × 2.6 m, its floor around the origin. */
Eigen::AlignedBox3f livingRoom();

/** \brief Walls and furniture of the living room; the table with its chairs stands where it is said. */
Objects furnishedRoom(const Place& table, std::uint32_t seed);

/** \brief On three walls of a room. */
void addPictures(Objects& objects, const Eigen::AlignedBox3f& room);

/** \brief Names as furniture what is neither floor, ceiling nor wall. */
void nameFurniture(Objects& objects);

std::unique_ptr<Scene> makeRoomScene(std::uint32_t seed);
std::unique_ptr<Scene> makePersonScene(std::uint32_t seed);
std::unique_ptr<Scene> makePunchScene(std::uint32_t seed);
std::unique_ptr<Scene> makeHopScene(std::uint32_t seed);
std::unique_ptr<Scene> makeSitScene(std::uint32_t seed);
std::unique_ptr<Scene> makeHandScene(std::uint32_t seed);
std::unique_ptr<Scene> makeBallScene(std::uint32_t seed);
std::unique_ptr<Scene> makeSkirtScene(std::uint32_t seed);
std::unique_ptr<Scene> makeHandshakeScene(std::uint32_t seed);
std::unique_ptr<Scene> makePassScene(std::uint32_t seed);
std::unique_ptr<Scene> makePasserbyScene(std::uint32_t seed);
std::unique_ptr<Scene> makeThinScene(std::uint32_t seed);
std::unique_ptr<Scene> makeTableScene(std::uint32_t seed);

}  // namespace fuse_flow::simulation
