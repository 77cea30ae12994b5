#include "viewer/streamed_frames.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace fuse_flow::viewing {
namespace {

/** \brief Its cameras without images. */
void place(const std::vector<Camera>& cameras, io::LoadedFrame& out) {
  out.rig = {};
  out.rig.cameras = cameras;
  out.rig.views.resize(cameras.size());
  out.images.assign(cameras.size(), {});
  out.damaged.clear();
  out.ended.clear();
}

FinishedCloud pointsOf(const stream::StreamedCloud& streamed) {
  auto cloud = std::make_shared<pcl::PointCloud<PointFused>>();
  stream::toPointCloud(streamed, *cloud);
  if (streamed.colors.empty())
    for (PointFused& point : *cloud) point.r = point.g = point.b = 160;  // black could not be seen
  return {cloud, !streamed.confidence.empty(), !streamed.view_counts.empty()};
}

/** \brief What the library says of a link or a file is what a user has to know. */
template <typename Make>
auto orInputError(const Make& make) -> decltype(make()) {
  try {
    return make();
  } catch (const std::invalid_argument& error) {
    throw io::InputError(error.what());
  } catch (const std::runtime_error& error) {
    throw io::InputError(error.what());
  }
}

double secondsNow() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

StreamedFrames::StreamedFrames(const std::string& link, const stream::ClientOptions& options)
    : name_(link.substr(0, link.find('?'))), client_(link, options) {}

void StreamedFrames::read(std::size_t, io::LoadedFrame& out) {
  for (const std::string& line : client_.takeNotices()) std::fprintf(stderr, "fuse_flow_viewer: %s\n", line.c_str());
  if (client_.pull(received_, std::chrono::seconds(cloud_.cloud ? 1 : 5))) {
    try {
      decoder_.decode(received_.message.data(), received_.message.size(), streamed_);
      cloud_ = pointsOf(streamed_);
    } catch (const stream::FormatError& error) {
      throw io::InputError(name_ + ": " + error.what());
    }
    const double now = secondsNow();
    arrivals_.push_back({now, received_.message.size()});
    while (arrivals_.front().first < now - 2) arrivals_.pop_front();
    std::size_t bytes = 0;
    for (const auto& arrival : arrivals_) bytes += arrival.second;
    const double seconds = std::max(now - arrivals_.front().first, 1e-3);
    const double frames = static_cast<double>(arrivals_.size() - 1);
    char line[160];
    std::snprintf(line, sizeof line, "stream: %zu of %u points, %.1f frames/s, %.1f Mbit/s", streamed_.size(),
                  streamed_.points_of_frame, frames / seconds,
                  8e-6 * static_cast<double>(bytes - arrivals_.front().second) / seconds);
    lines_ = {line};
    const std::int64_t since = streamed_.times.captured != 0 ? streamed_.times.captured : streamed_.times.encoded;
    if (since != 0) {
      std::snprintf(line, sizeof line, "%.1f ms from %s until it arrived, if both clocks agree",
                    1e-6 * static_cast<double>(received_.arrived - since),
                    streamed_.times.captured != 0 ? "the last image" : "encoding");
      lines_.push_back(line);
    }
  } else if (!cloud_.cloud) {
    const stream::ClientStatus status = client_.status();
    throw io::InputError(name_ + ": " + (status.error.empty() ? "nothing has come yet" : status.error));
  } else if (!client_.status().connected) {
    lines_ = {"stream: the connection is lost; it is looked for"};
  }
  place(received_.description->cameras, out);
  out.rig.stamp = static_cast<std::uint64_t>(std::max<std::int64_t>(streamed_.times.captured, 0) / 1000);
}

std::vector<std::string> StreamedFrames::status() const { return lines_; }

const simulation::RayScene& StreamedFrames::truth(std::size_t) {
  throw io::InputError("nobody knows the true surfaces of a stream");
}

KeptFrames::KeptFrames(const std::string& path)
    : path_(path), reader_(orInputError([&] { return std::make_unique<stream::StreamReader>(path); })) {
  if (reader_->frames() == 0) throw io::InputError(path + ": has no frame");
}

std::optional<double> KeptFrames::framesPerSecond() const {
  const std::size_t frames = reader_->frames();
  if (frames < 2) return std::nullopt;
  const double seconds = 1e-9 * static_cast<double>(reader_->time(frames - 1) - reader_->time(0));
  if (!(seconds > 0)) return std::nullopt;
  return static_cast<double>(frames - 1) / seconds;
}

void KeptFrames::read(std::size_t frame, io::LoadedFrame& out) {
  orInputError([&] {
    reader_->read(frame, message_);
    decoder_.decode(message_.data(), message_.size(), streamed_);
  });
  cloud_ = pointsOf(streamed_);
  place(reader_->description().cameras, out);
  out.rig.stamp = static_cast<std::uint64_t>(std::max<std::int64_t>(reader_->time(frame), 0) / 1000);
}

const simulation::RayScene& KeptFrames::truth(std::size_t) {
  throw io::InputError("nobody knows the true surfaces of a stream");
}

}  // namespace fuse_flow::viewing
