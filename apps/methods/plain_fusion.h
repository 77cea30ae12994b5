#pragma once

#include "methods/point_fused_normal.h"

#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/point_types.h>

#include <pcl/point_cloud.h>

#include <cstdint>
#include <vector>

namespace fuse_flow::io {

/** \brief Section 5 alone, AdaptiveHashFusion, for clouds without views: each point weighs its confidence, and nothing is asked whether it is
 *  there. \throws pcl::PCLException for a point too far from the origin
 *  \param scanners of each point, see AdaptiveHashFusion::setCameraIndices() */
void fusePlainCloud(const pcl::PointCloud<PointFusedNormal>& points, const std::vector<std::uint32_t>& scanners,
                    const AggregationParameters& parameters, unsigned int threads,
                    pcl::PointCloud<PointFusedNormal>& output);

/** \brief The same points without their normals. */
void withoutNormals(const pcl::PointCloud<PointFusedNormal>& points, pcl::PointCloud<PointFused>& output);

}  // namespace fuse_flow::io
