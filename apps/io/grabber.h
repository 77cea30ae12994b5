#pragma once

#include "io/organized_cloud.h"

#include <pcl/io/grabber.h>

#include <cstdint>
#include <functional>

namespace fuse_flow::io {

/** \brief What takes a grabber's clouds, in the grabber's thread. \param stamp when the cloud was measured, microseconds */
using CloudReceiver = std::function<void(std::uint64_t stamp, const OrganizedCloud::ConstPtr& cloud)>;

/** \brief Registers for the clouds of any grabber, of the point type with the most colour that it offers. A cloud's stamp is
 *  that of its header; of a file without one, the number that names the file; else the time of its arrival. Throws
 *  InputError if it delivers no clouds. */
void connectGrabber(pcl::Grabber& grabber, const CloudReceiver& receive);

}  // namespace fuse_flow::io
