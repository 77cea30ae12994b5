#pragma once

#include "viewer/fusing/point_attributes.h"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace fuse_flow::viewing {

/** \brief The point of a cloud that is drawn at a place, or else the one that is drawn nearest in front within a radius around
 *  it. Looks at every point: 2 million take some ten milliseconds. (vtkPointPicker's tolerance is a length in the world,
 *  which near the viewer is half the window.)
 *  \param projection world → clip coordinates, −1 … 1 in each axis  \param at the place, −1 … 1
 *  \param radius half axes of an ellipse, in the same units */
std::optional<std::size_t> pointDrawnAt(const Cloud& cloud, const Eigen::Matrix4f& projection,
                                        const Eigen::Vector2f& at, const Eigen::Vector2f& radius);

/** \brief All points that are drawn within a rectangle, hidden ones included.  \param low, high its corners, −1 … 1 */
std::vector<std::size_t> pointsDrawnIn(const Cloud& cloud, const Eigen::Matrix4f& projection,
                                       const Eigen::Vector2f& low, const Eigen::Vector2f& high);

}  // namespace fuse_flow::viewing
