#!/usr/bin/env bash
# build.sh HEADERS OUT: builds the module without CMake into OUT/fuse_flow, for a machine that has a GPU, nvcc, Python with pybind11, and the
# headers of Eigen, PCL and Boost in HEADERS (as in /usr/include), but none of their libraries.
set -euo pipefail
cd "$(dirname "$0")/../../.."
headers=$1 out=$2
python=apps/python
mkdir -p "$out/fuse_flow" "$out/objects"
python3 $python/docstrings.py "$out/docstrings.inc" include/fuse_flow/*.h include/fuse_flow/*/*.h apps/recordings/include/fuse_flow/recordings/*.h
read -ra includes <<< "$(python3 -m pybind11 --includes)"
includes+=(-Iapps -I"$python" -Iapps/recordings/include -Iinclude -Iimpl -Igpu -I"$out" -I"$headers" -I"$headers/eigen3" -I"$(echo "$headers"/pcl-*)")
flags=(-std=c++17 -O3 -DNDEBUG -DBOOST_ALL_NO_LIB -DPCL_NO_PRECOMPILE)
exact=-fno-math-errno,-fno-trapping-math,-ffp-contract=off
pids=()
for source in test/python/gpu/module.cpp $python/{errors,docstrings,cameras,images,frames,clouds}.cpp $python/calibration/poses.cpp \
  $python/fusion/{in_flight,statistics,parameters,host_fusion,fuse_flow}.cpp $python/gpu/device_{clouds,images}.cpp \
  apps/input_checks/depth_in_range.cpp; do
  g++ "${flags[@]}" -fPIC -fopenmp -fvisibility=hidden ${exact//,/ } "${includes[@]}" -c "$source" -o "$out/objects/$(basename "$source").o" &
  pids+=($!)
done
nvcc -w "${flags[@]}" -arch=native -fmad=false -Xcompiler=-fPIC,-fvisibility=hidden,$exact "${includes[@]}" -c $python/gpu/gpu_fusion.cu \
  -o "$out/objects/gpu_fusion.o" &
pids+=($!)
for pid in "${pids[@]}"; do wait "$pid"; done
suffix=$(python3 -c "import sysconfig; print(sysconfig.get_config_var('EXT_SUFFIX'))")
nvcc -shared -Xcompiler=-fopenmp "$out"/objects/*.cpp.o "$out/objects/gpu_fusion.o" -o "$out/fuse_flow/_fuse_flow$suffix"
cp $python/fuse_flow/* "$out/fuse_flow/"
