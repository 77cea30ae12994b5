#pragma once

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <pcl/common/io.h>
#include <pcl/filters/filter_indices.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

// Compiled once, in instances.cpp: most tests have these.
extern template class fuse_flow::FuseFlow<fuse_flow::PointFused>;
extern template class fuse_flow::FuseFlow<pcl::PointXYZRGBNormal>;
