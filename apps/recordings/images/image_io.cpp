#include "recordings/images/image_io.h"

#include "recordings/files/file_io.h"
#include "recordings/images/jpeg_decode.h"
#include "recordings/images/png_check.h"
#include "recordings/images/png_decode.h"

#include <fuse_flow/recordings/error.h>

#include <vtkCommand.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
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

std::string describe(const PngHeader& header) {
  const char* type = header.color_type == 0   ? "grey"
                     : header.color_type == 2 ? "RGB"
                     : header.color_type == 3 ? "palette"
                     : header.color_type == 4 ? "grey and alpha"
                                              : "RGB and alpha";
  return std::to_string(header.bits) + "-bit " + type;
}

/** \brief Of grey the one channel three times; alpha is dropped. */
void copyColorRow(const std::uint8_t* from, int channels, Rgb8* to, int width) {
  for (int u = 0; u < width; ++u, from += channels)
    to[u] = channels >= 3 ? Rgb8{from[0], from[1], from[2]} : Rgb8{from[0], from[0], from[0]};
}

void readColorPng(const std::string& path, const std::string& bytes, ColorImage& image, const SizeCheck& check) {
  const PngHeader header = checkPng(path, bytes);
  if (header.bits == 16) throw InputError(path + ": is a " + describe(header) + " PNG, colour must be 8-bit");
  if (check) check(header.width, header.height);
  PngPixels pixels;
  decodePng(path, bytes, pixels);
  image.resize(pixels.width, pixels.height);
  for (int v = 0; v < image.height; ++v)
    copyColorRow(pixels.row<std::uint8_t>(v), pixels.channels, &image.at(0, v), image.width);
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
float copyConfidence(const PngPixels& pixels, std::optional<float> given, FloatImage& image) {
  const float scale = given.value_or(1.0f / std::numeric_limits<Sample>::max());
  const Sample* first = pixels.row<Sample>(0);
  std::transform(first, first + image.data.size(), image.data.begin(),
                 [scale](Sample s) { return static_cast<float>(s) * scale; });
  return scale;
}

}  // namespace

void decodeDepthPng(const std::string& path, const std::string& bytes, DepthImage& image, const SizeCheck& check) {
  const PngHeader header = checkPng(path, bytes);
  if (header.bits != 16 || header.color_type != 0)
    throw InputError(path + ": is a " + describe(header) + " PNG, depth must be 16-bit grey");
  if (check) check(header.width, header.height);
  PngPixels pixels;
  decodePng(path, bytes, pixels);
  image.resize(pixels.width, pixels.height);
  std::copy_n(pixels.row<std::uint16_t>(0), image.data.size(), image.data.begin());
}

void readDepthPng(const std::string& path, DepthImage& image, const SizeCheck& check) {
  decodeDepthPng(path, readFile(path), image, check);
}

void decodeColor(const std::string& path, const std::string& bytes, ColorImage& image, const SizeCheck& check) {
  if (isPng(bytes)) {
    readColorPng(path, bytes, image, check);
  } else {
    checkJpeg(path, bytes);
    decodeJpeg(path, bytes, image, check);
  }
}

void readColor(const std::string& path, ColorImage& image, const SizeCheck& check) {
  decodeColor(path, readFile(path), image, check);
}

ImageSize colorSize(const std::string& path) {
  const std::string bytes = readFile(path);
  if (!isPng(bytes)) {
    checkJpeg(path, bytes);
    return jpegSize(path, bytes);
  }
  const PngHeader header = checkPng(path, bytes);
  return {header.width, header.height};
}

float readConfidencePng(const std::string& path, FloatImage& image, std::optional<float> scale,
                        const SizeCheck& check) {
  const std::string bytes = readFile(path);
  const PngHeader header = checkPng(path, bytes);
  if ((header.bits != 8 && header.bits != 16) || header.color_type != 0)
    throw InputError(path + ": is a " + describe(header) + " PNG, confidence must be 8-bit or 16-bit grey");
  if (check) check(header.width, header.height);
  PngPixels pixels;
  decodePng(path, bytes, pixels);
  image.resize(pixels.width, pixels.height);
  return pixels.bits == 16 ? copyConfidence<std::uint16_t>(pixels, scale, image)
                           : copyConfidence<std::uint8_t>(pixels, scale, image);
}

void writeDepthPng(const std::string& path, const DepthImage& image) {
  writePng<std::uint16_t, 1>(path, image, VTK_UNSIGNED_SHORT);
}

void writeColorPng(const std::string& path, const ColorImage& image) {
  writePng<Rgb8, 3>(path, image, VTK_UNSIGNED_CHAR);
}

}  // namespace fuse_flow::io
