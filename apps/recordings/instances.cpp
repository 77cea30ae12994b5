// What takes long to compile, and is compiled with optimisation where the rest, under sanitizers, is not.
#include <fuse_flow/filters/depth_backprojection.h>

#include <pcl/point_types.h>

template class fuse_flow::DepthBackprojection<pcl::PointXYZRGB>;
