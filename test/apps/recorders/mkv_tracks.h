#pragma once

/** \file
 *  \brief Tracks and packets of a Matroska file that libavformat writes, as recorders of Azure Kinect and Femto have them. */

extern "C" {
#include <libavformat/avformat.h>
}

#include <cstdint>
#include <string>

namespace recorder_test {

/** \brief Times in milliseconds. \param fourcc 0: that of the codec */
inline AVStream* addVideoTrack(AVFormatContext* context, const char* title, unsigned fourcc, AVCodecID codec, int width,
                               int height) {
  AVStream* track = avformat_new_stream(context, nullptr);
  track->codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
  track->codecpar->codec_id = codec;
  track->codecpar->codec_tag = fourcc;
  track->codecpar->width = width;
  track->codecpar->height = height;
  track->time_base = {1, 1000};
  av_dict_set(&track->metadata, "title", title, 0);
  return track;
}

/** \returns whether it was written */
inline bool writeImage(AVFormatContext* context, const AVStream* track, int ms, std::string bytes) {
  AVPacket* packet = av_packet_alloc();
  packet->data = reinterpret_cast<std::uint8_t*>(bytes.data());
  packet->size = static_cast<int>(bytes.size());
  packet->stream_index = track->index;
  packet->pts = packet->dts = av_rescale_q(ms, {1, 1000}, track->time_base);
  packet->flags |= AV_PKT_FLAG_KEY;
  const bool written = av_write_frame(context, packet) >= 0;
  av_packet_free(&packet);
  return written;
}

}  // namespace recorder_test
