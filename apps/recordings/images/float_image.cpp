#include "recordings/images/float_image.h"

#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"
#include "recordings/images/exr_image.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <regex>
#include <sstream>

namespace fuse_flow::io {
namespace {

/** \brief Where the numbers of an image lie in its file. */
struct Samples {
  int width{0};
  int height{0};
  std::size_t begin{0};  ///< of the first number, bytes
  std::size_t size{4};   ///< of each, bytes: float, or 8 for double
  bool big_endian{false};
  bool bottom_first{false};
};

std::string extensionOf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/** \brief A side as a file says it. */
int sideOf(const std::string& path, const std::string& digits) {
  if (digits.empty() || digits.size() > 5 || std::stoi(digits) < 1 || std::stoi(digits) > 65535)
    throw InputError(path + ": says that a side is " + cutShort(digits) + " pixels, must be 1 to 65535");
  return std::stoi(digits);
}

/** \brief The words of a header in text, and how long it is; none where a file begins otherwise. */
struct HeaderWords {
  std::vector<std::string> words;
  std::size_t length{0};
};

HeaderWords matchHeader(const std::string& bytes, const std::regex& header) {
  const std::string start = bytes.substr(0, 256);
  std::smatch match;
  if (!std::regex_search(start, match, header, std::regex_constants::match_continuous)) return {};
  HeaderWords found;
  found.words.assign(std::next(match.begin()), match.end());
  found.length = static_cast<std::size_t>(match.length(0));
  return found;
}

/** \brief "Pf", width and height, and a number whose sign says the order of the bytes, each behind white space; then the bottom row. */
Samples readPfmHeader(const std::string& path, const std::string& bytes) {
  static const std::regex header(R"((P[fF])\s+(\d+)\s+(\d+)\s+([-+]?[0-9.eE+-]+)[ \t\r]*\n)");
  const auto [words, length] = matchHeader(bytes, header);
  if (words.empty()) throw InputError(path + ": is no PFM, must begin with Pf, width, height and the scale");
  if (words[0] == "PF") throw InputError(path + ": is a PFM of three channels, must be of one (Pf)");
  Samples samples;
  samples.width = sideOf(path, words[1]);
  samples.height = sideOf(path, words[2]);
  const double scale = std::strtod(words[3].c_str(), nullptr);
  if (scale == 0) throw InputError(path + ": has the scale 0, whose sign must say the order of its bytes");
  samples.big_endian = scale > 0;
  samples.bottom_first = true;
  samples.begin = length;
  return samples;
}

/** \brief Magic, version, length of a Python dictionary, and the dictionary: {'descr': '<f4', 'fortran_order': False, 'shape': (480, 640), }. */
Samples readNpyHeader(const std::string& path, const std::string& bytes) {
  const auto wrong = [&path](const std::string& what) {
    return InputError(path + ": " + what + ", must be a NumPy array of height x width");
  };
  if (bytes.size() < 12 || bytes.compare(0, 6, "\x93NUMPY") != 0) throw wrong("is no .npy file");
  const auto byte = [&bytes](std::size_t k) { return static_cast<std::size_t>(static_cast<unsigned char>(bytes[k])); };
  const bool old = byte(6) == 1;
  const std::size_t begin = old ? 10 : 12;
  const std::size_t length = byte(8) + (byte(9) << 8) + (old ? 0 : (byte(10) << 16) + (byte(11) << 24));
  constexpr std::size_t longest = 4096;  // the expressions below go as deep as it is long
  if (length > longest) throw wrong("has a header of " + std::to_string(length) + " bytes");
  if (begin + length > bytes.size()) throw wrong("is cut short");
  const std::string header = bytes.substr(begin, length);
  std::smatch descr, order, shape;
  if (!std::regex_search(header, descr, std::regex(R"('descr':\s*'([<>|=])([a-z])(\d+)')")) ||
      !std::regex_search(header, order, std::regex(R"('fortran_order':\s*(True|False))")) ||
      !std::regex_search(header, shape, std::regex(R"('shape':\s*\(([0-9, ]*)\))")))
    throw wrong("has no header of a plain array");
  if (order[1] == "True") throw wrong("is stored column by column");
  std::vector<std::string> sides;
  std::istringstream words(std::regex_replace(shape[1].str(), std::regex(","), " "));
  for (std::string word; words >> word;) sides.push_back(word);
  while (sides.size() > 2 && sides.front() == "1") sides.erase(sides.begin());
  while (sides.size() > 2 && sides.back() == "1") sides.pop_back();
  if (sides.size() != 2) throw wrong("has the shape (" + cutShort(shape[1].str()) + ")");
  Samples samples;
  samples.height = sideOf(path, sides[0]);
  samples.width = sideOf(path, sides[1]);
  samples.begin = begin + length;
  samples.size = descr[3] == "8" ? 8 : 4;
  samples.big_endian = descr[1] == ">";
  if (descr[2] != "f" || (descr[3] != "4" && descr[3] != "8"))
    throw InputError(path + ": has numbers of type " + descr[2].str() + descr[3].str() +
                     ", must be float32 or float64 (f4, f8)");
  return samples;
}

/** \brief "width&height&channels&", then the top row. */
Samples readColmapHeader(const std::string& path, const std::string& bytes) {
  static const std::regex header(R"((\d+)&(\d+)&(\d+)&)");
  const auto [words, length] = matchHeader(bytes, header);
  if (words.empty()) throw InputError(path + ": is no depth map of COLMAP, must begin with width&height&1&");
  if (words[2] != "1") throw InputError(path + ": has " + cutShort(words[2]) + " channels, must be a depth map, of 1");
  Samples samples;
  samples.width = sideOf(path, words[0]);
  samples.height = sideOf(path, words[1]);
  samples.begin = length;
  return samples;
}

Samples readHeader(const std::string& path, const std::string& bytes) {
  const std::string extension = extensionOf(path);
  if (extension == ".pfm") return readPfmHeader(path, bytes);
  if (extension == ".npy") return readNpyHeader(path, bytes);
  return readColmapHeader(path, bytes);
}

template <typename Number>
float numberAt(const char* at, bool swapped) {
  char bytes[sizeof(Number)];
  std::memcpy(bytes, at, sizeof(Number));
  if (swapped) std::reverse(bytes, bytes + sizeof(Number));
  Number number;
  std::memcpy(&number, bytes, sizeof(Number));
  constexpr auto most = static_cast<Number>(std::numeric_limits<float>::max());
  if (number > most) return std::numeric_limits<float>::infinity();  // a cast would be undefined
  if (number < -most) return -std::numeric_limits<float>::infinity();
  return static_cast<float>(number);
}

template <typename Number>
void copyRow(const char* from, bool swapped, float* to, int width) {
  for (int u = 0; u < width; ++u)
    to[u] = numberAt<Number>(from + sizeof(Number) * static_cast<std::size_t>(u), swapped);
}

}  // namespace

const std::vector<std::string>& floatImageExtensions() {
  static const std::vector<std::string> extensions = {".pfm", ".npy", ".bin", ".exr"};
  return extensions;
}

bool isFloatImage(const std::string& path) {
  const std::vector<std::string>& known = floatImageExtensions();
  return std::find(known.begin(), known.end(), extensionOf(path)) != known.end();
}

ImageSize floatImageSize(const std::string& path) {
  if (extensionOf(path) == ".exr") return exrSize(path);
  const Samples samples = readHeader(path, readFileStart(path, 8192));
  return {samples.width, samples.height};
}

void readFloatImage(const std::string& path, FloatImage& image, const SizeCheck& check) {
  if (extensionOf(path) == ".exr") {
    readExr(path, image, check);
    return;
  }
  const std::string bytes = readFile(path);
  const Samples samples = readHeader(path, bytes);
  if (check) check(samples.width, samples.height);
  const std::size_t row = samples.size * static_cast<std::size_t>(samples.width);
  const std::size_t wanted = samples.begin + row * static_cast<std::size_t>(samples.height);
  if (bytes.size() != wanted)
    throw InputError(path + ": has " + std::to_string(bytes.size()) + " bytes, an image of " +
                     std::to_string(samples.width) + "x" + std::to_string(samples.height) + " must have " +
                     std::to_string(wanted));
  image.resize(samples.width, samples.height);
  for (int v = 0; v < samples.height; ++v) {
    const int place = samples.bottom_first ? samples.height - 1 - v : v;
    const char* from = bytes.data() + samples.begin + row * static_cast<std::size_t>(place);
    float* to = &image.at(0, v);
    if (samples.size == 4)
      copyRow<float>(from, samples.big_endian, to, samples.width);
    else
      copyRow<double>(from, samples.big_endian, to, samples.width);
  }
}

void writeNpy(const std::string& path, const FloatImage& image) {
  static_assert(sizeof(float) == 4, "float is float32");
  const std::uint16_t one = 1;
  const bool little_endian = *reinterpret_cast<const unsigned char*>(&one) == 1;
  std::string header = std::string("{'descr': '") + (little_endian ? '<' : '>') +
                       "f4', 'fortran_order': False, 'shape': (" + std::to_string(image.height) + ", " +
                       std::to_string(image.width) + "), }";
  constexpr std::size_t begin = 10, aligned = 64;  // bytes: what precedes the header, and where the numbers may begin
  header.resize((begin + header.size() + aligned) / aligned * aligned - begin, ' ');
  header.back() = '\n';
  std::string bytes = "\x93NUMPY";
  for (const std::size_t byte : {std::size_t{1}, std::size_t{0}, header.size() & 255, header.size() >> 8})
    bytes += static_cast<char>(byte);
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(image.data.data()), image.data.size() * sizeof(float));
  writeFile(path, bytes);
}

}  // namespace fuse_flow::io
