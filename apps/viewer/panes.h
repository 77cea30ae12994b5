#pragma once

#include "viewer/fusing/fusion_job.h"
#include "viewer/window.h"

#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkSmartPointer.h>

#include <array>
#include <functional>
#include <optional>
#include <vector>

namespace fuse_flow::viewing {

/** \brief How the two clouds share the window. */
enum class Layout { SideBySide, Split };

/** \brief How lines and faces are drawn; clouds are always points. */
enum class Form { Points, Lines, Solid };

/** \brief Of a mapper's coincident topology, VTK's units of depth: more than there are between the near and the far plane. What is
 *  drawn with it lies over everything. */
constexpr double kInFront = -70000;

/** \brief The two views of the world: one camera, each with a cloud of its own. Side by side both show the whole; in a split
 *  they are two parts of one picture, and a line between them can be dragged. */
class Panes {
 public:
  /** \param on_slice called while a picture is drawn, before each slice of a cloud */
  Panes(Window& window, std::function<void()> on_slice);
  ~Panes();
  Panes(const Panes&) = delete;
  Panes& operator=(const Panes&) = delete;

  void setCloud(std::size_t pane, std::shared_ptr<const FusedCloud> cloud);
  const std::shared_ptr<const FusedCloud>& cloud(std::size_t pane) const { return clouds_[pane]; }
  /** \brief Off: the first pane has the window to itself. */
  void setComparing(bool comparing);
  bool comparing() const { return comparing_; }
  void setLayout(Layout layout);
  Layout layout() const { return layout_; }
  /** \brief Where the line is, as a share of the window's width; kept within 0.02 … 0.98. */
  void setSplit(double share);
  double split() const { return split_; }
  /** \brief Whether a column of the window is so near to the line that dragging it is meant. */
  bool nearSplit(int x) const;

  /** \brief A part of the points while the view moves, all of them when it stands. */
  void setCoarse(bool coarse);
  bool coarse() const { return coarse_; }
  /** \brief About how many points of both clouds together are drawn of coarse ones; at least a slice each. */
  void setCoarsePoints(std::size_t points);
  /** \brief Of the clouds that are shown. */
  std::size_t allPoints() const;
  std::size_t drawnPoints() const;
  /** \brief Around a cloud, low and high of x, y, z; absent: it has no points. */
  std::optional<std::array<double, 6>> bounds(std::size_t pane) const;
  /** \brief A box within the first pane's cloud, which must have points: around all but the outermost of them, and as much smaller as
   *  it takes to see the middles of its faces. */
  Eigen::AlignedBox3f boxInView();
  void setPointSize(double pixels);
  /** \brief Of what is in the panes now. */
  void setForm(Form form);
  void setBackground(double r, double g, double b);

  vtkCamera* camera() { return renderers_[0]->GetActiveCamera(); }
  vtkRenderer* renderer(std::size_t pane) { return renderers_[pane]; }
  /** \brief The pane under a column of the window. */
  std::size_t paneAt(int x) const;
  /** \brief Where a pane begins and ends, as shares of the window's width. */
  std::array<double, 2> extent(std::size_t pane) const;
  /** \brief Makes the camera project as it does when this pane is drawn: for picking. */
  void aimCamera(std::size_t pane);
  /** \brief Near and far plane around what both panes show: the camera is one, and VTK looks at one renderer. */
  void fitClippingRange();

 private:
  /** \brief A renderer is about to draw. */
  void aimAt(vtkObject* renderer, unsigned long event, void* data);
  /** \brief VTK has looked for new data of a slice, and draws it next. */
  void onSlice(vtkObject* mapper, unsigned long event, void* data);
  void arrange();
  void updateSlices();
  void addSlice(std::size_t pane);
  bool draws(std::size_t pane) const { return clouds_[pane] && (pane == 0 || comparing_); }

  Window& window_;
  std::array<vtkSmartPointer<vtkRenderer>, kPanes> renderers_;
  /** \brief A slice of a pane's cloud; the mapper keeps what it has sent to the GPU. */
  struct Slice {
    vtkSmartPointer<vtkActor> actor;
    vtkSmartPointer<vtkPolyDataMapper> mapper;
  };
  std::array<std::vector<Slice>, kPanes> slices_;
  std::array<vtkSmartPointer<vtkProperty>, kPanes> properties_;  ///< of a pane's slices
  std::function<void()> on_slice_;
  std::array<unsigned long, kPanes> observers_{};
  std::array<std::shared_ptr<const FusedCloud>, kPanes> clouds_;
  vtkSmartPointer<vtkActor2D> line_;
  bool comparing_{false};
  bool coarse_{false};
  std::size_t coarse_points_{100000};
  Layout layout_{Layout::SideBySide};
  double split_{0.5};
};

}  // namespace fuse_flow::viewing
