#pragma once

#include "recordings/images/image_io.h"
#include "recordings/messages/ros_messages.h"

#include <fuse_flow/recordings/recording.h>

#include <string>

namespace fuse_flow::io {

/** \brief What an image message can be used for. */
enum class ImageKind { Depth, Color, Neither };

/** \brief \param topic 16 bits of grey are depth if its name says so */
ImageKind kindOf(const ImageMessage& image, const std::string& topic);
ImageKind kindOf(const CompressedImageMessage& image, const std::string& topic);

/** \brief Depth of 16UC1 or mono16 into depth16, of 32FC1, in metres, into depth32; the other is emptied. Throws InputError, beginning with name.
 *  \param check as of readDepthPng() */
void decodeDepth(const std::string& name, const ImageMessage& image, LoadedView& into, const SizeCheck& check = {});
/** \brief The same of image_transport's compressedDepth, PNG or RVL. */
void decodeDepth(const std::string& name, const CompressedImageMessage& image, LoadedView& into,
                 const SizeCheck& check = {});

/** \brief Colour, grey, Bayer patterns (bilinear) and YUV of BT.601 as RGB. Throws InputError, beginning with name, for another encoding. */
void decodeColor(const std::string& name, const ImageMessage& image, ColorImage& into, const SizeCheck& check = {});
/** \brief JPEG and PNG. */
void decodeColor(const std::string& name, const CompressedImageMessage& image, ColorImage& into,
                 const SizeCheck& check = {});

}  // namespace fuse_flow::io
