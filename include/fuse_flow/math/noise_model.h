#pragma once

#include <fuse_flow/math/host_device.h>

namespace fuse_flow {

/** \brief How the noise of a sensor's depth grows with depth: the standard deviation along the optical axis at depth z is
 *  σ(z) = floor + linear · z + quadratic · z². The default is the first Kinect's (Khoshelham and Elberink 2012: 1.425e-3 z²), and half a
 *  millimetre everywhere.
 *
 *  To measure the noise of your sensor, record a flat wall from several distances, and fit the three numbers to the deviations of the depth
 *  from planes. */
struct NoiseModel {
  float floor{0.0005f};        ///< metres; [0, 10]
  float linear{0.0f};          ///< no unit; [0, 10]
  float quadratic{0.001425f};  ///< 1/metres; [0, 10]; not all three may be 0

  /** \brief The noise model of a sensor that triangulates, from the uncertainty of a match: σ(z) = floor + z² σ_d / (f b). \param
   *  focal_length f, pixels; > 0
   *  \param baseline b between the two cameras, or camera and projector, metres; > 0  \param disparity_deviation σ_d, pixels; > 0
   *  \param floor metres; ≥ 0 */
  static NoiseModel stereo(float focal_length, float baseline, float disparity_deviation, float floor = 0.0005f) {
    return {floor, 0.0f, disparity_deviation / (focal_length * baseline)};
  }
};

/** \brief Whether two models are the same. */
FUSE_FLOW_HD bool operator==(const NoiseModel& a, const NoiseModel& b) {
  return a.floor == b.floor && a.linear == b.linear && a.quadratic == b.quadratic;
}
/** \brief Whether two models differ. */
FUSE_FLOW_HD bool operator!=(const NoiseModel& a, const NoiseModel& b) { return !(a == b); }

/** \brief σ(z), metres. \param z depth, metres */
FUSE_FLOW_HD float axialNoise(const NoiseModel& model, float z) {
  return model.floor + model.linear * z + model.quadratic * z * z;
}

/** \brief The standard deviation of inverse depth q = 1/z, 1/metres: σ(z) / z². */
FUSE_FLOW_HD float inverseDepthNoise(const NoiseModel& model, float q) {
  return model.floor * q * q + model.linear * q + model.quadratic;
}

/** \brief The noise of one view. */
struct ViewNoise {
  NoiseModel model;   ///< of its camera
  float scale{1.0f};  ///< how much noisier the view is than that, see noiseScale(); 0: its noise is not known
  float model_ratio{
      1.0f};  ///< the camera's model over that of the parameters, at ConfidenceParameters::noise_reference

  /** \brief Standard deviation of a measured depth, metres. */
  FUSE_FLOW_HD float at(float z) const { return scale * axialNoise(model, z); }
  /** \brief How much noisier the view is than the parameters' sensor. */
  FUSE_FLOW_HD float level() const { return scale * model_ratio; }
};

}  // namespace fuse_flow
