#include "viewer/capture.h"

#include "drawing/image_of.h"
#include "io/cloud_io.h"
#include "io/error.h"
#include "io/image_io.h"

#include <pcl/io/vtk_io.h>

#include <vtkJPEGWriter.h>
#include <vtkNew.h>
#include <vtkOggTheoraWriter.h>
#include <vtkWindowToImageFilter.h>

#include <filesystem>

namespace fuse_flow::viewing {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 88;  // of 100

void makeFolder(const fs::path& folder) {
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw io::OutputError(folder.string() + ": cannot be created: " + error.message());
}

class NumberedPictures : public PictureSequence {
 public:
  explicit NumberedPictures(fs::path folder) : folder_(std::move(folder)) { makeFolder(folder_); }
  void add(vtkRenderWindow* window) override {
    char name[16];
    std::snprintf(name, sizeof(name), "%06d.png", number_++);
    writeScreenshot((folder_ / name).string(), window);
  }

 private:
  fs::path folder_;
  int number_{0};
};

class Video : public PictureSequence {
 public:
  explicit Video(std::string path) : path_(std::move(path)) {
    makeFolder(fs::path(path_).parent_path());
    writer_->SetFileName(path_.c_str());
    writer_->SetRate(kVideoRate);
    writer_->SetQuality(2);
    writer_->SubsamplingOff();
  }
  ~Video() override {
    if (started_) writer_->End();
  }
  void add(vtkRenderWindow* window) override {
    vtkNew<vtkWindowToImageFilter> grab;  // a new one each time: it would return the last picture again
    grab->SetInput(window);
    grab->ReadFrontBufferOff();
    grab->Update();
    writer_->SetInputConnection(grab->GetOutputPort());
    if (!started_) writer_->Start();
    started_ = true;
    writer_->Write();
    if (writer_->GetError()) throw io::OutputError(path_ + ": cannot be written");
  }

 private:
  std::string path_;
  vtkNew<vtkOggTheoraWriter> writer_;
  bool started_{false};
};

}  // namespace

void writeScreenshot(const std::string& path, vtkRenderWindow* window) {
  makeFolder(fs::path(path).parent_path());
  if (fs::path(path).extension() != ".jpg") return io::writeColorPng(path, drawing::imageOf(window));
  vtkNew<vtkWindowToImageFilter> grab;
  grab->SetInput(window);
  grab->ReadFrontBufferOff();
  vtkNew<vtkJPEGWriter> writer;
  writer->SetInputConnection(grab->GetOutputPort());
  writer->SetQuality(kJpegQuality);
  writer->SetFileName(path.c_str());
  writer->Write();
  if (writer->GetErrorCode() != 0) throw io::OutputError(path + ": cannot be written");
}

bool isCloudFile(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  return extension == ".ply" || extension == ".pcd" || extension == ".vtk";
}

void writeShownCloud(const std::string& path, const Cloud& cloud) {
  makeFolder(fs::path(path).parent_path());
  if (fs::path(path).extension() != ".vtk") return io::writeCloud(path, cloud);
  pcl::PCLPointCloud2 blob;
  pcl::toPCLPointCloud2(cloud, blob);
  if (pcl::io::saveVTKFile(path, blob) < 0) throw io::OutputError(path + ": cannot be written");
}

std::unique_ptr<PictureSequence> makePictureSequence(const std::string& path) {
  if (fs::path(path).extension() == ".ogv") return std::make_unique<Video>(path);
  return std::make_unique<NumberedPictures>(path);
}

void Orbit::step(vtkRenderWindow* window, vtkCamera* camera) {
  sequence_->add(window);
  camera->Azimuth(360.0 / pictures_);
  ++taken_;
}

}  // namespace fuse_flow::viewing
