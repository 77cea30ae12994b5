#pragma once

#include "viewer/panes.h"

#include <vtkSmartPointer.h>

#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief A point of a shown cloud. */
struct PickedPoint {
  std::size_t pane{0};
  std::size_t index{0};
  Eigen::Vector3f position{Eigen::Vector3f::Zero()};  ///< world frame, metres
};

/** \brief Finds the point under the cursor, and measures between two of them. */
class Probe {
 public:
  explicit Probe(Panes& panes);

  /** \brief The point that is drawn at a place of the window, pixels from the lower left, or a few pixels from it. */
  std::optional<PickedPoint> pick(int x, int y);
  /** \brief "x 0.123, y …, z … m, omega 0.83, 3 views". */
  std::string describe(const PickedPoint& point) const;

  /** \brief The first point, then the second; a third one begins again. */
  void mark(const PickedPoint& point);
  void clear();
  /** \brief Between the two marked points, metres. */
  std::optional<double> distance() const;

 private:
  void draw();

  Panes& panes_;
  std::vector<Eigen::Vector3f> marks_;
  vtkSmartPointer<vtkPolyData> drawn_;
  vtkSmartPointer<vtkActor> actor_;
};

}  // namespace fuse_flow::viewing
