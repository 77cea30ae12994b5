#include "io/calibration.h"

#include "io/error.h"
#include "io/file_io.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace fuse_flow::io {

Eigen::Isometry3d rigidPose(const std::string& owner, const std::vector<double>& row_major) {
  const auto fail = [&](const auto&... parts) {
    std::ostringstream message;
    message << owner << ": ";
    (message << ... << parts);
    return InputError(message.str());
  };
  if (row_major.size() != 16) throw fail("has ", row_major.size(), " numbers, must be 16: a 4x4 pose, row by row");
  if (!std::all_of(row_major.begin(), row_major.end(), [](double x) { return std::isfinite(x); }))
    throw fail("holds a number that is not finite");
  const Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(row_major.data());
  if ((T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-6)
    throw fail("the last row is ", T.row(3), ", must be 0 0 0 1");
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > 1e-3) throw fail("is not rigid: R'R differs from the identity by ", error, ", must be below 0.001");
  if (R.determinant() < 0) throw fail("is not rigid: the determinant of the rotation is -1, must be +1");
  return Eigen::Isometry3d(T);
}

std::vector<double> readNumbers(const std::string& path) {
  std::vector<double> numbers;
  std::istringstream lines(readFile(path));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) {
      char* end = nullptr;
      numbers.push_back(std::strtod(word.c_str(), &end));
      if (*end != '\0') throw InputError(path + ": '" + word + "' is not a number");
    }
  }
  return numbers;
}

Eigen::Isometry3d readPose(const std::string& path) { return rigidPose(path, readNumbers(path)); }

void checkCameraInput(const std::string& owner, const Camera& camera) {
  try {
    checkCamera(camera);
  } catch (const pcl::PCLException& error) {
    const std::string message = error.what();
    throw InputError(owner + ": " + message.substr(message.find_first_not_of(": ")));  // PCL puts a colon in front
  }
  const auto fail = [&](const auto&... parts) {
    std::ostringstream message;
    message << owner << ": camera '" << camera.name << "': ";
    (message << ... << parts);
    return InputError(message.str());
  };
  const Intrinsics& K = camera.intrinsics;
  const Eigen::Vector3d place = camera.T_world_camera.translation();
  constexpr double max_distance = 5e4;  // metres; there single precision has steps of 4 mm
  if (place.norm() > max_distance)
    throw fail("T_world_camera is ", place.norm(), " m from the origin, must be ", max_distance, " m or less");
  constexpr float min_focal = 1e-3f;  // of the image: a view of 179.9 degrees
  if (K.fx < min_focal * static_cast<float>(K.width) || K.fy < min_focal * static_cast<float>(K.height))
    throw fail("fx and fy are ", K.fx, " and ", K.fy, " pixels for an image of ", K.width, "x", K.height,
               ", must be a thousandth of its sides or more");
}

}  // namespace fuse_flow::io
