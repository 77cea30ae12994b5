#pragma once

#include <fuse_flow/math/representatives.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Receives the fused points of a frame, those of one coarse cell at a time. */
class FusedPointSink {
 public:
  virtual ~FusedPointSink() = default;
  /** \brief Before the first point of a frame. */
  virtual void start(int threads) = 0;
  /** \brief Points that a thread has fused, after those that it has added before. \param cameras PointCameras::mask() of each */
  virtual void add(int thread, const std::vector<FusedPoint>& points, const std::vector<std::uint64_t>& cameras) = 0;
  /** \brief Room for so many points on every thread, so that a warm frame allocates nothing. */
  virtual void reserve(std::size_t points) = 0;
};

/** \brief The fused points as they are. */
class FusedPointLists : public FusedPointSink {
 public:
  /** \brief Of one thread. */
  struct List {
    std::vector<FusedPoint> points;
    std::vector<std::uint64_t> cameras;  ///< PointCameras::mask() of each
  };

  void start(int threads) override { lists_.assign(static_cast<std::size_t>(threads), {}); }
  void add(int thread, const std::vector<FusedPoint>& points, const std::vector<std::uint64_t>& cameras) override {
    List& list = lists_[static_cast<std::size_t>(thread)];
    list.points.insert(list.points.end(), points.begin(), points.end());
    list.cameras.insert(list.cameras.end(), cameras.begin(), cameras.end());
  }
  void reserve(std::size_t) override {}

  /** \brief Those that a thread fused. */
  const List& operator[](int thread) const { return lists_[static_cast<std::size_t>(thread)]; }

 private:
  std::vector<List> lists_;
};

}  // namespace host
}  // namespace fuse_flow
