#pragma once

#include "simulation/scene.h"

#include <fuse_flow/camera.h>

#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief Poses of the cameras of a rig in a scene. Names are LAYOUT-N, with N from 1 to 64:
 *  - ring-N[-narrow]: on a circle around the subject, looking at its middle, in turn lower and higher; up to three
 *    cameras stand 60° apart, more share the circle evenly.
 *  - walls-N[-narrow]: along the four walls, 2.2 m up, looking at the middle of the subject.
 *  - arc-N[-level], N from 2: as cameras for multi-view stereo stand, on an arc around the subject, looking at its
 *    middle, in turn lower and higher; from one to the next are 6° of azimuth (less where N of them would not fit on a
 *    circle). Seen from the middle of the subject, neighbours and second neighbours are 10 to 12° apart. In a level rig
 *    all have the same height; neighbours are 6° apart, and all baselines are parallel to the floor.
 *  - row-N, N from 2 to 8: side by side, 12 cm from one to the next, from left to right, all with the orientation of one that looks at the
 *    middle of the subject: their images are rectified as they are.
 *  - surround-N, N from 2: on a circle of 15 cm radius around the scene's lookout(), as on a robot or a car, looking outward
 *    and level, 360° / N from one to the next. Neighbours overlap by what a sensor sees horizontally less that: "active_stereo"
 *    (90°) by 18° at five cameras, "time_of_flight" (65°) by 20° at eight and 5° at six, "structured_light" (58°) not at six.
 *
 *  Other cameras overlap widely: each sees most of the subject. In a narrow rig they stand closer and look at different parts
 *  of it, so that neighbours share a strip. Throws io::InputError on another name, and on surround-N in a scene without lookout(). */
std::vector<Eigen::Isometry3d> placeCameras(const std::string& rig, const Scene& scene);

/** \brief Whether placeCameras() knows it. */
bool isRigName(const std::string& rig);

/** \brief The names in words, for messages. */
std::string rigNames();

/** \brief A camera at a place looking at a point, its x axis level; optical frame → world. */
Eigen::Isometry3d lookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& at);

}  // namespace fuse_flow::simulation
