#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>

namespace io_test {

/** \brief The bytes of a number, the least first, or the greatest. */
template <typename Number>
std::string rawBytes(Number number, bool big_endian = false) {
  char bytes[sizeof(Number)];
  std::memcpy(bytes, &number, sizeof(Number));
  if (big_endian) std::reverse(bytes, bytes + sizeof(Number));
  return std::string(bytes, sizeof(Number));
}

using PixelValue = std::function<float(int u, int v)>;

/** \brief The bottom row first, as the format says. */
inline std::string pfm(int width, int height, const PixelValue& value, bool big_endian = false) {
  std::string bytes =
      "Pf\n" + std::to_string(width) + " " + std::to_string(height) + "\n" + (big_endian ? "1.0\n" : "-1.0\n");
  for (int v = height - 1; v >= 0; --v)
    for (int u = 0; u < width; ++u) bytes += rawBytes(value(u, v), big_endian);
  return bytes;
}

/** \brief As NumPy 1.24 writes it: a header of 118 bytes behind the first ten. */
inline std::string npy(const std::string& descr, const std::string& shape, const std::string& data,
                       const char* fortran = "False") {
  std::string header = "{'descr': '" + descr + "', 'fortran_order': " + fortran + ", 'shape': " + shape + ", }";
  header.resize(117, ' ');
  return std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header + "\n" + data;
}

inline std::string floats(int width, int height, const PixelValue& value, bool big_endian = false) {
  std::string bytes;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) bytes += rawBytes(value(u, v), big_endian);
  return bytes;
}

inline std::string colmapMap(int width, int height, const PixelValue& value) {
  return std::to_string(width) + "&" + std::to_string(height) + "&1&" + floats(width, height, value);
}

}  // namespace io_test
