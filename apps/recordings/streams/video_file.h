#pragma once

#include "recordings/streams/frame_sets.h"

#include <fuse_flow/recordings/image.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief How the images of a video track are stored. */
enum class VideoCodec { Grey16BigEndian, Mjpeg, Nv12, Yuy2, Bgra, Other };

/** \brief A track of images in a Matroska file. */
struct VideoTrack {
  std::string title;  ///< as its recorder calls it: "DEPTH"
  std::map<std::string, std::string> tags;
  VideoCodec codec{VideoCodec::Other};
  std::string codec_name;           ///< for messages
  int width{0};                     ///< pixels
  int height{0};                    ///< rows
  std::vector<Nanoseconds> stamps;  ///< of its packets, since the start of the file, strictly ascending
};

/** \brief A Matroska file by libavformat: its tracks, tags and attachments, and any packet of a track. It is read through once as it is opened, to find
 *  all packets, also of a file whose recorder was killed; what is kept of a packet are some bytes. Only one thread may use an object. */
class VideoFile {
 public:
  /** \brief Throws InputError if it cannot be read, or is no Matroska file. \param titles of the tracks that are wanted */
  VideoFile(const std::string& path, const std::vector<std::string>& titles);
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  const std::string& path() const { return path_; }
  /** \brief Of the whole file. */
  const std::map<std::string, std::string>& tags() const { return tags_; }
  /** \brief The file attached under a name; empty if there is none. */
  std::string attachment(const std::string& name) const;
  /** \brief The wanted track of that title; null: there is none. */
  const VideoTrack* track(const std::string& title) const;
  /** \brief Assumptions and losses at opening, a line each. */
  const std::vector<std::string>& warnings() const { return warnings_; }

  /** \brief The bytes of a packet. Fastest in ascending order, several tracks side by side. Throws InputError. \param number of its stamp */
  const std::string& packet(const VideoTrack& track, std::size_t number);

 private:
  struct Demuxer;

  std::string path_;
  std::map<std::string, std::string> tags_;
  std::vector<std::string> warnings_;
  std::vector<VideoTrack> tracks_;
  std::unique_ptr<Demuxer> demuxer_;
};

/** \brief Whether a file can be opened, and has nothing of a recorder of depth cameras. */
bool isPlainVideo(const std::string& path);

/** \brief An uncompressed image of a camera as RGB: BT.601, as USB cameras have it. Throws InputError, beginning with name, unless bytes has the size of such an image.
 *  \param codec Nv12, Yuy2 or Bgra */
void convertColor(const std::string& name, VideoCodec codec, int width, int height, const std::string& bytes,
                  ColorImage& image);

}  // namespace fuse_flow::io
