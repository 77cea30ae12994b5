#pragma once

#include "viewer/fusing/point_attributes.h"

#include <fuse_flow/depth_view.h>

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <vector>

namespace fuse_flow::viewing {

/** \brief Points of a cloud as VTK draws them. \param colors as many as points of the cloud  \param numbers which, in this order */
vtkSmartPointer<vtkPolyData> toPolyData(const Cloud& cloud, const std::vector<Rgb8>& colors,
                                        const std::vector<std::size_t>& numbers);

constexpr std::size_t kMaxSlices = 128;

/** \brief A cloud in slices that are drawn one by one, so that a picture can be abandoned between two of them. The first
 *  thinSlices() hold every n-th point each and look like a thinner cloud; the others hold what is left in its own order, which is
 *  drawn twice as fast. \param points wanted in a slice, at most; there are no more than kMaxSlices, or one more */
std::vector<vtkSmartPointer<vtkPolyData>> slicesOf(const Cloud& cloud, const std::vector<Rgb8>& colors,
                                                   std::size_t points = 32768);
/** \brief How many slices of a cloud can represent it: an eighth. */
constexpr std::size_t thinSlices(std::size_t slices) { return (slices + 7) / 8; }

}  // namespace fuse_flow::viewing
