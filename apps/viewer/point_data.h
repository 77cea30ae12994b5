#pragma once

#include "viewer/point_attributes.h"

#include <fuse_flow/depth_view.h>

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <vector>

namespace fuse_flow::viewing {

/** \brief Every stride-th point of a cloud, from the first on, as VTK draws it.
 *  \param colors as many as points  \param stride ≥ 1  \param first < stride */
vtkSmartPointer<vtkPolyData> toPolyData(const Cloud& cloud, const std::vector<Rgb8>& colors, std::size_t stride = 1,
                                        std::size_t first = 0);

/** \brief A cloud in slices that are drawn one by one: each has every n-th point, so that the first few look like a thinner
 *  cloud, and a picture can be abandoned between two of them. \param points wanted in a slice, at most; there are no more than
 *  kMaxSlices, or one more */
std::vector<vtkSmartPointer<vtkPolyData>> slicesOf(const Cloud& cloud, const std::vector<Rgb8>& colors,
                                                   std::size_t points = 32768);
constexpr std::size_t kMaxSlices = 128;

}  // namespace fuse_flow::viewing
