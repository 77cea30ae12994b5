#pragma once

#include <initializer_list>
#include <vector>

namespace fuse_flow::simulation {

/** \brief A number that changes smoothly through keys and repeats after the last of them: quintic Hermite splines, continuous with
 *  their first two derivatives. */
class Track {
 public:
  struct Key {
    double time;  // seconds
    double value;
    double velocity{0};      // per second
    double acceleration{0};  // per second²
  };

  /** \param keys by time, the first at 0; the last says the same as the first */
  Track(std::initializer_list<Key> keys) : keys_(keys) {}

  double at(double time) const;

 private:
  std::vector<Key> keys_;
};

}  // namespace fuse_flow::simulation
