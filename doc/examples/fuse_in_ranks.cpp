// A frame of three cameras over the processes that mpirun starts: the lines of doc/guide/ranks.md. mpirun -n 2 fuse_in_ranks
#include "scene.h"

#include <fuse_flow/distributed/fuse_flow.h>
#include <fuse_flow/distributed/mpi_communicator.h>
#include <fuse_flow/point_types.h>

#include <iostream>

bool fuseInRanks() {
  fuse_flow::distributed::MpiCommunicator ranks;
  const auto rank = static_cast<std::size_t>(ranks.rank()), rank_count = static_cast<std::size_t>(ranks.size());
  fuse_flow::RigFrame frame;
  frame.cameras = exampleCameras();
  frame.views.resize(frame.cameras.size());
  std::vector<std::vector<std::uint16_t>> buffers(frame.cameras.size());
  for (std::size_t i = rank; i < buffers.size(); i += rank_count) {  // the cameras of this rank
    buffers[i] = exampleDepth(frame.cameras[i]);
    if (!buffers[i].empty()) frame.views[i].depth16 = {buffers[i].data(), 640, 480};
  }
  pcl::PointCloud<fuse_flow::PointFused> part, cloud;
  fuse_flow::distributed::FuseFlow<fuse_flow::PointFused> fusion(ranks);
  fusion.fuse(frame, part);       // the points of this rank's cells
  fusion.gather(part, cloud, 0);  // at rank 0: all points, as one process gives them
  if (rank > 0) return cloud.empty();
  std::cout << cloud.size() << " points, " << part.size() << " of them fused here\n";
  return onBoardOrWall(cloud);
}

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &provided);
  const bool good = fuseInRanks();
  MPI_Finalize();
  return good ? 0 : 1;
}
