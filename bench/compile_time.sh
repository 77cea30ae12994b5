#!/usr/bin/env bash
# bench/compile_time.sh [COMPILER]: what the smallest program that fuses a frame takes to compile, beside the smallest one that thins a
# cloud with pcl::VoxelGrid. In turns; the median of five, of processor time, which other programs disturb least.
set -euo pipefail
cd "$(dirname "$0")/.."
compiler=${1:-c++}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cat > "$work/fuse.cpp" << 'PROGRAM'
#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>
int main() {
  fuse_flow::RigFrame frame;
  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  fusion.fuse(frame, cloud);
}
PROGRAM
cat > "$work/voxel_grid.cpp" << 'PROGRAM'
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
int main() {
  pcl::VoxelGrid<pcl::PointXYZRGB> grid;
  const pcl::PointCloud<pcl::PointXYZRGB>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZRGB>);
  grid.setInputCloud(cloud);
  grid.filter(*cloud);
}
PROGRAM
cat > "$work/voxel_grid_own.cpp" << 'PROGRAM'
#define PCL_NO_PRECOMPILE
#include "voxel_grid.cpp"
PROGRAM
echo '#include <pcl/point_types.h>' > "$work/parse_pcl.cpp"
echo '#include <fuse_flow/fuse_flow.h>' > "$work/parse_fuse.cpp"

includes=(-Iinclude -Iimpl -Igpu)
for folder in /usr/include/pcl-* /usr/include/eigen3; do includes+=(-isystem "$folder"); done
flags=(-std=c++17 -DNDEBUG -fno-math-errno -fno-trapping-math -ffp-contract=off "${includes[@]}")

# seconds NAME OPTION…: of the processor, appended to the name's list
seconds() {
  local name=$1 source=$2
  shift 2
  local TIMEFORMAT='%U %S'
  { time "$compiler" "${flags[@]}" "$@" -c "$work/$source.cpp" -o "$work/$source.o" 2>&1; } 2>&1 |
    awk 'END {printf "%.2f\n", $1 + $2}' >> "$work/$name.times"
}

names=("pcl/point_types.h, parsed" "fuse_flow.h, parsed" "VoxelGrid, of PCL's library" "VoxelGrid, compiled" "fuse, -O0" "fuse, -O2" "fuse, -O3"
       "fuse, with FuseFlow::compiled, -O3")
for _ in 1 2 3 4 5; do
  seconds 0 parse_pcl -fsyntax-only
  seconds 1 parse_fuse -fsyntax-only
  seconds 2 voxel_grid -O3
  seconds 3 voxel_grid_own -O3
  seconds 4 fuse -O0
  seconds 5 fuse -O2
  seconds 6 fuse -O3
  seconds 7 fuse -O3 -DFUSE_FLOW_PRECOMPILED
done
echo "| $("$compiler" --version | head -1) | s |"
echo "|---|---|"
for k in "${!names[@]}"; do echo "| ${names[$k]} | $(sort -n "$work/$k.times" | sed -n 3p) |"; done
