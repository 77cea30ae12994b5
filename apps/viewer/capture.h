#pragma once

#include "viewer/fusing/fusion_job.h"

#include <vtkCamera.h>
#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief Writes what the window shows: a JPEG if the extension is .jpg, else a PNG. Throws io::OutputError. */
void writeScreenshot(const std::string& path, vtkRenderWindow* window);

/** \brief Whether it ends as a picture that writeScreenshot() writes: ".png", ".jpg". */
bool isPictureFile(const std::string& path);

/** \brief What writeShownCloud() writes: "ply", "pcd", "vtk", "ifs", "obj". */
const std::vector<std::string>& cloudFormats();
/** \brief Whether the extension is one of them. */
bool isCloudFile(const std::string& path);
/** \brief Writes a cloud, in the format that the extension says. PLY and PCD hold all of it, VTK what PCL writes of it, IFS and OBJ
 *  the positions. The file appears complete or not at all. Throws io::OutputError. */
void writeShownCloud(const std::string& path, const Cloud& cloud);

/** \brief Pictures one after another: numbered PNGs in a folder, or a video. */
class PictureSequence {
 public:
  virtual ~PictureSequence() = default;
  /** \brief What the window shows now. Throws io::OutputError. */
  virtual void add(vtkRenderWindow* window) = 0;
};

constexpr int kVideoRate = 30;  ///< pictures a second

/** \brief What makePictureSequence() writes for so many pictures. */
std::vector<std::string> filesOfFilm(const std::string& path, int pictures);

/** \brief .ogv: a video in Ogg Theora; another name: a folder. Throws io::OutputError. */
std::unique_ptr<PictureSequence> makePictureSequence(const std::string& path);

/** \brief A camera path once around what the camera looks at, in a circle about its up axis. */
class Orbit {
 public:
  Orbit(const std::string& path, int pictures) : sequence_(makePictureSequence(path)), pictures_(pictures) {}
  bool done() const { return taken_ == pictures_; }
  /** \brief Takes a picture of the window, which shows what it should, and moves the camera on. */
  void step(vtkRenderWindow* window, vtkCamera* camera);
  /** \brief Where the camera was before the first picture. */
  void goBack(vtkCamera* camera) const { camera->Azimuth(-360.0 / pictures_ * taken_); }

 private:
  std::unique_ptr<PictureSequence> sequence_;
  int pictures_;
  int taken_{0};
};

}  // namespace fuse_flow::viewing
