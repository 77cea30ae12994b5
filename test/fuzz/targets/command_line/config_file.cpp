#include "../../scratch.h"
#include "command_lines.h"

/** \brief A file of options, as --config takes it. */
FUSE_FLOW_FUZZ_TARGET(config_file, 4 << 20, 1024, 100) {
  fuse_flow_fuzz::parseCommandLine({"recording", "--config", fuse_flow_fuzz::scratchFile("options.toml", input)});
}
