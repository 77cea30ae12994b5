#pragma once

#include <fuse_flow/camera.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A camera as COLMAP describes it. Throws InputError for a model that Distortion does not express, a wrong number of parameters, or
 *  sides that are none. \param path of messages  \param model "PINHOLE" …  \param width pixels  \param height rows */
Intrinsics colmapIntrinsics(const std::string& path, const std::string& model, double width, double height,
                            const std::vector<double>& parameters);

/** \brief A camera model of COLMAP's binary files. */
struct ColmapModel {
  std::string name;
  std::size_t parameters;  ///< how many it has
};

/** \brief The model of a number. Throws InputError for a number that has none. \param path of messages */
ColmapModel colmapModel(const std::string& path, int number);

}  // namespace fuse_flow::io
