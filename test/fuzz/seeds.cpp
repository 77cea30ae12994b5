#include "seeds.h"

namespace fuse_flow_fuzz {

Seeds makeSeeds() {
  Seeds seeds;
  addImageSeeds(seeds);
  addCloudSeeds(seeds);
  addCalibrationSeeds(seeds);
  addFolderSeeds(seeds);
  addRecorderSeeds(seeds);
  addStreamSeeds(seeds);
  addRankSeeds(seeds);
  addCommandLineSeeds(seeds);
  addStructuredSeeds(seeds);
  return seeds;
}

}  // namespace fuse_flow_fuzz
