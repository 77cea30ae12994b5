#pragma once

#include "../../fuzz_target.h"
#include "../../image_limits.h"

#include "recordings/messages/camera_lens.h"
#include "recordings/messages/frame_tree.h"
#include "recordings/messages/image_messages.h"
#include "recordings/messages/ros_messages.h"

#include <fuse_flow/recordings/error.h>

namespace fuse_flow_fuzz {

template <typename Message>
void decodeImages(const Message& message) {
  using namespace fuse_flow;
  io::kindOf(message, "/camera/depth/image_raw");
  io::LoadedView images;
  accepts<io::InputError>([&] { io::decodeDepth("message", message, images, allowImage); });
  accepts<io::InputError>([&] { io::decodeColor("message", message, images.color, allowImage); });
}

/** \brief The first byte says of what type the message is that the others are. */
inline void readMessage(fuse_flow::io::Wire wire, std::string_view input) {
  using namespace fuse_flow;
  if (input.empty()) return;
  const std::string message(input.substr(1));
  accepts<io::InputError>([&] {
    const auto in = io::makeWireReader(wire, "message", message);
    std::vector<std::string> warnings;
    io::FrameTree tree;
    switch (static_cast<unsigned char>(input[0]) % 4) {
      case 0:
        decodeImages(io::readImage(*in));
        break;
      case 1:
        decodeImages(io::readCompressedImage(*in));
        break;
      case 2:
        io::lensOf("message", io::readCameraInfo(*in), message.size() % 2 == 0, warnings);
        break;
      default:
        for (const io::TransformMessage& transform : io::readTransforms(*in)) {
          tree.add(transform);
          tree.root(transform.child);
          tree.between(transform.child, transform.header.frame);
          tree.toRoot(transform.child);
        }
    }
  });
}

}  // namespace fuse_flow_fuzz
