#pragma once

#include "viewer/fusing/coloring.h"
#include "viewer/fusing/thumbnail.h"
#include "viewer/panes.h"

#include <vtkActor2D.h>
#include <vtkImageMapper.h>
#include <vtkScalarBarActor.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include <array>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief What lies over the world: texts, the cameras' images, and the legend of the colours. Titles, images and legend are seen
 *  from the next arrange() on. */
class Overlay {
 public:
  explicit Overlay(Window& window);

  /** \brief Top left; its lines are broken where the window ends. */
  void setStatus(const std::string& text);
  /** \brief Below the middle: an error, or what was just done. */
  void setMessage(const std::string& text) { message_->SetInput(text.c_str()); }
  /** \brief Above the strip: the point under the cursor. */
  void setReadout(const std::string& text) { readout_->SetInput(text.c_str()); }
  std::string readout() const { return readout_->GetInput(); }
  /** \brief Unbroken. */
  const std::string& status() const { return status_text_; }
  vtkTextActor* statusActor() { return status_; }
  /** \brief Heads a pane; empty: nothing does. */
  void setTitle(std::size_t pane, const std::string& text) { titles_[pane]->SetInput(text.c_str()); }
  vtkTextActor* title(std::size_t pane) { return titles_[pane]; }
  /** \brief Over everything; empty: none. */
  void setHelp(const std::string& text);
  vtkTextActor* help() { return help_; }
  void setLegend(const Legend& legend);
  void setImages(const std::vector<io::ColorImage>& thumbnails, const std::vector<std::string>& names);
  vtkTextActor* imageName(std::size_t camera) { return image_names_[camera]; }

  void showMessage(bool visible) { message_->SetVisibility(visible); }
  void showStatus(bool visible) { status_->SetVisibility(visible); }
  void showLegend(bool visible) { legend_visible_ = visible; }
  void showImages(bool visible);

  /** \brief Where the images end, pixels from the window's lower border. */
  int aboveImages() const;
  /** \brief Where what lies below the middle ends: timeline, titles, what was said. */
  int aboveTitles() const;
  /** \brief Puts everything where it belongs in the window as it now is. \param taken at the right, beside the status; pixels */
  void arrange(const Panes& panes, double taken);

 private:
  vtkSmartPointer<vtkTextActor> addText();
  void arrangeStatus();
  void arrangeImages();
  void arrangeImageName(std::size_t camera, double width);
  void arrangeHelp();

  Window& window_;
  vtkSmartPointer<vtkTextActor> status_, message_, readout_, help_;
  std::array<vtkSmartPointer<vtkTextActor>, kPanes> titles_;
  vtkSmartPointer<vtkScalarBarActor> legend_;
  vtkSmartPointer<vtkActor2D> images_;
  vtkSmartPointer<vtkImageMapper> image_mapper_;
  std::vector<vtkSmartPointer<vtkTextActor>> image_names_;
  std::vector<io::ColorImage> thumbnails_;
  std::vector<std::string> names_;
  std::string status_text_;
  double taken_{0};  ///< of the window's width
  bool images_visible_{true};
  bool legend_visible_{true};
  bool legend_empty_{true};
  int strip_height_{0};
};

}  // namespace fuse_flow::viewing
