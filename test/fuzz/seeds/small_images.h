#pragma once

namespace fuse_flow_fuzz {

/** \brief Pixels of the images of seeds. */
constexpr int kWidth = 8, kHeight = 6;

/** \brief Their depth. */
inline float metresAt(int u, int v) { return 1 + 0.125f * static_cast<float>(u) + 0.5f * static_cast<float>(v); }

}  // namespace fuse_flow_fuzz
