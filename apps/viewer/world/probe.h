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

/** \brief The points of a shown cloud within a rectangle of the window. */
struct SelectedPoints {
  std::size_t pane{0};
  std::size_t count{0};
  Eigen::AlignedBox3f box;    ///< around them, world frame, metres
  double mean_confidence{0};  ///< ω
  double mean_view_count{0};
};

/** \brief Finds the point under the cursor, and measures between two of them. */
class Probe {
 public:
  explicit Probe(Panes& panes);

  /** \brief The point that is drawn at a place of the window, pixels from the lower left, or a few pixels from it. */
  std::optional<PickedPoint> pick(int x, int y);
  /** \brief "x 0.123, y …, z … m, omega 0.83, 3 views". */
  std::string describe(const PickedPoint& point) const;

  /** \brief The points that are drawn between two corners of a rectangle, pixels from the lower left, in the pane that the
   *  first corner lies in. */
  SelectedPoints select(const std::array<int, 2>& from, const std::array<int, 2>& to);
  /** \brief "1234 points of FUSE-Flow, 0.412 x 0.303 x 0.120 m, omega 0.83, 2.1 views". */
  std::string describe(const SelectedPoints& points) const;

  /** \brief The first point, then the second; a third one begins again. */
  void mark(const PickedPoint& point);
  void clear();
  std::size_t marks() const { return marks_.size(); }
  /** \brief Between the two marked points, metres. */
  std::optional<double> distance() const;

 private:
  void draw();
  /** \brief World → clip coordinates of a pane. */
  Eigen::Matrix4f projectionOf(std::size_t pane);
  /** \brief The middle of a pixel of the window in a pane, −1 … 1. */
  Eigen::Vector2f clipPlace(std::size_t pane, double x, double y);

  Panes& panes_;
  std::vector<Eigen::Vector3f> marks_;
  vtkSmartPointer<vtkPolyData> drawn_;
  vtkSmartPointer<vtkActor> actor_;
};

}  // namespace fuse_flow::viewing
