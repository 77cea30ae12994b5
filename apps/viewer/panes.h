#pragma once

#include "viewer/fusion_job.h"
#include "viewer/window.h"

#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkPolyDataMapper.h>
#include <vtkSmartPointer.h>

#include <array>
#include <optional>

namespace fuse_flow::viewing {

/** \brief How the two clouds share the window. */
enum class Layout { SideBySide, Split };

/** \brief The two views of the world: one camera, each with a cloud of its own. Side by side both show the whole; in a split
 *  they are two parts of one picture, and a line between them can be dragged. */
class Panes {
 public:
  explicit Panes(Window& window);
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

  /** \brief Coarse clouds while the view moves, all points when it stands. */
  void setCoarse(bool coarse);
  void setPointSize(double pixels);
  void setBackground(double r, double g, double b);

  vtkCamera* camera() { return renderers_[0]->GetActiveCamera(); }
  vtkRenderer* renderer(std::size_t pane) { return renderers_[pane]; }
  vtkActor* actor(std::size_t pane) { return actors_[pane]; }
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
  void arrange();
  void updateMappers();

  Window& window_;
  std::array<vtkSmartPointer<vtkRenderer>, kPanes> renderers_;
  std::array<vtkSmartPointer<vtkActor>, kPanes> actors_;
  /** \brief Each keeps what it has sent to the GPU. */
  std::array<vtkSmartPointer<vtkPolyDataMapper>, kPanes> fine_, coarse_;
  std::array<unsigned long, kPanes> observers_{};
  std::array<std::shared_ptr<const FusedCloud>, kPanes> clouds_;
  vtkSmartPointer<vtkActor2D> line_;
  bool comparing_{false};
  bool show_coarse_{false};
  Layout layout_{Layout::SideBySide};
  double split_{0.5};
};

}  // namespace fuse_flow::viewing
