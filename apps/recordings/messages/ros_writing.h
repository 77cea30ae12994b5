#pragma once

#include "recordings/streams/frame_sets.h"

#include <Eigen/Geometry>

#include <string>

#ifdef FUSE_FLOW_WITH_FASTCDR
#include "recordings/messages/cdr_message.h"
#endif

namespace fuse_flow::io {

/** \brief Types, as ROS 2 defines them, without its comments. */
namespace ros_definitions {
inline const std::string separator =
    "================================================================================\nMSG: ";
inline const std::string of_time = separator + "builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
inline const std::string of_header =
    separator + "std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + of_time;
/** \brief tf2_msgs/msg/TFMessage. */
inline const std::string transforms =
    "geometry_msgs/TransformStamped[] transforms\n" + separator +
    "geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform "
    "transform\n" +
    of_header + separator +
    "geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n" + separator +
    "geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n" + separator +
    "geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
}  // namespace ros_definitions

#ifdef FUSE_FLOW_WITH_FASTCDR
/** \brief geometry_msgs/TransformStamped. */
inline void putTransform(CdrMessage& message, Nanoseconds time, const std::string& parent, const std::string& child,
                         const Eigen::Isometry3d& T) {
  message.header(time, parent) << child;
  const Eigen::Quaterniond q(T.rotation());
  for (const double value : {T.translation().x(), T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w()})
    message << value;
}
#endif

}  // namespace fuse_flow::io
