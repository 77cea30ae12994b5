#pragma once

#include <fuse_flow/depth_view.h>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief A triangle mesh; counter-clockwise seen from outside. */
struct TriangleMesh {
  /** \brief World frame, metres. */
  std::vector<Eigen::Vector3f> vertices;
  /** \brief Where each vertex was when the object was made, metres: textures stay on a body that moves and bends. Empty:
   *  the same as vertices. */
  std::vector<Eigen::Vector3f> rest;
  /** \brief Unit, outward; empty: flat triangles. */
  std::vector<Eigen::Vector3f> normals;
  /** \brief Of each vertex, m/s; empty: not known, or it stands still. */
  std::vector<Eigen::Vector3f> velocities;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/** \brief A procedural texture, a function of the rest position. */
struct Material {
  enum Pattern { Plain, Checker, Stripes, Wood, Noise, Marker };
  Pattern pattern{Plain};
  Rgb8 first{200, 200, 200};
  Rgb8 second{60, 60, 60};
  /** \brief Side of a square, also of a marker's; period of a stripe, metres. */
  float size{0.1f};
  /** \brief Share of the sensor's infrared light that comes back; (0, 1]. Dark hair and black cloth: 0.1. */
  float infrared{0.7f};
};

/** \brief Diffuse colour of a material, channels 0 … 255. */
Eigen::Vector3f albedo(const Material& material, const Eigen::Vector3f& rest);

/** \brief A surface of one material. */
struct Object {
  std::string name;
  TriangleMesh mesh;
  Material material;
  /** \brief What figures of quality are told apart by: "hand", "furniture". Empty: its name. */
  std::string part{};
  /** \brief Objects of the same number above 0 are one surface that goes on from part to part. */
  std::uint32_t surface{0};
};

/** \brief The parts of a person, from above. */
inline const std::vector<std::string>& personParts() {
  static const std::vector<std::string> parts{"head", "torso", "arm", "hand", "leg", "foot"};
  return parts;
}

}  // namespace fuse_flow::simulation
