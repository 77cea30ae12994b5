#include "../seeds.h"

namespace fuse_flow_fuzz {

void addCommandLineSeeds(Seeds& seeds) {
  seeds["command_line"] = {
      "recording\n--views\n0:40:5\n--slide\n2\n--depth-scale\n0.001\n--threads=4",
      "left.mkv\nright.mkv\n--method\nvoxel_grid\n--leaf-size\n0.01\n--device\ncpu",
      "recording\n--published\n--crop-box\n-1\n-1\n0\n1\n1\n2\n--tau\n0.3\n--confidence-form=given",
      "recording\n--pose-convention\nopengl\n--bilateral\ntrue\n--max-views\n8\n--stereo-levels\n3\n--no-stereo",
      "--help"};
  seeds["config_file"] = {"# options\nthreads = 2\ntau = 0.3\ncrop-box = [-1, -1, 0, 1, 1, 2]\npublished = true\n",
                          "views = \"0,60,120\"\nmethod = 'fuse_flow'\n; a comment\nconfidence-form = "
                          "slope_compensated\n[section]\nsigma = 0.01\n",
                          "cell-size=0.05\nmin-cell-size=0.01\nstereo-sources=4\n"};
}

}  // namespace fuse_flow_fuzz
