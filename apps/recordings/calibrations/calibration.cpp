#include "recordings/calibrations/calibration.h"

#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"

#include <fuse_flow/recordings/error.h>

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace fuse_flow::io {

namespace {

/** \brief \param nearest whether a rotation up to tolerance off one becomes the nearest */
Eigen::Isometry3d poseWithin(const std::string& owner, const std::vector<double>& row_major, double tolerance,
                             bool nearest) {
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
  if (error > tolerance)
    throw fail("is not rigid: R'R differs from the identity by ", error, ", must be below ", tolerance);
  if (R.determinant() < 0) throw fail("is not rigid: the determinant of the rotation is -1, must be +1");
  Eigen::Isometry3d pose(T);
  if (nearest) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
    pose.linear() = svd.matrixU() * svd.matrixV().transpose();
  }
  return pose;
}

}  // namespace

Eigen::Isometry3d rigidPose(const std::string& owner, const std::vector<double>& row_major) {
  return poseWithin(owner, row_major, 1e-3, false);
}

Eigen::Isometry3d nearlyRigidPose(const std::string& owner, const std::vector<double>& row_major) {
  return poseWithin(owner, row_major, 1e-2, true);
}

Intrinsics intrinsicsOf(const std::string& owner, const std::vector<double>& m) {
  if (m.size() != 9)
    throw InputError(owner + ": has " + std::to_string(m.size()) + " numbers, must be 9: a 3x3 matrix, row by row");
  if (m[6] != 0 || m[7] != 0 || m[8] != 1) {
    std::ostringstream row;
    row << m[6] << ' ' << m[7] << ' ' << m[8];
    throw InputError(owner + ": the last row is " + row.str() + ", must be 0 0 1");
  }
  for (const double skew : {m[1], m[3]}) checkSkew(owner, skew, m[0]);
  Intrinsics K;
  K.fx = static_cast<float>(m[0]);
  K.fy = static_cast<float>(m[4]);
  K.cx = static_cast<float>(m[2]);
  K.cy = static_cast<float>(m[5]);
  return K;
}

int imageSide(const std::string& path, const char* key, double value) {
  if (value >= 0 && value <= 65535 && value == std::floor(value)) return static_cast<int>(value);
  std::ostringstream message;
  message << path << ": " << key << " is " << value << ", must be a whole number of pixels, 65535 at most";
  throw InputError(message.str());
}

Distortion distortionOf(const std::string& path, const std::vector<double>& k) {
  const auto zero = [](double x) { return x == 0; };  // OpenCV's thin prisms and tilted sensors come behind
  const bool fits = k.empty() || k.size() == 4 || k.size() == 5 || k.size() == 8 ||
                    (k.size() > 8 && std::all_of(k.begin() + 8, k.end(), zero));
  if (!fits)
    throw InputError(path + ": has " + std::to_string(k.size()) +
                     " distortion coefficients, must be 4, 5 or 8: k1 k2 p1 p2 k3 k4 k5 k6");
  float d[8] = {};
  for (std::size_t i = 0; i < std::min<std::size_t>(8, k.size()); ++i) d[i] = static_cast<float>(k[i]);
  return {d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
}

std::vector<double> readNumbers(const std::string& path) {
  std::vector<double> numbers;
  std::istringstream lines(readText(path, kMostCalibrationBytes));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) {
      char* end = nullptr;
      numbers.push_back(std::strtod(word.c_str(), &end));
      if (*end != '\0') throw InputError(path + ": '" + cutShort(word) + "' is not a number");
    }
  }
  return numbers;
}

Eigen::Isometry3d readPose(const std::string& path) { return rigidPose(path, readNumbers(path)); }

void checkSkew(const std::string& owner, double skew, double fx) {
  constexpr double a_pixel = 1e-3;  // at the side of the image, where it matters most
  if (std::fabs(skew) <= a_pixel * std::fabs(fx)) return;
  std::ostringstream message;
  message << owner << ": the skew of the intrinsics, beside fx or fy, is " << skew << ", must be 0";
  throw InputError(message.str());
}

void checkCameraInput(const std::string& owner, const Camera& camera) {
  try {
    checkCamera(camera);
  } catch (const pcl::PCLException& error) {
    const std::string message = error.what();
    throw InputError(owner + ": " + message.substr(message.find_first_not_of(": ")));  // PCL puts a colon in front
  }
  const auto fail = [&](const auto&... parts) {
    std::ostringstream message;
    message << owner << ": camera '" << camera.name << "'";
    (message << ... << parts);
    return InputError(message.str());
  };
  const auto check_lens = [&](const Intrinsics& K, const char* which) {
    constexpr float min_focal = 1e-3f, max_focal = 1e3f;  // of the image: views of 179.9 and of 0.06 degrees
    constexpr float max_aside = 10;                       // images
    constexpr float max_distortion = 1e5f;                // narrow lenses have thousands
    const auto width = static_cast<float>(K.width), height = static_cast<float>(K.height);
    if (K.fx < min_focal * width || K.fy < min_focal * height || K.fx > max_focal * width || K.fy > max_focal * height)
      throw fail(which, ": fx and fy are ", K.fx, " and ", K.fy, " pixels for an image of ", K.width, "x", K.height,
                 ", must be a thousandth of its sides to a thousand times them");
    if (std::fabs(K.cx) > max_aside * width || std::fabs(K.cy) > max_aside * height)
      throw fail(which, ": cx and cy are ", K.cx, " and ", K.cy, " pixels for an image of ", K.width, "x", K.height,
                 ", must be within ten times its sides");
    const Distortion& d = K.distortion;
    for (const float k : {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6})
      if (std::fabs(k) > max_distortion)
        throw fail(which, ": distortion has ", k, ", must be within ", max_distortion,
                   ", of the order k1 k2 p1 p2 k3 k4 k5 k6");
  };
  check_lens(camera.intrinsics, "");
  if (camera.color) check_lens(camera.color->intrinsics, " color");
  const double distance = camera.T_world_camera.translation().norm();
  constexpr double max_distance = 5e4;  // metres; there single precision has steps of 4 mm
  if (distance > max_distance)
    throw fail(": T_world_camera is ", distance, " m from the origin, must be ", max_distance, " m or less");
  constexpr double max_baseline = 100;  // metres
  if (camera.color && camera.color->T_depth_color.translation().norm() > max_baseline)
    throw fail(" color: T_depth_color is ", camera.color->T_depth_color.translation().norm(), " m long, must be ",
               max_baseline, " m or less");
}

}  // namespace fuse_flow::io
