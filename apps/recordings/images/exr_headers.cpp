#include "recordings/images/exr_headers.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <utility>

namespace fuse_flow::io {
namespace {

/** \brief Goes through the headers of a file, of which one of several parts has one each. */
class ExrHeaders {
 public:
  explicit ExrHeaders(const std::string& bytes) : bytes_(bytes) {}

  void check() {
    constexpr unsigned char tiled = 0x02, several_parts = 0x10;
    const unsigned int flags = bytes_.size() > 5 ? static_cast<unsigned char>(bytes_[5]) : 0u;
    at_ = 8;  // behind a magic number, a version and its flags
    blocks_ = {};
    for (bool is_first = true;; is_first = false) {
      if (const std::string name = text(); !name.empty()) {
        attribute(name);
        continue;
      }
      checkTable((flags & tiled) != 0);
      if ((flags & several_parts) == 0 || is_first || peek() == '\0') return;  // of several an empty header is the end
    }
  }

 private:
  /** \brief What says how many blocks of pixels a part has. */
  struct Blocks {
    std::int64_t width{0}, height{0}, lines{1}, tile_width{0}, tile_height{0};
    std::int64_t count{0};  ///< as it says itself
    bool are_tiles{false};
  };

  [[noreturn]] static void fail() { throw std::runtime_error("an attribute is not as long as it says"); }
  void need(std::size_t count) const {
    if (at_ > bytes_.size() || count > bytes_.size() - at_) fail();
  }
  char peek() const {
    need(1);
    return bytes_[at_];
  }
  std::string text() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) fail();
    std::string text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return text;
  }
  std::uint32_t number() {
    need(4);
    std::uint32_t value = 0;
    for (std::size_t k = 4; k > 0; --k) value = value << 8 | static_cast<unsigned char>(bytes_[at_ + k - 1]);
    at_ += 4;
    return value;
  }

  std::int64_t whole() { return static_cast<std::int32_t>(number()); }

  /** \brief Throws unless the file is as long as a table of where each block is, for which OpenEXR takes up to 8 MiB before it reads it. */
  void checkTable(bool are_tiles) {
    const auto parts = [](std::int64_t all, std::int64_t each) { return each > 0 ? (all + each - 1) / each : 0; };
    const Blocks part = std::exchange(blocks_, {});
    const double count = are_tiles || part.are_tiles ? static_cast<double>(parts(part.width, part.tile_width)) *
                                                           static_cast<double>(parts(part.height, part.tile_height))
                                                     : static_cast<double>(parts(part.height, part.lines));
    constexpr double entry = 8;  // bytes
    if (entry * std::max(count, static_cast<double>(part.count)) > static_cast<double>(bytes_.size())) fail();
  }

  /** \brief Notes what says how many blocks there are. The value lies within the file, and is as long as its type. */
  void noteBlocks(const std::string& name, const std::string& type, std::size_t size) {
    // Of OpenEXR's compressions, from none to DWAB.
    static constexpr std::array<std::int64_t, 10> lines{1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
    if (name == "dataWindow" && type == "box2i") {
      const std::int64_t left = whole(), top = whole();
      blocks_.width = whole() - left + 1;
      blocks_.height = whole() - top + 1;
    } else if (name == "compression" && type == "compression") {
      const auto kind = static_cast<unsigned char>(bytes_[at_]);
      blocks_.lines = kind < lines.size() ? lines[kind] : 1;
    } else if (name == "tiles" && type == "tiledesc") {
      blocks_.tile_width = whole();
      blocks_.tile_height = whole();
    } else if (name == "chunkCount" && type == "int") {
      blocks_.count = whole();
    } else if (name == "type" && type == "string") {
      const std::string kind = bytes_.substr(at_, size);
      blocks_.are_tiles = kind == "tiledimage" || kind == "deeptile";
    }
  }

  void attribute(const std::string& name) {
    static const std::map<std::string, std::size_t> sizes{{"box2i", 16},
                                                          {"box2f", 16},
                                                          {"chromaticities", 32},
                                                          {"compression", 1},
                                                          {"deepImageState", 1},
                                                          {"double", 8},
                                                          {"envmap", 1},
                                                          {"float", 4},
                                                          {"int", 4},
                                                          {"keycode", 28},
                                                          {"lineOrder", 1},
                                                          {"m33f", 36},
                                                          {"m33d", 72},
                                                          {"m44f", 64},
                                                          {"m44d", 128},
                                                          {"rational", 8},
                                                          {"tiledesc", 9},
                                                          {"timecode", 8},
                                                          {"v2i", 8},
                                                          {"v2f", 8},
                                                          {"v2d", 16},
                                                          {"v3i", 12},
                                                          {"v3f", 12},
                                                          {"v3d", 24}};
    const std::string type = text();
    const std::size_t size = number(), begin = at_;
    need(size);
    if (const auto fixed = sizes.find(type); fixed != sizes.end() && fixed->second != size) fail();
    noteBlocks(name, type, size);
    at_ = begin;
    if (type == "chlist") {
      while (!text().empty()) {
        need(16);
        at_ += 16;
      }
      if (at_ != begin + size) fail();
    } else if (type == "preview") {
      const std::uint64_t width = number(), height = number();
      if (width > 65535 || height > 65535 || 8 + 4 * width * height != size) fail();
    } else if (type == "stringvector") {
      while (at_ < begin + size) {
        const std::size_t length = number();
        need(length);
        at_ += length;
      }
      if (at_ != begin + size) fail();
    } else if (type == "idmanifest") {  // compressed by zlib
      constexpr std::size_t best_compression = 1100;
      if (size < 4 || number() / best_compression > size) fail();
    }
    at_ = begin + size;
  }

  const std::string& bytes_;
  std::size_t at_{0};
  Blocks blocks_;  // of the part whose header is read
};

}  // namespace

void checkExrHeaders(const std::string& bytes) { ExrHeaders(bytes).check(); }

}  // namespace fuse_flow::io
