#pragma once

#include "stream/foxglove/schemas.h"

#include <fuse_flow/stream/description.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::stream::foxglove {

/** \brief What clients can subscribe to. */
struct Topic {
  std::uint32_t id{0};  ///< of the channel; the same for the same topic, whatever else changes
  std::string name;     ///< "/tf"
  const Schema* schema{nullptr};
  /** \brief What all subscribers get once, and again when it changes; null: clouds and images, which come from elsewhere. */
  std::shared_ptr<const std::string> message;
  std::uint64_t version{0};  ///< of the message
  std::uint64_t time{0};     ///< of the message, nanoseconds since 1970
};

/** \brief Where the images of a camera go. */
struct ImageChannel {
  std::uint32_t id{0};  ///< 0: the camera has not had an image yet, and no channel
  std::string frame;    ///< of the camera that takes them, x right, y down
  int width{0};         ///< pixels that an image must have, as the camera's calibration is of this size
  int height{0};        ///< rows
};

/** \brief What is known of a stream, as messages of Foxglove. */
struct Channels {
  std::uint64_t version{0};
  std::string name;                  ///< of the stream
  std::string frame;                 ///< of the clouds
  std::vector<Topic> topics;         ///< by id
  std::vector<ImageChannel> images;  ///< of each camera
  std::uint32_t last_id{0};

  const Topic* find(std::uint32_t id) const;
  /** \brief Whether a channel is of a camera's images. */
  bool hasImages(std::uint32_t id) const;
};

constexpr std::uint32_t kPointsChannel = 1;

/** \brief The channels /points, /tf, and of each camera /cameras/NAME/calibration and, if it has had an image, /cameras/NAME/image. Calibration and
 *  image are those of the colour camera where one stands beside; its frame is NAME_color. \param time of what has changed, nanoseconds since 1970
 *  \param before messages that are still true stay as they were, with their version and time; names that had images keep their channel
 *  \param with_images position of a camera that has its first image */
Channels channelsOf(const Description& description, std::uint64_t time, const Channels& before,
                    std::optional<std::size_t> with_images = {});

/** \brief The first message of a server. \param session a text that is another one when the server starts again */
std::string serverInfo(const Channels& channels, const std::string& session);
std::string advertisement(const std::vector<const Topic*>& topics);
std::string unadvertisement(const std::vector<std::uint32_t>& ids);
/** \param level 0: for information, 1: a warning, 2: an error */
std::string statusMessage(int level, const std::string& text);

}  // namespace fuse_flow::stream::foxglove
