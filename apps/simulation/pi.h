#pragma once

namespace fuse_flow::simulation {

constexpr double kPi = 3.14159265358979323846;
/** \brief Where lengths and angles are float. */
constexpr float kPiF = 3.14159265f;

}  // namespace fuse_flow::simulation
