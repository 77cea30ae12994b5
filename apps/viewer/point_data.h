#pragma once

#include "viewer/point_attributes.h"

#include <fuse_flow/depth_view.h>

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <vector>

namespace fuse_flow::viewing {

/** \brief Every stride-th point of a cloud as VTK draws it. \param colors as many as points  \param stride ≥ 1 */
vtkSmartPointer<vtkPolyData> toPolyData(const Cloud& cloud, const std::vector<Rgb8>& colors, std::size_t stride = 1);

}  // namespace fuse_flow::viewing
