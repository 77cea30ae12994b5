#pragma once

#include "recordings/streams/frame_sets.h"

#include <fuse_flow/recordings/image.h>

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A video of one colour camera, such as .mp4, .mov or .avi, by libavformat and libavcodec: any picture of it. It is read through once as it is
 *  opened, to find all pictures. Only one thread may use an object, but for convert(). */
class DecodedVideo {
 public:
  /** \brief Throws InputError if it cannot be read, or has no video. */
  explicit DecodedVideo(const std::string& path);
  ~DecodedVideo();
  DecodedVideo(const DecodedVideo&) = delete;
  DecodedVideo& operator=(const DecodedVideo&) = delete;

  const std::string& path() const { return path_; }
  int width() const { return width_; }    ///< pixels, as they are stored
  int height() const { return height_; }  ///< rows
  /** \brief When its pictures were taken, since the start of the file; strictly ascending. */
  const std::vector<Nanoseconds>& stamps() const { return stamps_; }
  /** \brief Assumptions and losses at opening, a line each. */
  const std::vector<std::string>& warnings() const { return warnings_; }

  /** \brief A picture as its codec has it. Fastest in ascending order. Throws InputError. \param bytes for convert() */
  void decode(std::size_t number, std::string& bytes);
  /** \brief What decode() gave as RGB, by the matrix and the range that the video names; those that name none are taken for BT.709 from 720 rows on, else
   *  for BT.601, of limited range. For any thread. Throws InputError. */
  void convert(std::size_t number, const std::string& bytes, ColorImage& image) const;

 private:
  struct Decoder;

  void readThrough();
  void jumpBefore(std::size_t number);
  bool next();
  std::string nameOf(std::size_t number) const;
  std::optional<Nanoseconds> stampOfFrame() const;
  void copyPicture(std::size_t number, std::string& bytes) const;

  std::string path_;
  std::vector<std::string> warnings_;
  std::vector<Nanoseconds> stamps_;
  int width_{0}, height_{0};
  std::unique_ptr<Decoder> decoder_;
  /** \brief Pictures that were passed, by their number: frames are asked for by several threads, not quite in their order. */
  std::map<std::size_t, std::string> passed_;
};

}  // namespace fuse_flow::io
