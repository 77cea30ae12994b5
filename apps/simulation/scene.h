#pragma once

#include "simulation/surfaces/mesh.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief A world of exact surfaces. Axes: z up, the floor at z = 0; metres and seconds. */
class Scene {
 public:
  virtual ~Scene() = default;

  /** \brief What never moves. */
  virtual std::vector<Object> fixedObjects() const = 0;
  /** \brief What moves or bends, at a time; the same objects with the same triangles at every time. Empty in a static
   *  scene. */
  virtual std::vector<Object> movingObjects(double time) const;

  /** \brief What the cameras of a ring look at. */
  virtual Eigen::AlignedBox3f subject() const = 0;
  /** \brief Inside of the walls: cameras stand within. */
  virtual Eigen::AlignedBox3f room() const = 0;
  /** \brief The middle of cameras that look outward, where the scene leaves a place free for them. */
  virtual std::optional<Eigen::Vector3f> lookout() const { return std::nullopt; }
};

/** \brief By a name of sceneNames(); the seed places the small things. Throws io::InputError on another name. */
std::unique_ptr<Scene> makeScene(const std::string& name, std::uint32_t seed);

/** \brief "room", "person", "thin", "table"; people who do something: "punch", "hop", "sit", "hand", "ball", "skirt",
 *  "handshake", "pass", "passerby". */
std::vector<std::string> sceneNames();

}  // namespace fuse_flow::simulation
