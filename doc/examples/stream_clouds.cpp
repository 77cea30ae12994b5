// A server and a client of its stream, in one program.
#include <fuse_flow/point_types.h>
#include <fuse_flow/stream/client.h>
#include <fuse_flow/stream/server.h>

#include <chrono>
#include <iostream>

int main() {
  pcl::PointCloud<fuse_flow::PointFused> cloud;  // any point type of PCL
  for (int i = 0; i < 1000; ++i) {
    fuse_flow::PointFused point;
    point.x = 0.01f * static_cast<float>(i);
    point.r = 200;
    cloud.push_back(point);
  }

  fuse_flow::stream::ServerOptions options;
  options.port = 0;  // one that is free
  fuse_flow::stream::Server server(options);
  fuse_flow::stream::Client client(server.link());

  pcl::PointCloud<fuse_flow::PointFused> received;
  for (int attempt = 0; attempt < 100 && received.empty(); ++attempt) {
    server.publish(cloud, {});  // waits for nobody
    fuse_flow::stream::StreamedCloud streamed;
    if (client.pull(streamed, std::chrono::milliseconds(100))) fuse_flow::stream::toPointCloud(streamed, received);
  }
  std::cout << received.size() << " points" << std::endl;
  return received.size() == cloud.size() ? 0 : 1;
}
