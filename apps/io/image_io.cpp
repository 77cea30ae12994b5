#include "io/image_io.h"

#include "io/error.h"
#include "io/file_io.h"
#include "io/png_check.h"

#include <vtkCommand.h>
#include <vtkImageData.h>
#include <vtkJPEGReader.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <limits>

namespace fuse_flow::io {
namespace {

/** \brief Keeps the first error a VTK object reports, instead of VTK printing it. */
class ErrorCatcher : public vtkCommand {
 public:
  static ErrorCatcher* New() { return new ErrorCatcher; }
  void Execute(vtkObject*, unsigned long event, void*) override {
    failed_ = failed_ || event == vtkCommand::ErrorEvent;
  }
  bool failed() const { return failed_; }

 private:
  bool failed_{false};
};

template <typename Reader>
vtkSmartPointer<vtkImageData> decode(const std::string& path, const std::string& bytes) {
  vtkNew<Reader> reader;
  vtkNew<ErrorCatcher> catcher;
  reader->AddObserver(vtkCommand::ErrorEvent, catcher);
  reader->AddObserver(vtkCommand::WarningEvent, catcher);
  reader->SetMemoryBuffer(bytes.data());
  reader->SetMemoryBufferLength(static_cast<vtkIdType>(bytes.size()));
  reader->Update();
  vtkSmartPointer<vtkImageData> image = reader->GetOutput();
  if (catcher->failed() || reader->GetErrorCode() != 0 || !image || !image->GetPointData()->GetScalars())
    throw InputError(path + ": is damaged and cannot be decoded");
  return image;
}

/** \brief VTK keeps the bottom row first; calls copy(from, v) with VTK's row and ours, channels interleaved. */
template <typename Sample, typename CopyRow>
void forEachRow(vtkImageData* image, CopyRow&& copy) {
  const int* size = image->GetDimensions();
  const auto* samples = static_cast<const Sample*>(image->GetScalarPointer());
  const std::size_t row =
      static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(image->GetNumberOfScalarComponents());
  for (int v = 0; v < size[1]; ++v) copy(samples + row * static_cast<std::size_t>(size[1] - 1 - v), v);
}

std::string describe(const PngHeader& header) {
  const char* type = header.color_type == 0   ? "grey"
                     : header.color_type == 2 ? "RGB"
                     : header.color_type == 3 ? "palette"
                     : header.color_type == 4 ? "grey and alpha"
                                              : "RGB and alpha";
  return std::to_string(header.bits) + "-bit " + type;
}

template <typename Pixel, int channels>
void writePng(const std::string& path, const Image<Pixel>& image, int scalar_type) {
  if (image.empty()) throw OutputError(path + ": there is no image to write");
  vtkNew<vtkImageData> data;
  data->SetDimensions(image.width, image.height, 1);
  data->AllocateScalars(scalar_type, channels);
  auto* pixels = static_cast<Pixel*>(data->GetScalarPointer());
  for (int v = 0; v < image.height; ++v)
    std::copy_n(&image.at(0, v), image.width,
                pixels + static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height - 1 - v));
  vtkNew<vtkPNGWriter> writer;
  vtkNew<ErrorCatcher> catcher;
  writer->AddObserver(vtkCommand::ErrorEvent, catcher);
  writer->SetInputData(data);
  writer->SetCompressionLevel(3);  // depth is noisy: higher levels take thrice the time for a few per cent
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  if (catcher->failed() || !bytes || bytes->GetNumberOfValues() == 0) throw OutputError(path + ": cannot be encoded");
  writeFile(path, std::string(reinterpret_cast<const char*>(bytes->GetPointer(0)),
                              static_cast<std::size_t>(bytes->GetNumberOfValues())));
}

template <typename Sample>
void copyConfidence(vtkImageData* source, FloatImage& image) {
  constexpr float scale = 1.0f / std::numeric_limits<Sample>::max();
  forEachRow<Sample>(source, [&](const Sample* from, int v) {
    std::transform(from, from + image.width, &image.at(0, v), [](Sample s) { return static_cast<float>(s) * scale; });
  });
}

}  // namespace

void readDepthPng(const std::string& path, DepthImage& image) {
  const std::string bytes = readFile(path);
  const PngHeader header = checkPng(path, bytes);
  if (header.bits != 16 || header.color_type != 0)
    throw InputError(path + ": is a " + describe(header) + " PNG, depth must be 16-bit grey");
  const auto source = decode<vtkPNGReader>(path, bytes);
  image.resize(header.width, header.height);
  forEachRow<std::uint16_t>(source,
                            [&](const std::uint16_t* from, int v) { std::copy_n(from, image.width, &image.at(0, v)); });
}

void readColor(const std::string& path, ColorImage& image) {
  const std::string bytes = readFile(path);
  vtkSmartPointer<vtkImageData> source;
  if (isPng(bytes)) {
    const PngHeader header = checkPng(path, bytes);
    if (header.bits == 16) throw InputError(path + ": is a " + describe(header) + " PNG, colour must be 8-bit");
    source = decode<vtkPNGReader>(path, bytes);
  } else {
    checkJpeg(path, bytes);
    source = decode<vtkJPEGReader>(path, bytes);
  }
  const int channels = source->GetNumberOfScalarComponents();
  image.resize(source->GetDimensions()[0], source->GetDimensions()[1]);
  forEachRow<std::uint8_t>(source, [&](const std::uint8_t* from, int v) {
    Rgb8* to = &image.at(0, v);
    for (int u = 0; u < image.width; ++u, from += channels)
      to[u] = channels >= 3 ? Rgb8{from[0], from[1], from[2]} : Rgb8{from[0], from[0], from[0]};
  });
}

void readConfidencePng(const std::string& path, FloatImage& image) {
  const std::string bytes = readFile(path);
  const PngHeader header = checkPng(path, bytes);
  if ((header.bits != 8 && header.bits != 16) || header.color_type != 0)
    throw InputError(path + ": is a " + describe(header) + " PNG, confidence must be 8-bit or 16-bit grey");
  const auto source = decode<vtkPNGReader>(path, bytes);
  image.resize(header.width, header.height);
  if (header.bits == 16)
    copyConfidence<std::uint16_t>(source, image);
  else
    copyConfidence<std::uint8_t>(source, image);
}

void writeDepthPng(const std::string& path, const DepthImage& image) {
  writePng<std::uint16_t, 1>(path, image, VTK_UNSIGNED_SHORT);
}

void writeColorPng(const std::string& path, const ColorImage& image) {
  writePng<Rgb8, 3>(path, image, VTK_UNSIGNED_CHAR);
}

}  // namespace fuse_flow::io
