// Streams the frames of a recording, fused, again and again: the smallest server.
//   sample_stream_server RECORDING    prints a link for fuse_flow_receive, sample_stream_client and fuse_flow_viewer
#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>
#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/stream/server.h>

#include <chrono>
#include <iostream>
#include <thread>

int main(int argc, char** argv) try {
  if (argc != 2) throw std::runtime_error("usage: sample_stream_server RECORDING");
  const auto recording = fuse_flow::io::openRecording({argv[1]});

  fuse_flow::stream::ServerOptions options;
  options.port = 0;                           // one that is free
  options.encoding.step = 0.001;              // metres: points are off by half a millimetre at most
  fuse_flow::stream::Server server(options);  // for this machine alone: another address needs a token
  fuse_flow::stream::Description description;
  description.name = argv[1];
  description.cameras = recording->cameras();
  server.describe(description);
  std::cout << server.link() << std::endl;

  fuse_flow::io::LoadedFrame frame;
  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  for (std::uint64_t number = 0;; ++number) {
    recording->read(recording->frames()[number % recording->frames().size()], frame);
    fusion.fuse(frame.rig, cloud);
    fuse_flow::stream::FrameTimes times;
    times.number = number;
    server.publish(cloud, times);  // any point type of PCL; it waits for no client
    for (const std::string& line : server.takeNotices()) std::cerr << line << "\n";
    std::this_thread::sleep_for(std::chrono::milliseconds(33));
  }
} catch (const std::exception& error) {  // one line: what is wrong, and what would be right
  std::cerr << "sample_stream_server: " << error.what() << std::endl;
  return 1;
}
