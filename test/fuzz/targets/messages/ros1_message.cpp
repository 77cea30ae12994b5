#include "ros_message.h"

/** \brief A message in a bag of ROS 1: images, their calibration, transforms. */
FUSE_FLOW_FUZZ_TARGET(ros1_message, 1 << 19, 64, 2000) {
  fuse_flow_fuzz::readMessage(fuse_flow::io::Wire::Ros1, input);
}
