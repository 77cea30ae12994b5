#!/usr/bin/env bash
# run.sh [FOLDER [FILTER]]: compiles the library's tests for ARM64 on an x86 machine with Debian 12, and runs them by qemu-user. Needs the packages
# crossbuild-essential-arm64 and qemu-user-static. The packages of ARM64, 700 MB, and the build go to FOLDER, build/arm64 unless named. FILTER is
# GoogleTest's; without it those that take minutes each are left out.
set -euo pipefail
cd "$(dirname "$0")/../.."
folder=$(realpath -m "${1:-build/arm64}")
filter=${2:--CoarseAlignment*:*Threads*:DepthCorrectionEstimation*:MultiViewStereo*:Epipolar*:HypothesisTable*:PlacedGroups*:TextureSearch*:*Extrinsic*:*Tracking*:Documentation*:Rooms*}
root=$folder/root
packages=(libpcl-dev libeigen3-dev libflann-dev libvtk9-dev libpng-dev libjpeg-dev libtiff-dev libtbb-dev libembree-dev libcli11-dev nlohmann-json3-dev
          libyaml-cpp-dev libgtest-dev libbenchmark-dev libthrust-dev libzstd-dev libssl-dev libc6-dev libstdc++-12-dev)

# Not installed: unpacked. apt knows of no package that is there, so it fetches all that they depend on.
if [ ! -e "$root/usr" ]; then
  mkdir -p "$folder"/apt/{archives/partial,state/lists/partial} "$root.part"
  touch "$folder/apt/status"
  echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main" > "$folder/apt/sources.list"
  cat > "$folder/apt/apt.conf" << END
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
Dir::State "$folder/apt/state";
Dir::State::status "$folder/apt/status";
Dir::Cache "$folder/apt";
Dir::Etc::sourcelist "$folder/apt/sources.list";
Dir::Etc::sourceparts "-";
END
  apt-get -q -c "$folder/apt/apt.conf" update
  apt-get -q -c "$folder/apt/apt.conf" install -y --no-install-recommends --download-only "${packages[@]}"
  for package in "$folder"/apt/archives/*.deb; do dpkg -x "$package" "$root.part"; done
  mv "$root.part" "$root"
fi

cmake -S . -B "$folder/build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/test/arm64/toolchain.cmake" -DFUSE_FLOW_SYSROOT="$root" \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DFUSE_FLOW_BUILD_APPS=OFF -DFUSE_FLOW_BUILD_BENCH=OFF -DFUSE_FLOW_PYTHON=OFF -DFUSE_FLOW_CUDA=OFF \
  -DFUSE_FLOW_WARNINGS_AS_ERRORS=ON > "$folder/configure.log"
cmake --build "$folder/build" --target fuse_flow_tests
qemu-aarch64-static -L "$root" "$folder/build/bin/fuse_flow_tests" --gtest_filter="$filter"
