#pragma once

#include <fuse_flow/recordings/organized_cloud.h>
#include <fuse_flow/recordings/recording.h>

#include <pcl/io/grabber.h>

#include <cstdint>
#include <functional>
#include <memory>

namespace fuse_flow::io {

/** \brief What takes a grabber's clouds, in the grabber's thread. \param stamp when the cloud was measured, microseconds */
using CloudReceiver = std::function<void(std::uint64_t stamp, const OrganizedCloud::ConstPtr& cloud)>;

/** \brief Registers for the clouds of any grabber, of the point type with the most colour that it offers. A cloud's stamp is
 *  that of its header; of a file without one, the number that names the file; else the time of its arrival. Throws
 *  InputError if it delivers no clouds. */
void connectGrabber(pcl::Grabber& grabber, const CloudReceiver& receive);

/** \brief What takes a grabber's images, in the grabber's thread. \param stamp when the depth was measured, microseconds, by the
 *  device's clock  \param images depth16 in millimetres, and colour of the same size if there is any; the receiver may keep them */
using ImageReceiver = std::function<void(std::uint64_t stamp, const std::shared_ptr<const LoadedView>& images)>;

/** \brief Registers for the depth images of a grabber, with its colour images where it pairs them, as pcl::io::OpenNI2Grabber does:
 *  no cloud is made, and intrinsics, distortion and pose are those of the Camera. The driver must register colour to depth;
 *  colour that cannot be brought to the depth image's size is left out. Shadows and missing samples become 0. Without a
 *  stamp, the time of arrival. Throws InputError if it delivers no depth images. */
void connectDepthGrabber(pcl::Grabber& grabber, const ImageReceiver& receive);

}  // namespace fuse_flow::io
