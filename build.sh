#!/usr/bin/env bash
# ./build.sh demo | test | bench | format   — see the README. Installs missing distribution packages, builds, runs.
set -euo pipefail
cd "$(dirname "$0")"

packages=(build-essential cmake ninja-build ccache clang-format
          libpcl-dev libeigen3-dev libflann-dev libvtk9-dev libpng-dev libopenmpi-dev libtbb-dev
          libcli11-dev nlohmann-json3-dev libgtest-dev libbenchmark-dev
          xvfb xauth libgl1-mesa-dri)
optional=(libthrust-dev)  # for the GPU classes; installed where the distribution has it

fail() { echo "build.sh: $*" >&2; exit 1; }

install_missing() {
  command -v dpkg-query > /dev/null || fail "this script installs with apt; elsewhere see 'Requirements' in the README"
  local missing=() package
  for package in "${packages[@]}"; do
    dpkg-query -W -f '${Status}' "$package" 2> /dev/null | grep -q "ok installed" || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  local root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo > /dev/null || fail "needs root or sudo to install: ${missing[*]}"
    root=(sudo)
  fi
  echo "Installing ${missing[*]}"
  "${root[@]}" apt-get update -q
  for package in "${optional[@]}"; do
    if apt-cache show "$package" > /dev/null 2>&1; then missing+=("$package"); fi
  done
  "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}"
}

build() {  # build PRESET [TARGET…]
  local preset=$1
  shift
  cmake --preset "$preset" > /dev/null || cmake --preset "$preset"
  if [ $# -gt 0 ]; then cmake --build --preset "$preset" --target "$@"; else cmake --build --preset "$preset"; fi
}

with_display() { if [ -n "${DISPLAY:-}" ]; then "$@"; else xvfb-run -a -s "-screen 0 1600x900x24" "$@"; fi; }

demo() {
  install_missing
  build release fuse_flow_fuse fuse_flow_evaluate fuse_flow_make_demo fuse_flow_picture
  local out=build/demo bin=build/bin
  mkdir -p "$out"
  [ -e "$out/recording/rig.json" ] || "$bin/fuse_flow_make_demo" "$out/recording"
  local recording=$out/recording
  "$bin/fuse_flow_fuse" "$recording" -o "$out/concatenated" --method concatenate --report "$out/concatenated.json"
  "$bin/fuse_flow_fuse" "$recording" -o "$out/voxel_grid" --method voxel_grid --report "$out/voxel_grid.json"
  "$bin/fuse_flow_fuse" "$recording" -o "$out/fused" --report "$out/report.json"
  with_display "$bin/fuse_flow_picture" "$out/concatenated/000003.ply" "$out/fused/000003.ply" \
    -o "$out/fused_beside_concatenated.png" --from 2.6 1.5 1.9 --at -0.25 -0.15 0.35 --zoom 1.25 --point-size 4
  echo
  "$bin/fuse_flow_evaluate" "$recording" "$out/concatenated/000000.ply" "$out/voxel_grid/000000.ply" "$out/fused/000000.ply"
  echo
  echo "Fused clouds:   $PWD/$out/fused/000000.ply and the frames after it"
  echo "Picture:        $PWD/$out/fused_beside_concatenated.png (left: concatenated, right: fused)"
  echo "Report:         $PWD/$out/report.json"
}

run_tests() {
  install_missing
  build release
  ctest --preset release -j 2
}

bench() {
  install_missing
  build release fuse_flow_bench
  build/bin/fuse_flow_bench "$@"
}

format() {
  command -v clang-format > /dev/null || install_missing
  find include impl gpu apps bench test \( -name '*.h' -o -name '*.hpp' -o -name '*.cpp' -o -name '*.cu' \) -print0 |
    xargs -0 clang-format "$@"
}

case "${1:-}" in
demo) demo ;;
test) run_tests ;;
bench) shift; bench "$@" ;;
check-format) format --dry-run -Werror ;;
format) format -i ;;
*) echo "usage: ./build.sh demo | test | bench | check-format | format" >&2; exit 2 ;;
esac
