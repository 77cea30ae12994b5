#pragma once

#include <fuse_flow/recordings/image.h>

#include <functional>
#include <optional>
#include <string>

namespace fuse_flow::io {

/** \brief Pixels. */
struct ImageSize {
  int width{0};
  int height{0};
};

/** \brief Checks the width and height that a file claims, pixels, before memory is allocated for them; throws if they are wrong. */
using SizeCheck = std::function<void(int width, int height)>;

/** \brief Reads a 16-bit grey PNG into image, whose buffer is reused. Throws InputError if the file is missing,
 *  damaged, cut short, or of another type. */
void readDepthPng(const std::string& path, DepthImage& image, const SizeCheck& check = {});

/** \brief Reads an 8-bit PNG or JPEG, chosen by content; grey is spread over the three channels, alpha dropped. Throws
 *  InputError. */
void readColor(const std::string& path, ColorImage& image, const SizeCheck& check = {});

/** \brief The same from a file's bytes, which came from elsewhere. \param name what messages call it */
void decodeColor(const std::string& name, const std::string& bytes, ColorImage& image, const SizeCheck& check = {});

/** \brief As readDepthPng() from a file's bytes. \param name what messages call it */
void decodeDepthPng(const std::string& name, const std::string& bytes, DepthImage& image, const SizeCheck& check = {});

/** \brief The size of an image of readColor(), without decoding it. Throws InputError. */
ImageSize colorSize(const std::string& path);

/** \brief Reads an 8-bit or 16-bit grey PNG. Throws InputError.
 *  \param scale confidence per step; absent: the largest value of the file's type, 255 or 65535, is 1
 *  \returns the confidence per step */
float readConfidencePng(const std::string& path, FloatImage& image, std::optional<float> scale = {},
                        const SizeCheck& check = {});

/** \brief Writes a 16-bit grey PNG. Throws OutputError. */
void writeDepthPng(const std::string& path, const DepthImage& image);

/** \brief Writes an 8-bit RGB PNG. Throws OutputError. */
void writeColorPng(const std::string& path, const ColorImage& image);

}  // namespace fuse_flow::io
