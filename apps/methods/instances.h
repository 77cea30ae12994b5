#pragma once

/** \file
 *  \brief What several programs would each compile for themselves: it is in method.cpp. Not for nvcc, which refuses
 *  the measure of quality. */

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>
#include <fuse_flow/quality/reprojection_quality.h>
#include <fuse_flow/quality/surface_quality.h>

#include <pcl/point_types.h>

namespace fuse_flow {

extern template class FuseFlow<PointFused>;
extern template ReprojectionQuality reprojectionQuality(const pcl::PointCloud<PointFused>&, const RigFrame&,
                                                        const ReprojectionQualityParameters&, unsigned int);
extern template ReprojectionQuality reprojectionQuality(const pcl::PointCloud<pcl::PointXYZ>&, const RigFrame&,
                                                        const ReprojectionQualityParameters&, unsigned int);
extern template SurfaceQuality surfaceQuality(const pcl::PointCloud<PointFused>&, const RigFrame&,
                                              const SurfaceQualityParameters&, unsigned int);
extern template SurfaceQuality surfaceQuality(const pcl::PointCloud<pcl::PointXYZ>&, const RigFrame&,
                                              const SurfaceQualityParameters&, unsigned int);
extern template TemporalFlicker temporalFlicker(const pcl::PointCloud<PointFused>&, const RigFrame&,
                                                const pcl::PointCloud<PointFused>&, const RigFrame&,
                                                const SurfaceQualityParameters&, unsigned int);
extern template TemporalFlicker temporalFlicker(const pcl::PointCloud<pcl::PointXYZ>&, const RigFrame&,
                                                const pcl::PointCloud<pcl::PointXYZ>&, const RigFrame&,
                                                const SurfaceQualityParameters&, unsigned int);

}  // namespace fuse_flow
