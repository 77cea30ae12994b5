#pragma once

#include "cloud.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <pybind11/numpy.h>

namespace fuse_flow::python {

/** \brief (N, 3) floats in rows without gaps. \param what their name in messages
 *  \throws pybind11::value_error for another shape, or numbers that are no floats */
pybind11::array_t<float> tripletsOf(const pybind11::object& object, const char* what);

/** \brief Points as PCL has them, copied. \param points a Cloud, or an array of shape (N, 3), metres */
pcl::PointCloud<pcl::PointXYZ> cloudOf(const pybind11::object& points);

/** \brief One number for each of some points: (N,). \throws pybind11::value_error for another length or type */
template <typename T>
pybind11::array_t<T> numbersOf(const pybind11::object& object, const char* what, std::size_t points);

}  // namespace fuse_flow::python
