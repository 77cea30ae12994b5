#pragma once

namespace fuse_flow {

/** \brief What a time-of-flight camera does to light that comes to a surface by way of another one (multipath).
 *
 *  A lamp's light that bounces off a wall onto a floor arrives late, and lengthens what the floor measures: by centimetres beside a
 *  corner, always in the same way, so that no average takes it away. What a view measures tells where that light comes from: every
 *  pixel is a matt surface that the lamp lights, and sends on its share (Fuchs, Multipath interference compensation in
 *  time-of-flight camera images, ICPR 2010). Everything that reads depth subtracts it where a camera has a modulation frequency.
 *
 *  It knows one bounce, matt surfaces that reflect alike, and what the view itself measured: light of mirrors, of what is out of
 *  range, and of second bounces stays. doc/notes/multipath.md says what it is worth. */
struct Multipath {
  /** \brief Of the lamp, Hz: the highest, where a sensor uses several, which decides what it measures; 0, or 1e6 … 1e9. Azure Kinect:
   *  200e6. 0: the sensor sends no modulated light, or corrects for multipath itself. */
  float modulation_frequency{0};
  /** \brief Share of the lamp's infrared light that surfaces throw back, on average; (0, 1]. */
  float reflectance{0.6f};
};

/** \brief Whether two cameras do the same. */
inline bool operator==(const Multipath& a, const Multipath& b) {
  return a.modulation_frequency == b.modulation_frequency && a.reflectance == b.reflectance;
}
/** \brief Whether they do not. */
inline bool operator!=(const Multipath& a, const Multipath& b) { return !(a == b); }

}  // namespace fuse_flow
