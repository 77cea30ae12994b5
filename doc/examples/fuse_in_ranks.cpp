// A frame of three cameras over the processes that mpirun starts: the lines of doc/guide/ranks.md. mpirun -n 2 fuse_in_ranks
#include "scene.h"

#include <fuse_flow/distributed/frames_in_flight.h>
#include <fuse_flow/distributed/fuse_flow.h>
#include <fuse_flow/distributed/mpi_communicator.h>
#include <fuse_flow/point_types.h>

#include <iostream>

/** \brief A frame with the images of this rank's cameras. */
struct Part {
  fuse_flow::RigFrame frame;
  std::vector<std::vector<std::uint16_t>> buffers;

  Part(int rank, int ranks) {
    frame.cameras = exampleCameras();
    frame.views.resize(frame.cameras.size());
    buffers.resize(frame.cameras.size());
    for (auto i = static_cast<std::size_t>(rank); i < buffers.size(); i += static_cast<std::size_t>(ranks)) {
      buffers[i] = exampleDepth(frame.cameras[i]);
      if (!buffers[i].empty()) frame.views[i].depth16 = {buffers[i].data(), 640, 480};
    }
  }
};

bool fuseInRanks() {
  fuse_flow::distributed::MpiCommunicator ranks;
  const int rank = ranks.rank();
  const Part own(rank, ranks.size());
  const fuse_flow::RigFrame& frame = own.frame;
  pcl::PointCloud<fuse_flow::PointFused> part, cloud;
  fuse_flow::distributed::FuseFlow<fuse_flow::PointFused> fusion(ranks);
  fusion.fuse(frame, part);       // the points of this rank's cells
  fusion.gather(part, cloud, 0);  // at rank 0: all points, as one process gives them
  if (rank > 0) return cloud.empty();
  std::cout << cloud.size() << " points, " << part.size() << " of them fused here\n";
  return onBoardOrWall(cloud);
}

/** \brief Two frames at a time, each over messages of its own; returns whether both clouds are right. */
bool fuseTwoAtATime() {
  fuse_flow::distributed::MpiCommunicator first, second;
  const int rank = first.rank();
  const Part own(rank, first.size()), next(rank, first.size());
  const fuse_flow::RigFrame &frame = own.frame, &later = next.frame;
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  fuse_flow::distributed::FramesInFlight<fuse_flow::PointFused> fusion({&first, &second});
  fusion.setGatherAt(0);
  fusion.submit(frame);  // its images must stay until next() has returned it
  fusion.submit(later);
  fusion.next(cloud);  // of frame
  bool good = rank > 0 ? cloud.empty() : onBoardOrWall(cloud);
  fusion.next(cloud);
  return good && (rank > 0 ? cloud.empty() : onBoardOrWall(cloud));
}

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &provided);
  const bool good = fuseInRanks() && provided == MPI_THREAD_MULTIPLE && fuseTwoAtATime();
  MPI_Finalize();
  return good ? 0 : 1;
}
