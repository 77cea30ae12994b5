#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace fuse_flow_fuzz {

/** \brief Small inputs that a target accepts, from which mutations begin, by the target's name. */
using Seeds = std::map<std::string, std::vector<std::string>>;

/** \brief Of all targets. Files are made by the project's writers, and by those of its tests. */
Seeds makeSeeds();

// One for each source in seeds/.
void addImageSeeds(Seeds& seeds);
void addCloudSeeds(Seeds& seeds);
void addCalibrationSeeds(Seeds& seeds);
void addFolderSeeds(Seeds& seeds);
void addRecorderSeeds(Seeds& seeds);
void addRankSeeds(Seeds& seeds);
void addStreamSeeds(Seeds& seeds);
void addCommandLineSeeds(Seeds& seeds);
void addStructuredSeeds(Seeds& seeds);

}  // namespace fuse_flow_fuzz
