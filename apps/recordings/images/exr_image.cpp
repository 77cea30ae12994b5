#include "recordings/images/exr_image.h"

#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"
#include "recordings/images/exr_headers.h"
#include "recordings/images/plausible_size.h"

#include <fuse_flow/recordings/error.h>

#ifdef FUSE_FLOW_WITH_OPENEXR
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#endif

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

namespace fuse_flow::io {

#ifndef FUSE_FLOW_WITH_OPENEXR

namespace {

[[noreturn]] void refuseExr(const std::string& path) {
  throw InputError(path +
                   ": cannot be read, since FUSE-Flow was built without OpenEXR; install libopenexr-dev, and build it "
                   "again");
}

}  // namespace

ImageSize exrSize(const std::string& path) { refuseExr(path); }
void readExr(const std::string& path, FloatImage&, const SizeCheck&) { refuseExr(path); }

#else

namespace {

/** \brief A file's bytes, as OpenEXR reads them. */
class ExrBytes : public Imf::IStream {
 public:
  using Position = decltype(std::declval<Imf::IStream&>().tellg());  // another type since version 3

  ExrBytes(const std::string& path, const std::string& bytes) : Imf::IStream(path.c_str()), bytes_(bytes) {}
  bool read(char* to, int count) override {
    const auto wanted = static_cast<std::size_t>(std::max(count, 0));
    if (at_ > bytes_.size() || bytes_.size() - at_ < wanted) throw std::runtime_error("it is cut short");
    std::copy_n(bytes_.data() + at_, wanted, to);
    at_ += wanted;
    return at_ < bytes_.size();
  }
  Position tellg() override { return at_; }
  void seekg(Position place) override { at_ = static_cast<std::size_t>(place); }

 private:
  const std::string& bytes_;
  std::size_t at_{0};
};

std::string asSmallLetters(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/** \brief Whether a channel is in a layer Depth, as Blender's "ViewLayer.Depth.Z" is. */
bool isOfDepth(const std::string& channel) {
  const std::string name = asSmallLetters(channel);
  const std::size_t dot = name.rfind('.');
  if (dot == std::string::npos) return name == "depth";
  const std::string layer = name.substr(0, dot);
  return layer == "depth" || (layer.size() > 6 && layer.compare(layer.size() - 6, 6, ".depth") == 0);
}

/** \brief What of a file is read. */
struct ExrChannel {
  int part{0};
  std::string name;
  bool is_half{false};
  bool among_colors{false};  ///< it is red, beside green and blue
};

std::vector<std::string> channelsOf(const Imf::Header& header) {
  std::vector<std::string> names;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
    names.emplace_back(channel.name());
  return names;
}

std::optional<std::string> depthAmong(const std::vector<std::string>& names) {
  const auto named = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  if (named("Z")) return "Z";
  if (const auto depth = std::find_if(names.begin(), names.end(), isOfDepth); depth != names.end()) return *depth;
  if (named("V")) return "V";
  if (names.size() == 1) return names[0];
  for (const char* name : {"Y", "R"})
    if (named(name)) return name;
  return std::nullopt;
}

/** \brief The first part that has one. */
ExrChannel findChannel(const std::string& path, const Imf::MultiPartInputFile& file) {
  std::string all;
  for (int part = 0; part < file.parts(); ++part) {
    const Imf::Header& header = file.header(part);
    const std::vector<std::string> names = channelsOf(header);
    for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
    if (header.hasType() && Imf::isDeepData(header.type())) continue;
    if (const auto name = depthAmong(names)) {
      const Imf::Channel& channel = header.channels()[name->c_str()];
      if (channel.xSampling != 1 || channel.ySampling != 1)
        throw InputError(path + ": its channel " + cutShort(*name) + " does not have every pixel, must have");
      return {part, *name, channel.type == Imf::HALF,
              *name == "R" && header.channels().findChannel("G") != nullptr &&
                  header.channels().findChannel("B") != nullptr};
    }
  }
  throw InputError(path + ": has the channels " + cutShort(all) +
                   ", depth must be in one that is called Z, V, Y or R, or in a layer Depth");
}

/** \brief The picture, of which the pixels in the file may be a part. */
struct ExrWindow {
  int left, top, width, height;  ///< of the pixels in the file, from the picture's corner
  ImageSize size;                ///< of the picture
};

ExrWindow windowOf(const std::string& path, const Imf::Header& header) {
  const auto& picture = header.displayWindow();
  const auto& data = header.dataWindow();
  const auto length = [](int first, int last) { return std::int64_t{last} - first + 1; };
  const std::int64_t width = length(picture.min.x, picture.max.x), height = length(picture.min.y, picture.max.y);
  if (width < 1 || width > 65535 || height < 1 || height > 65535)
    throw InputError(path + ": says that it is " + std::to_string(width) + "x" + std::to_string(height) +
                     " pixels, each side must be 1 to 65535");
  if (data.min.x < picture.min.x || data.max.x > picture.max.x || data.min.y < picture.min.y ||
      data.max.y > picture.max.y)
    throw InputError(path + ": has pixels outside its display window, must have none");
  return {data.min.x - picture.min.x,
          data.min.y - picture.min.y,
          static_cast<int>(length(data.min.x, data.max.x)),
          static_cast<int>(length(data.min.y, data.max.y)),
          {static_cast<int>(width), static_cast<int>(height)}};
}

void insertSlice(Imf::FrameBuffer& buffer, const std::string& name, const Imf::Header& header, const ExrWindow& window,
                 FloatImage& image) {
  // OpenEXR counts from the origin of the file's pixels, which need not be in the buffer.
  const auto& corner = header.dataWindow().min;
  const auto row = static_cast<std::ptrdiff_t>(sizeof(float)) * image.width;
  char* const first = reinterpret_cast<char*>(&image.at(window.left, window.top));
  char* const origin = first - static_cast<std::ptrdiff_t>(sizeof(float)) * corner.x - row * corner.y;
  buffer.insert(name, Imf::Slice(Imf::FLOAT, origin, sizeof(float), static_cast<std::size_t>(row)));
}

void markUnmeasured(FloatImage& image, bool is_half) {
  const float least = is_half ? 65504.0f : 1e9f;
  for (float& z : image.data)
    if (z >= least) z = std::numeric_limits<float>::infinity();
}

void readPart(const std::string& path, std::size_t bytes, Imf::MultiPartInputFile& file, FloatImage& image,
              const SizeCheck& check) {
  const ExrChannel channel = findChannel(path, file);
  const Imf::Header& header = file.header(channel.part);
  const ExrWindow window = windowOf(path, header);
  if (check) check(window.size.width, window.size.height);
  checkPlausible(path, window.size.width, window.size.height, bytes, kMostOfAnyByte);
  Imf::FrameBuffer buffer;
  FloatImage others[2];
  const auto add = [&](const std::string& name, FloatImage& into) {
    into.resize(window.size.width, window.size.height);
    std::fill(into.data.begin(), into.data.end(), 0.0f);
    insertSlice(buffer, name, header, window, into);
  };
  add(channel.name, image);
  if (channel.among_colors) {
    add("G", others[0]);
    add("B", others[1]);
  }
  Imf::InputPart part(file, channel.part);
  part.setFrameBuffer(buffer);
  part.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);
  const auto same = [](float a, float b) { return !(a < b) && !(a > b); };
  for (const FloatImage& other : others)
    if (channel.among_colors && !std::equal(image.data.begin(), image.data.end(), other.data.begin(), same))
      throw InputError(
          path +
          ": is a picture in colour, depth must be in a channel that is called Z, V or Y, or the same in R, G and B");
  markUnmeasured(image, channel.is_half);
}

/** \brief Calls read with the opened file, and how many bytes it has. */
template <typename Read>
void withExr(const std::string& path, const Read& read) {
  const std::string bytes = readFile(path);
  ExrBytes stream(path, bytes);
  try {
    checkExrHeaders(bytes);
    Imf::MultiPartInputFile file(stream, 0);
    read(file, bytes.size());
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {  // whose text has several lines, and names the file again
    throw InputError(path + ": is no OpenEXR image, or damaged or cut short");
  }
}

}  // namespace

ImageSize exrSize(const std::string& path) {
  ImageSize size;
  withExr(path, [&](const Imf::MultiPartInputFile& file, std::size_t) {
    size = windowOf(path, file.header(findChannel(path, file).part)).size;
  });
  return size;
}

void readExr(const std::string& path, FloatImage& image, const SizeCheck& check) {
  withExr(path, [&](Imf::MultiPartInputFile& file, std::size_t bytes) { readPart(path, bytes, file, image, check); });
}

#endif

}  // namespace fuse_flow::io
