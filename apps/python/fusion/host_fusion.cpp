#include "fusion_of.h"

namespace fuse_flow::python {

std::unique_ptr<Fusion> makeHostFusion(const PointExtras& extras) { return makeFusion<device::Host>(extras); }

}  // namespace fuse_flow::python
