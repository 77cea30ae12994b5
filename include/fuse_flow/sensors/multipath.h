#pragma once

namespace fuse_flow {

/** \brief Correction of multipath interference for a time-of-flight camera.
 *
 *  Light of the camera that a wall reflects onto a floor arrives late, and makes the measured depth of the floor too long: by centimetres
 *  beside a corner. The error is the same in every frame, so averaging does not remove it. The indirect light can be computed from the
 *  depth image: every pixel is a matt surface that the camera lights and that reflects a share of the light (Fuchs, Multipath interference
 *  compensation in time-of-flight camera images, ICPR 2010). If a camera has a modulation frequency, all code that reads its depth
 *  subtracts the error.
 *
 *  The model has one bounce, and matt surfaces of equal reflectance that the view itself measured. It does not correct light from mirrors,
 *  from surfaces out of range, or from second bounces. doc/notes/multipath.md has measurements. */
struct Multipath {
  /** \brief Modulation frequency of the light, Hz. If a sensor uses several, the highest one, which determines the measured depth. 0, or
   *  1e6 … 1e9; Azure Kinect: 200e6. 0: no correction, for sensors without modulated light and sensors that correct multipath interference
   *  themselves. */
  float modulation_frequency{0};
  /** \brief Mean share of the infrared light that surfaces reflect; (0, 1]. */
  float reflectance{0.6f};
};

/** \brief Whether two corrections are equal. */
inline bool operator==(const Multipath& a, const Multipath& b) {
  return a.modulation_frequency == b.modulation_frequency && a.reflectance == b.reflectance;
}
/** \brief Whether two corrections differ. */
inline bool operator!=(const Multipath& a, const Multipath& b) { return !(a == b); }

}  // namespace fuse_flow
