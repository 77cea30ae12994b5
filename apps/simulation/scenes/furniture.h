#pragma once

#include "simulation/surfaces/mesh.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <string>
#include <vector>

namespace fuse_flow::simulation {

using Objects = std::vector<Object>;

/** \brief Floor, ceiling and four walls of a room; they face inwards. */
void addRoom(Objects& objects, const Eigen::AlignedBox3f& room);

/** \brief Standing on the floor at a place, turned about the vertical by an angle in radians. */
struct Place {
  float x;
  float y;
  float angle;
  /** \brief Where a point of a thing that stands there is: z from the floor, metres. */
  Eigen::Isometry3f pose(float z = 0) const;
};

constexpr float kTableHeight = 0.74f;

/** \brief With four legs; size: of the top. */
void addTable(Objects& objects, const Place& place, const Eigen::Vector2f& size);

/** \brief Round legs, a back of rods; it faces the place's y axis. */
void addChair(Objects& objects, const Place& place);

/** \brief 1 m high, books on its boards, which the seed chooses; its front faces the place's y axis. */
void addShelf(Objects& objects, const Place& place, float width, std::uint32_t seed);

void addSofa(Objects& objects, const Place& place);
void addFloorLamp(Objects& objects, const Place& place);

/** \brief In a pot on something of a height, leaves 1 to 3 mm thick; the seed turns them. */
void addPlant(Objects& objects, const Place& place, float standing_on, float height, std::uint32_t seed);

}  // namespace fuse_flow::simulation
