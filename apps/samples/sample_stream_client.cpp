// Receives clouds and makes PCL's of them: the smallest client.
//   sample_stream_client LINK [FRAMES]    the link that fuse_flow_serve or sample_stream_server has printed
#include <fuse_flow/point_types.h>
#include <fuse_flow/stream/client.h>

#include <pcl/io/pcd_io.h>

#include <chrono>
#include <cstdlib>
#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 3) throw std::runtime_error("usage: sample_stream_client LINK [FRAMES]");
  const long frames = argc == 3 ? std::atol(argv[2]) : 10;

  fuse_flow::stream::ClientOptions options;
  options.wishes.points = 200000;  // a frame at most: even samples of the surface
  fuse_flow::stream::Client client(argv[1], options);

  fuse_flow::stream::StreamedCloud streamed;
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  for (long received = 0; received < frames;) {
    const bool any = client.pull(streamed, std::chrono::seconds(1));  // the newest; old ones are dropped
    for (const std::string& line : client.takeNotices()) std::cerr << line << "\n";
    if (client.status().ended) throw std::runtime_error(client.status().error);
    if (!any) continue;
    fuse_flow::stream::toPointCloud(streamed, cloud);
    std::cout << "frame " << streamed.times.number << ": " << cloud.size() << " of " << streamed.points_of_frame
              << " points" << std::endl;
    if (++received == frames) pcl::io::savePCDFileBinary("streamed.pcd", cloud);
  }
  return 0;
} catch (const std::exception& error) {  // one line: what is wrong, and what would be right
  std::cerr << "sample_stream_client: " << error.what() << std::endl;
  return 1;
}
