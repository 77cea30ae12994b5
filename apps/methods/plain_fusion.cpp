#include "methods/plain_fusion.h"

#include <fuse_flow/filters/adaptive_hash_fusion.h>

#include <pcl/common/io.h>

namespace fuse_flow::io {

void fusePlainCloud(const pcl::PointCloud<PointFusedNormal>& points, const std::vector<std::uint32_t>& scanners,
                    const AggregationParameters& parameters, unsigned int threads,
                    pcl::PointCloud<PointFusedNormal>& output) {
  AdaptiveHashFusion<PointFusedNormal> filter;
  filter.setParameters(parameters);
  filter.setNumberOfThreads(threads);
  filter.setCameraIndices(scanners);
  filter.setInputCloud(points.makeShared());
  filter.filter(output);
}

void withoutNormals(const pcl::PointCloud<PointFusedNormal>& points, pcl::PointCloud<PointFused>& output) {
  pcl::copyPointCloud(points, output);
}

}  // namespace fuse_flow::io
