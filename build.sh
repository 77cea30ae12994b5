#!/usr/bin/env bash
# ./build.sh demo | test | python | deb | bench | tables | fuzz | mutation | screenshots | film | packages | lint | check-format | format   — see the README. Installs
# missing distribution packages, builds, runs.
set -euo pipefail
cd "$(dirname "$0")"

packages=(build-essential cmake ninja-build clang-format pkg-config
          libpcl-dev libeigen3-dev libflann-dev libvtk9-dev libpng-dev libjpeg-dev libtiff-dev libopenmpi-dev libtbb-dev libembree-dev
          libcli11-dev nlohmann-json3-dev libyaml-cpp-dev libgtest-dev libbenchmark-dev
          xvfb xauth xdotool libgl1-mesa-dri libx11-dev libgl-dev libopengl-dev
          curl ca-certificates)
# For the GPU classes, for fuse_flow_calibrate --board, for streams, for what recorders write, for depth in OpenEXR, and for clouds as Draco; installed where the distribution has them.
optional=(libthrust-dev libapriltag-dev libopencv-calib3d-dev libopencv-objdetect-dev libopencv-contrib-dev
          libssl-dev libavformat-dev libswscale-dev libavdevice-dev libbz2-dev libfastcdr-dev libsqlite3-dev liblz4-dev libzstd-dev libopenexr-dev libdraco-dev)
# What writes files for the tests of readers.
writers=(python3-rosbag python3-sensor-msgs python3-tf2-msgs ffmpeg python3-pil python3-tifffile)
# What looks at the page of fuse_flow_serve. Debian's; Ubuntu has Chromium as a snap only, whose package of that name is no browser.
browser=(nodejs chromium chromium-driver python3-selenium python3-websockets)
# The Python module, and what its tests and examples show its clouds with.
python=(python3-dev pybind11-dev python3-numpy)
python_tests=(python3-pytest python3-matplotlib python3-open3d python3-torch mypy)
analysers=(clang-tidy cppcheck shellcheck)
# The compiler of fuzzers and of CI's sanitizers; see install_clang().
clang=(clang)

fail() { echo "build.sh: $*" >&2; exit 1; }

installed() { dpkg-query -W -f '${Status}' "$1" 2> /dev/null | grep -q "ok installed"; }

# Prints the optional packages that are not here and that apt knows.
missing_optional() {
  local package
  for package in "${optional[@]}"; do
    if installed "$package"; then continue; fi
    if [ "$package" = libthrust-dev ] && [ -e /usr/local/cuda/include/cuda.h ]; then continue; fi  # CUDA has its own
    # ArUco's markers, which libopencv-objdetect-dev has from OpenCV 4.7 on.
    if [ "$package" = libopencv-contrib-dev ] &&
      dpkg --compare-versions "$(apt-cache madison libopencv-objdetect-dev | awk 'NR == 1 {print $3}')" ge 4.7; then
      continue
    fi
    # Not "show", which succeeds for names that other packages only refer to.
    if [ -n "$(apt-cache madison "$package")" ]; then echo "$package"; fi
  done
}

apt_install() {  # apt_install AS_ROOT PACKAGE…, where AS_ROOT is a command, or empty for whoever is root
  echo "Installing ${*:2}"
  # shellcheck disable=SC2086  # a command with its options
  $1 apt-get update -q &&
    $1 env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${@:2}" &&
    rm -f build/build.ninja  # so that it is configured again
}

install_missing() {  # install_missing [PACKAGE…]: the packages, and those named
  command -v dpkg-query > /dev/null || fail "this script installs with apt; elsewhere see doc/building.md"
  local missing=() package sudo=
  if [ "$(id -u)" -ne 0 ]; then sudo=sudo; fi
  for package in "${packages[@]}" "$@"; do installed "$package" || missing+=("$package"); done
  if [ ${#missing[@]} -gt 0 ]; then
    [ -z "$sudo" ] || command -v sudo > /dev/null || fail "needs root or sudo to install: ${missing[*]}"
    apt_install "$sudo" "${missing[@]}" || fail "could not install ${missing[*]}"
  fi
  # It goes on without these, and asks for no password.
  mapfile -t missing < <(missing_optional)
  if [ ${#missing[@]} -gt 0 ]; then
    apt_install "${sudo:+sudo -n}" "${missing[@]}" || echo "build.sh: goes on without ${missing[*]}" >&2
  fi
}

# What the page for browsers stands on, from npm: unpacked into build/third_party, and checked by the checksum that npm publishes
# (dist.integrity, base64 there). The build goes on without; CMake then says so, and so does not_built.
fetch_npm() {  # fetch_npm NAME VERSION SHA512
  local folder=build/third_party/$1 archive=build/third_party/$1.tgz
  if [ "$(cat "$folder/.version" 2> /dev/null)" = "$2" ]; then return; fi
  mkdir -p build/third_party
  if ! curl -fsS --connect-timeout 10 --max-time 300 --retry 2 -o "$archive" "https://registry.npmjs.org/$1/-/$1-$2.tgz"; then
    echo "build.sh: goes on without the page for browsers: $1 $2 could not be fetched from registry.npmjs.org" >&2
    return
  fi
  if ! echo "$3  $archive" | sha512sum --check --quiet -; then
    rm "$archive"
    fail "$1 $2 from registry.npmjs.org is not what it should be: another checksum"
  fi
  rm -rf "$folder"
  mkdir "$folder"
  tar -xzf "$archive" -C "$folder" --strip-components=1 --no-same-owner
  echo "$2" > "$folder/.version"
  rm "$archive"
  rm -f build/build.ninja  # so that it is configured again
}

fetch_page_packages() {
  fetch_npm three 0.180.0 a3eab2700319ae1f93b04d351aa594c5420a47500bd12f29abbcc3918390c3c1aa7d7f1bf15a022985281db8625f98feee1afc5ecb870d553afa09102502a0f7
  fetch_npm zstddec 0.3.4 dd8fcd30fe8c35da7d6f47d68630941a2c9ba20ed10b711b5122092d69df8f294ebe76ee1b291ebb8cd852e1f82112f2e7123b372b574c737709640a20dddc4a
}

configure() { cmake --preset release "$@" > /dev/null || cmake --preset release "$@"; }

build() {  # build [TARGET…]
  fetch_page_packages
  # Ninja configures again by itself when what CMake has read changes; the presets it does not know.
  if [ -e build/demo_without_cuda ]; then
    configure -DFUSE_FLOW_CUDA=AUTO
    rm build/demo_without_cuda
  elif [ ! -e build/build.ninja ] || [ CMakePresets.json -nt build/build.ninja ]; then
    configure
  fi
  if [ $# -gt 0 ]; then cmake --build --preset release --target "$@"; else cmake --build --preset release; fi
}

gpu_at_hand() { [ -e /dev/nvidiactl ] || nvidia-smi -L > /dev/null 2>&1; }

# What the demo runs. Without a GPU nothing is compiled for one, until the next build() that is not the demo's.
build_demo() {
  fetch_page_packages
  if [ ! -e build/build.ninja ]; then
    rm -f build/demo_without_cuda
    if ! gpu_at_hand; then
      configure -DFUSE_FLOW_CUDA=OFF
      touch build/demo_without_cuda
    fi
  elif [ -e build/demo_without_cuda ] && [ CMakePresets.json -nt build/build.ninja ]; then
    configure -DFUSE_FLOW_CUDA=OFF
  fi
  if [ -e build/demo_without_cuda ]; then cmake --build --preset release --target "$@"; else build "$@"; fi
}

with_display() { if [ -n "${DISPLAY:-}" ]; then "$@"; else xvfb-run -a -s "-screen 0 1600x900x24" "$@"; fi; }

# step OUTPUT INPUT… -- COMMAND…: runs the command unless it has succeeded since its inputs, or this script, last changed.
# What it prints is kept, so that a second call can print it again.
step() {
  local output=$1 log=$1.log again=
  shift
  if [ ! -e "$output" ] || [ build.sh -nt "$log" ]; then again=yes; fi
  while [ "$1" != -- ]; do
    if [ "$1" -nt "$log" ]; then again=yes; fi
    shift
  done
  shift
  if [ -n "$again" ]; then
    rm -f "$log"
    "$@" > "$log.part"
    mv "$log.part" "$log"
  fi
  cat "$log"
}

# The one place that says what the demo fuses: four structured-light cameras, calibrated to 2 mm and 0.1 degrees, around a
# person who walks through a room. The same bytes on every machine. Tests have it in small: test/simulated_recording.h.
simulate_demo() {
  rm -rf "$1"
  build/bin/fuse_flow_simulate --scene person --rig ring-4 --sensor structured_light --frames 8 --fps 5 \
    --position-error 2 --rotation-error 0.1 -o "$1"
}

fuse_demo() {  # fuse_demo RECORDING OUT METHOD
  rm -rf "$2"
  # One after the other: the methods' times are compared.
  build/bin/fuse_flow_fuse "$1" -o "$2" --method "$3" --report "$2.json" --no-overlap
}

demo() {
  echo "The demo takes five to ten minutes on two cores, the first time. Where nothing of what it installs is there, 550 MB are"
  echo "downloaded before."
  install_missing
  build_demo fuse_flow_fuse fuse_flow_evaluate fuse_flow_simulate fuse_flow_picture
  local out=build/demo bin=build/bin method
  local recording=$out/recording
  local clouds=("$out"/{concatenate,voxel_grid,fuse_flow}) logs=("$out"/{concatenate,voxel_grid,fuse_flow}.log)
  mkdir -p "$out"
  step "$recording" "$bin/fuse_flow_simulate" -- simulate_demo "$recording"
  for method in concatenate voxel_grid fuse_flow; do
    step "$out/$method" "$bin/fuse_flow_fuse" "$recording.log" -- \
      fuse_demo "$recording" "$out/$method" "$method"
  done
  step "$out/fused_beside_concatenated.png" "$bin/fuse_flow_picture" "$out/concatenate.log" "$out/fuse_flow.log" -- \
    with_display "$bin/fuse_flow_picture" "$out/concatenate/000005.ply" "$out/fuse_flow/000005.ply" \
    -o "$out/fused_beside_concatenated.png" --from 2.2 -1.3 1.9 --at -0.2 0.1 0.8 --zoom 0.62 --point-size 5
  echo
  step "$out/errors.png" "$bin/fuse_flow_evaluate" "${logs[@]}" -- \
    with_display "$bin/fuse_flow_evaluate" "$recording" "${clouds[@]}" --no-parts --error-picture "$out/errors.png"
  echo
  echo "Fused clouds:   $PWD/$out/fuse_flow/000000.ply and the frames after it"
  echo "Pictures:       $PWD/$out/fused_beside_concatenated.png (left: concatenated, right: fused)"
  echo "                $PWD/$out/errors.png (concatenated, VoxelGrid, fused: blue on the true surface, red 20 mm off)"
  echo "Report:         $PWD/$out/fuse_flow.json"
  echo "Hands and feet: $bin/fuse_flow_evaluate $recording ${clouds[*]}"
  echo
  echo "See it move:    cmake --build build --target fuse_flow_viewer && build/bin/fuse_flow_viewer $recording"
  echo "In a browser:   cmake --build build --target fuse_flow_serve && build/bin/fuse_flow_serve $recording"
  echo "The rest:       cmake --build build --target tools samples"
}

# The film of the README: two seconds of the demo's scene, concatenated left, fused right.
film() {
  install_missing
  command -v img2webp > /dev/null || fail "a film needs img2webp: apt-get install webp"
  build fuse_flow_fuse fuse_flow_simulate fuse_flow_picture
  local out=build/film frame clouds=()
  rm -rf $out
  mkdir -p $out/pictures
  build/bin/fuse_flow_simulate --scene person --rig ring-4 --sensor structured_light --frames 20 --fps 10 \
    --position-error 2 --rotation-error 0.1 -o $out/recording
  for method in concatenate fuse_flow; do
    build/bin/fuse_flow_fuse $out/recording -o $out/$method --method $method --no-quality
  done
  for frame in $(seq 0 19); do
    mapfile -t clouds < <(printf "$out/%s/%06d.ply\n" concatenate "$frame" fuse_flow "$frame")
    # Eight degrees to and fro about the subject.
    mapfile -t from < <(awk -v k="$frame" 'BEGIN {pi = atan2(0, -1); a = (-30.6 + 8 * sin(2 * pi * k / 20)) * pi / 180
                          print -0.2 + 2.544 * cos(a) "\n" 0.1 + 2.544 * sin(a)}')
    with_display build/bin/fuse_flow_picture "${clouds[@]}" -o "$(printf "$out/pictures/%06d.png" "$frame")" \
      --size 1000 440 --from "${from[@]}" 1.9 --at -0.2 0.1 0.85 --zoom 0.62 --point-size 4
  done
  img2webp -loop 0 -d 100 -lossy -q 62 -m 6 $out/pictures/*.png -o doc/images/demo.webp
}

# The pictures of doc/reference/viewer.md, of the demo's recording.
screenshots() {
  install_missing
  build fuse_flow_simulate fuse_flow_viewer
  local recording=build/demo/recording
  mkdir -p build/demo
  step "$recording" build/bin/fuse_flow_simulate -- simulate_demo "$recording"
  shot() {  # shot NAME ZOOM OPTION…
    with_display build/bin/fuse_flow_viewer "$recording" --device cpu --paused --start 5 --width 1000 --height 600 \
      --point-size 3 --from -2.3 -1.9 1.9 --at 0 0 0.9 --up 0 0 1 --zoom "$2" --press i "${@:3}" \
      --offscreen --screenshot "doc/images/viewer_$1.jpg"
    echo "doc/images/viewer_$1.jpg"
  }
  shot split 0.85 --compare concatenate --layout split --press y,t
  shot playing 0.7 --press i
  shot side_by_side 0.85 --compare voxel_grid --press y
  shot published 0.85 --compare published --color-by truth --press y
  shot confidence 0.85 --color-by confidence --press y
  shot views 0.85 --color-by views --press y
  shot camera 0.85 --color-by camera --press y
  shot truth 0.85 --compare concatenate --layout split --color-by truth --press y
  shot normal 0.85 --color-by normal --press y,n
  shot components 0.85 --press 1,2,k,y
  shot crop_box 0.6 --crop-box -1.6 -1.2 0.02 1.6 1.2 1.9 --press b,y,a,g
  shot measure 0.85 --press y,t,505:540,m,475:85,m
  shot help 0.85 --press h
}

# What was not built, by what CMake did not find.
not_built() {
  local variable what
  while read -r variable what; do
    if grep -Eq "^$variable:[A-Z]*=(.*-NOTFOUND|0|FALSE|)$" build/CMakeCache.txt; then echo "not built: $what"; fi
  done << 'END'
FUSE_FLOW_THRUST_INCLUDE_DIR the GPU classes and their tests: no Thrust
FUSE_FLOW_NVCC what runs on a GPU: no nvcc
FUSE_FLOW_APRILTAG_LIBRARY fuse_flow_calibrate --board with AprilTags: no apriltag
FUSE_FLOW_HAS_opencv fuse_flow_calibrate --board with chessboards, ArUco and ChArUco: no OpenCV, or no aruco of it
Open3D_DIR Open3D among the tables' peers: no Open3D
FUSE_FLOW_HAS_stream fuse_flow_serve and fuse_flow_receive: no Boost, OpenSSL or Zstandard
FUSE_FLOW_HAS_libav .mkv of Azure Kinect and Femto, videos, colour cameras as they run: no libavformat or libswscale
FUSE_FLOW_HAS_libavdevice USB colour cameras as they run: no libavdevice
FUSE_FLOW_HAS_bzip2 .bag compressed by bzip2: no libbz2
FUSE_FLOW_HAS_fastcdr messages of ROS 2: no libfastcdr
FUSE_FLOW_HAS_sqlite .db3 of ROS 2: no libsqlite3
FUSE_FLOW_HAS_lz4 .mcap compressed by LZ4: no liblz4
FUSE_FLOW_HAS_zstd .mcap compressed by Zstandard: no libzstd
FUSE_FLOW_HAS_openexr depth in OpenEXR: no libopenexr
FUSE_FLOW_HAS_draco clouds as Draco: no libdraco
FUSE_FLOW_PAGE the page of fuse_flow_serve: no three.js and zstddec in build/third_party
FUSE_FLOW_CHROMIUM tests of that page in a browser: no chromium
FUSE_FLOW_HAS_python the Python module: no Python 3.10 with its headers, no pybind11, or no numpy
END
}

run_tests() {
  optional+=("${writers[@]}" "${python[@]}" "${python_tests[@]}")
  if grep -q '^ID=debian' /etc/os-release; then optional+=("${browser[@]}"); else optional+=(nodejs); fi
  install_missing
  build
  ctest --preset release -j 2
  # What was tested, and what could not be here, such as on a recording that is not here.
  awk '/ tests? from .* ran\./ {tests += $2} skipped {reasons[$0]++; skipped = 0} /: Skipped$/ {skipped = 1}
       END {print tests " tests"; for (reason in reasons) print "skipped in " reasons[reason] ": " reason}' \
    build/Testing/Temporary/LastTest.log
  not_built
}

# The Python module alone, and what its examples need.
build_python() {
  install_missing "${python[@]}" python3-matplotlib
  build_demo fuse_flow_python
  echo "import fuse_flow: PYTHONPATH=$PWD/build/python $(sed -n 's/^FUSE_FLOW_PYTHON_EXECUTABLE:INTERNAL=//p' build/CMakeCache.txt)"
}

# Debian packages of the headers with the compiled libraries, of the tools, and of the Python module, in build/deb/packages. Compiled as
# the distribution compiles its packages, but for the optimisation, which is CMake's, and without CUDA, which Debian has not in main.
deb() {
  install_missing "${python[@]}" help2man dpkg-dev file
  fetch_page_packages
  local compiler linker
  compiler=$(DEB_CXXFLAGS_MAINT_STRIP="-g -O2" dpkg-buildflags --get CXXFLAGS)
  linker="$(dpkg-buildflags --get LDFLAGS) -s"
  # One source, one time: two builds of a commit have the same bytes.
  SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2> /dev/null || stat -c %Y CHANGELOG.md)}
  export SOURCE_DATE_EPOCH
  cmake --preset release -B build/deb -DCMAKE_INSTALL_PREFIX=/usr -DFUSE_FLOW_CUDA=OFF -DFUSE_FLOW_PYTHON=ON \
    -DFUSE_FLOW_BUILD_TESTS=OFF -DFUSE_FLOW_BUILD_GPU_TESTS=OFF -DFUSE_FLOW_BUILD_BENCH=OFF \
    -DCMAKE_DISABLE_FIND_PACKAGE_Open3D=ON "-DCMAKE_CXX_FLAGS=$compiler $(dpkg-buildflags --get CPPFLAGS)" \
    "-DCMAKE_EXE_LINKER_FLAGS=$linker" "-DCMAKE_MODULE_LINKER_FLAGS=$linker" > /dev/null
  local targets=(tools man_pages fuse_flow_compiled fuse_flow_recordings fuse_flow_python)
  if grep -q '^FUSE_FLOW_HAS_stream:INTERNAL=TRUE' build/deb/CMakeCache.txt; then targets+=(fuse_flow_stream); fi
  cmake --build build/deb --target "${targets[@]}"
  rm -rf build/deb/packages
  cpack --config build/deb/CPackConfig.cmake
  rm -rf build/deb/packages/_CPack_Packages
  if command -v lintian > /dev/null; then lintian build/deb/packages/*.deb; fi
  ls -l build/deb/packages/*.deb
}

bench() {
  install_missing
  build fuse_flow_bench
  # In turns, so that what else the machine does at a time falls on all alike.
  build/bin/fuse_flow_bench --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true \
    --benchmark_report_aggregates_only=true "$@"
}

tables() {
  install_missing
  build fuse_flow_tables
  # Without its first paragraph, which is about itself; its links, which begin in doc/notes, begin in doc on the page.
  sed -E '1,/^$/d; s@\]\(([a-z_]+\.md)@](notes/\1@g; s@\]\(\.\./@](@g' doc/notes/results_reading.md > build/results_reading.md
  with_display build/bin/fuse_flow_tables -o doc/results.md --reading build/results_reading.md \
    --measures doc/notes/quality_measures.md --surround doc/notes/surround.md "$@"
}

# ./build.sh fuzz [RUNS [SECONDS [TARGET…]]]: builds the fuzzers, and runs each RUNS times, but no longer than SECONDS, see test/fuzz/run.sh.
# clang, its sanitizers and libFuzzer.
install_clang() {
  # Debian's clang 14 and later have the sanitizers and libFuzzer in packages of their own; Ubuntu 22.04's has them.
  if [ -n "$(apt-cache madison libclang-rt-dev 2> /dev/null)" ]; then clang+=(libclang-rt-dev); fi
  if ! command -v clang++ > /dev/null || ! echo 'extern "C" int LLVMFuzzerTestOneInput(const char*, unsigned long) { return 0; }' |
    clang++ -x c++ - -fsanitize=fuzzer,address -o /dev/null 2> /dev/null; then
    install_missing "${clang[@]}"
  else
    install_missing
  fi
}

fuzz() {
  install_clang
  cmake --preset fuzz > /dev/null || cmake --preset fuzz
  cmake --build --preset fuzz --target fuse_flow_fuzzers
  test/fuzz/run.sh build-fuzz "${1:-100000}" "${2:-0}" "${@:3}"
}

# Which operators of the library no test notices, see doc/notes/mutation.md.
mutation() {
  install_missing
  python3 test/mutation/mutate.py build/mutation "$@"
}

# Static analysis. Clang parses what gcc cannot give it precompiled.
lint() {
  install_missing "${analysers[@]}"
  shellcheck build.sh .ci/run apps/tools/fuse_flow_ranks test/*.sh test/fuzz/*.sh test/arm64/*.sh test/gpu/*.sh test/python/gpu/*.sh bench/*.sh
  mkdir -p build/cppcheck
  cppcheck -j 2 --quiet --error-exitcode=1 --std=c++17 --language=c++ --enable=warning,performance,portability \
    '-DPOINT_CLOUD_REGISTER_POINT_STRUCT(...)=' --suppressions-list=.cppcheck --cppcheck-build-dir=build/cppcheck \
    -I include -I impl -I gpu -I apps -I apps/recordings/include apps src
  cmake --preset release -B build/lint -DFUSE_FLOW_CUDA=OFF -DFUSE_FLOW_WARNINGS_AS_ERRORS=OFF \
    -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON > /dev/null
  # The library's headers and what the tools are made of.
  run-clang-tidy -j 2 -p build/lint -quiet -extra-arg=-std=c++17 '^(?!.*/(test|python/docstrings)).*/apps/|/headers_together\.cpp$'
}

format() {
  command -v clang-format > /dev/null || install_missing
  local tool
  tool=$(command -v clang-format-14 || command -v clang-format)
  find include impl gpu distributed src apps bench test doc \( -name '*.h' -o -name '*.hpp' -o -name '*.cpp' -o -name '*.cu' \) -print0 |
    xargs -0 "$tool" "$@"
}

case "${1:-}" in
packages) install_missing; fetch_page_packages; if [ "${2:-}" = clang ]; then install_clang; fi ;;
demo) demo ;;
test) run_tests ;;
python) build_python ;;
deb) deb ;;
bench) shift; bench "$@" ;;
tables) shift; tables "$@" ;;
fuzz) shift; fuzz "$@" ;;
mutation) shift; mutation "$@" ;;
screenshots) screenshots ;;
film) film ;;
lint) lint ;;
check-format) format --dry-run -Werror ;;
format) format -i ;;
*) echo "usage: ./build.sh demo | test | python | deb | bench | tables | fuzz | mutation | screenshots | film | packages | lint | check-format | format" >&2; exit 2 ;;
esac
