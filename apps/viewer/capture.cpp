#include "viewer/capture.h"

#include "clouds/cloud_io.h"
#include "drawing/image_of.h"
#include "recordings/files/file_io.h"
#include "recordings/images/image_io.h"

#include <fuse_flow/recordings/error.h>

#include <pcl/io/ifs_io.h>
#include <pcl/io/obj_io.h>
#include <pcl/io/vtk_io.h>

#include <vtkJPEGWriter.h>
#include <vtkNew.h>
#include <vtkOggTheoraWriter.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace fuse_flow::viewing {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 88;        // of 100
constexpr unsigned int kObjDigits = 9;  // tell one float from the next

bool isVideo(const std::string& path) { return fs::path(path).extension() == ".ogv"; }

std::string numberedPicture(const fs::path& folder, int number) {
  char name[16];
  std::snprintf(name, sizeof(name), "%06d.png", number);
  return (folder / name).string();
}

class NumberedPictures : public PictureSequence {
 public:
  explicit NumberedPictures(fs::path folder) : folder_(std::move(folder)) { io::makeFolder(folder_); }
  void add(vtkRenderWindow* window) override { writeScreenshot(numberedPicture(folder_, number_++), window); }

 private:
  fs::path folder_;
  int number_{0};
};

class Video : public PictureSequence {
 public:
  explicit Video(std::string path) : path_(std::move(path)) {
    io::makeFolderOf(path_);
    // VTK would print what it thinks of a file that cannot be opened.
    if (!std::ofstream(path_)) throw io::OutputError(path_ + ": cannot be written: " + std::strerror(errno));
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

/** \brief Positions alone, without gaps: PCL writes the bytes of a cloud into an IFS as they are, and reads 12 a point. */
pcl::PCLPointCloud2 positionsOf(const Cloud& cloud) {
  pcl::PCLPointCloud2 blob;
  blob.width = static_cast<std::uint32_t>(cloud.size());
  blob.height = 1;
  blob.is_dense = true;
  blob.point_step = 3 * sizeof(float);
  blob.row_step = blob.point_step * blob.width;
  blob.data.resize(blob.row_step);
  for (const char* axis : {"x", "y", "z"}) {
    pcl::PCLPointField field;
    field.name = axis;
    field.offset = static_cast<std::uint32_t>(blob.fields.size() * sizeof(float));
    field.datatype = pcl::PCLPointField::FLOAT32;
    field.count = 1;
    blob.fields.push_back(field);
  }
  for (std::size_t k = 0; k < cloud.size(); ++k)
    std::memcpy(&blob.data[k * blob.point_step], cloud[k].data, blob.point_step);
  return blob;
}

/** \brief PCL opens and fills some files without asking whether it could: an OBJ is whole if its last line is there. */
bool endsWith(const std::string& path, const std::string& line) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(-static_cast<std::streamoff>(line.size()), std::ios::end);
  std::string end(line.size(), '\0');
  return file.read(end.data(), static_cast<std::streamsize>(end.size())) && end == line;
}

/** \brief Whether it could. */
bool writeWithPcl(const std::string& path, const std::string& extension, const Cloud& cloud) {
  if (extension == ".ifs") std::ofstream{path};  // with the rights of any file; PCL makes one that only its owner reads
  if (extension == ".ifs") return pcl::io::saveIFSFile(path, positionsOf(cloud)) == 0;
  if (extension == ".obj") {
    pcl::PolygonMesh mesh;  // without polygons: PCL writes OBJ for meshes only
    mesh.cloud = positionsOf(cloud);
    return pcl::io::saveOBJFile(path, mesh, kObjDigits) == 0 && endsWith(path, "# End of File\n");
  }
  pcl::PCLPointCloud2 blob;
  pcl::toPCLPointCloud2(cloud, blob);
  return pcl::io::saveVTKFile(path, blob) == 0 && fs::file_size(path) > 0;
}

}  // namespace

void writeScreenshot(const std::string& path, vtkRenderWindow* window) {
  io::makeFolderOf(path);
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

bool isPictureFile(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  return extension == ".png" || extension == ".jpg";
}

const std::vector<std::string>& cloudFormats() {
  static const std::vector<std::string> formats{"ply", "pcd", "vtk", "ifs", "obj"};
  return formats;
}

bool isCloudFile(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  return std::any_of(cloudFormats().begin(), cloudFormats().end(),
                     [&](const std::string& format) { return extension == "." + format; });
}

void writeShownCloud(const std::string& path, const Cloud& cloud) {
  io::makeFolderOf(path);
  const std::string extension = fs::path(path).extension().string();
  if (extension == ".ply" || extension == ".pcd") return io::writeCloud(path, cloud);
  if (cloud.empty())
    throw io::OutputError(path + ": the cloud has no points, without which PCL writes no " + extension);
  const io::SilencePcl silence;
  const std::string part = io::unfinishedName(path);
  bool written = false;
  try {
    written = writeWithPcl(part, extension, cloud);
  } catch (const std::exception&) {  // of the mapped file that PCL writes IFS into
  }
  std::error_code error;
  if (written) fs::rename(part, path, error);
  if (written && !error) return;
  std::error_code ignored;
  fs::remove(part, ignored);
  throw io::OutputError(path + ": cannot be written" + (error ? ": " + error.message() : ""));
}

std::vector<std::string> filesOfFilm(const std::string& path, int pictures) {
  if (isVideo(path)) return {path};
  std::vector<std::string> files;
  for (int number = 0; number < pictures; ++number) files.push_back(numberedPicture(path, number));
  return files;
}

std::unique_ptr<PictureSequence> makePictureSequence(const std::string& path) {
  if (isVideo(path)) return std::make_unique<Video>(path);
  return std::make_unique<NumberedPictures>(path);
}

void Orbit::step(vtkRenderWindow* window, vtkCamera* camera) {
  sequence_->add(window);
  camera->Azimuth(360.0 / pictures_);
  ++taken_;
}

}  // namespace fuse_flow::viewing
