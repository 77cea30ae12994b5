#pragma once

/** \file
 *  \brief Videos that libavcodec's encoders write. */

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include <cstdint>
#include <functional>
#include <string>

namespace recorder_test {

struct VideoOptions {
  AVCodecID codec{AV_CODEC_ID_MPEG4};
  AVPixelFormat format{AV_PIX_FMT_YUV420P};
  int width{64}, height{48};
  int pictures{40};
  int per_second{25};
  const char* container{nullptr};  ///< null: as the name says
  int key_every{12};
  int between{2};  ///< pictures that are stored behind those they lie before
  AVColorSpace matrix{AVCOL_SPC_UNSPECIFIED};
  AVColorRange range{AVCOL_RANGE_UNSPECIFIED};
  AVFieldOrder field_order{AV_FIELD_UNKNOWN};
  AVColorTransferCharacteristic transfer{AVCOL_TRC_UNSPECIFIED};
};

/** \brief Writes a video. \param paint fills in a picture of that number \returns false: the encoder is not there, or fails */
inline bool writeVideo(const std::string& path, const VideoOptions& options,
                       const std::function<void(int number, AVFrame& frame)>& paint) {
  AVFormatContext* context = nullptr;
  const AVCodec* codec = avcodec_find_encoder(options.codec);
  if (!codec || avformat_alloc_output_context2(&context, nullptr, options.container, path.c_str()) < 0) return false;
  AVCodecContext* encoder = avcodec_alloc_context3(codec);
  encoder->width = options.width;
  encoder->height = options.height;
  encoder->pix_fmt = options.format;
  encoder->time_base = {1, options.per_second};
  encoder->framerate = {options.per_second, 1};
  encoder->gop_size = options.key_every;
  encoder->max_b_frames = options.codec == AV_CODEC_ID_MPEG4 ? options.between : 0;
  encoder->colorspace = options.matrix;
  encoder->color_range = options.range;
  encoder->bit_rate = 4'000'000;
  encoder->thread_count = 1;
  av_opt_set(encoder->priv_data, "tune", "zerolatency", 0);  // H.264's; others do not know it
  if ((context->oformat->flags & AVFMT_GLOBALHEADER) != 0) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  bool good = avcodec_open2(encoder, codec, nullptr) >= 0;
  AVStream* track = avformat_new_stream(context, nullptr);
  track->time_base = encoder->time_base;
  avcodec_parameters_from_context(track->codecpar, encoder);
  track->codecpar->field_order = options.field_order;
  track->codecpar->color_trc = options.transfer;
  good = good && avio_open(&context->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0 &&
         avformat_write_header(context, nullptr) >= 0;
  AVFrame* frame = av_frame_alloc();
  AVPacket* packet = av_packet_alloc();
  frame->width = options.width;
  frame->height = options.height;
  frame->format = options.format;
  frame->colorspace = options.matrix;
  frame->color_range = options.range;
  for (int k = 0; good && k <= options.pictures; ++k) {
    if (k < options.pictures) {
      av_frame_unref(frame);
      frame->width = options.width;
      frame->height = options.height;
      frame->format = options.format;
      frame->colorspace = options.matrix;
      frame->color_range = options.range;
      av_frame_get_buffer(frame, 0);
      paint(k, *frame);
      frame->pts = k;
      good = avcodec_send_frame(encoder, frame) >= 0;
    } else {
      good = avcodec_send_frame(encoder, nullptr) >= 0;
    }
    while (good && avcodec_receive_packet(encoder, packet) >= 0) {
      packet->duration = 1;
      av_packet_rescale_ts(packet, encoder->time_base, track->time_base);
      packet->stream_index = track->index;
      good = av_interleaved_write_frame(context, packet) >= 0;
    }
  }
  good = good && av_write_trailer(context) >= 0;
  if (context->pb) avio_closep(&context->pb);
  av_packet_free(&packet);
  av_frame_free(&frame);
  avcodec_free_context(&encoder);
  avformat_free_context(context);
  return good;
}

/** \brief One colour everywhere: Y, U and V. */
inline void paintPlain(AVFrame& frame, std::uint8_t y, std::uint8_t u, std::uint8_t v) {
  const auto fill = [&](int plane, int width, int height, std::uint8_t value) {
    for (int row = 0; row < height; ++row)
      for (int k = 0; k < width; ++k) frame.data[plane][row * frame.linesize[plane] + k] = value;
  };
  fill(0, frame.width, frame.height, y);
  fill(1, frame.width / 2, frame.height / 2, u);
  fill(2, frame.width / 2, frame.height / 2, v);
}

}  // namespace recorder_test
