#!/usr/bin/env bash
# documented_commands.sh SOURCE BINARY PAGE     runs every command of a page's sh blocks, in the order printed, from what
#                                               `./build.sh demo` leaves: its programs, and its recording, here in small
# documented_commands.sh SOURCE BINARY --wrong  shows that commands which do not work are found
# Needs a display, and xdotool, which ends what opens a window with the key q.
set -euo pipefail
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1  # in a container
source=$1 binary=$2 page=$3
[[ $page == /* || $page == --wrong ]] || page=$PWD/$page
work=$(mktemp -d)
servers=()
end() {
  local server
  for server in ${servers[@]+"${servers[@]}"}; do kill "$server" 2> /dev/null || true; done
  wait
  rm -rf "$work"
}
trap end EXIT

fail() { echo "$(basename "$page"): $1" >&2; exit 1; }

# The lines of the sh blocks, without comments.
commands() {
  awk '/^```/ {inside = ($0 == "```sh"); next} inside' "$1" | sed -E 's/(^| +)#.*//; s/ +$//' | sed '/^$/d'
}

# The rig.json that a page shows: nothing but the images must be missing.
check_json() {
  awk '/^```/ {inside = ($0 == "```json"); next} inside' "$page" > "$work/rig.json"
  if [ ! -s "$work/rig.json" ]; then return; fi
  local said
  said=$(build/bin/fuse_flow_fuse "$work/rig.json" -o none.ply 2>&1) && fail "its rig.json needs no images"
  [[ $said == *"there are no depth images"* && $said != *warning* ]] || fail "its rig.json is wrong: $said"
}

# Programs that a reader has built up to this line: those of the demo, a script that CMake copies, and those that the page has built since.
available=" $(sed -n '/^demo()/,/^}/s/^  build_demo //p' "$source/build.sh") fuse_flow_ranks "

# cmake --build build --target …: not run, since what runs this test has built them all. The targets must be there.
build_targets() {
  local target known
  known=$(cmake --build "$binary" --target help)
  for target in "$@"; do
    grep -qE "^(apps/)?$target: " <<< "$known" || fail "there is no target $target"
    case $target in
    tools) available+=" $(basename -s .cpp "$source"/apps/tools/*.cpp | tr '\n' ' ') " ;;
    samples) available+=" $(basename -s .cpp "$source"/apps/samples/*.cpp | tr '\n' ' ') fuse_flow_export " ;;
    *) available+=" $target " ;;
    esac
  done
}

# Presses q until the program has ended; it must have had a window.
run_with_window() {
  local seen='' window pid status=0
  timeout 120 bash -c "exec $1" &
  pid=$!
  while kill -0 $pid 2> /dev/null; do
    for window in $(xdotool search --onlyvisible --name FUSE-Flow 2> /dev/null); do
      seen=yes
      xdotool key --window "$window" q 2> /dev/null || true  # it may be gone by now
    done
    sleep 0.2
  done
  wait $pid || status=$?
  # VTK 9.1 of Ubuntu 22.04 crashes when a window of PCL 1.12 is closed (PCL's issue 6290).
  if [ $status -eq 139 ] && [ -n "$seen" ] && [[ $1 == *sample_visualize* ]] && ls /usr/lib/*/libpcl_visualization.so.1.12 > /dev/null 2>&1; then
    echo "crashed when its window was closed, as PCL 1.12 does with VTK 9.1: $1"
    return 0
  fi
  [ $status -eq 0 ] || return $status
  [ -n "$seen" ] || fail "opens no window: $1"
}

# Goes on running, for the commands that follow; it must have printed a link.
run_server() {
  bash -c "exec $1" > "$work/server.log" 2>&1 &
  servers+=($!)
  for _ in $(seq 1 300); do
    if grep -q '^https\?://' "$work/server.log"; then return 0; fi
    kill -0 "${servers[-1]}" 2> /dev/null || break
    sleep 0.2
  done
  cat "$work/server.log" >&2
  return 1
}

# With the Python that the module was built for. What would open a window draws none.
run_python() {
  local python
  python=$(sed -n 's/^FUSE_FLOW_PYTHON_EXECUTABLE:[A-Z]*=//p' "$binary/CMakeCache.txt")
  echo "python3 $1"
  ln -sfn "$binary/python" build/python
  ln -sfn "$source/apps" apps
  MPLBACKEND=Agg PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=build/python bash -c "$python $1"
}

run() {
  local command=$1 program word
  # What a reader has to put something in the place of works for nobody as it is printed.
  for word in $command; do
    if [[ $word =~ ^[A-Z0-9_]{3,}$ ]]; then fail "has a placeholder, $word: $command"; fi
  done
  case $command in
  ./build.sh\ *)  # installs packages, and takes minutes
    grep -q "^${command#./build.sh })" "$source/build.sh" || fail "build.sh does not know: $command"
    if [ "$command" = "./build.sh python" ]; then available+=" fuse_flow_python "; fi
    echo "not run: $command"
    return ;;
  cmake\ --build\ build\ --target\ *)
    # shellcheck disable=SC2086  # one word a target
    build_targets ${command#cmake --build build --target }
    echo "not run: $command"
    return ;;
  cmake\ --install\ build*)  # test/consumer does
    echo "not run: $command"
    return ;;
  PYTHONPATH=build/python\ python3\ apps/python/examples/*)
    [[ $available == *" fuse_flow_python "* ]] || fail "nothing before it has built fuse_flow_python: $command"
    run_python "${command#* python3 }" || fail "does not work: $command"
    return ;;
  build/bin/* | mpirun\ --oversubscribe\ -n\ 2\ build/bin/*) ;;
  diff\ *)  # of files that the commands before it have written
    echo "$command"
    bash -c "$command" || fail "finds a difference: $command"
    return ;;
  *) fail "is no kind of command that is known here: $command" ;;
  esac
  program=${command#*build/bin/}
  program=${program%% *}
  [[ $available == *" $program "* ]] || fail "nothing before it has built $program: $command"
  echo "$command"
  case $command in
  build/bin/fuse_flow_serve\ *) run_server "$command" || fail "prints no link: $command" ;;
  build/bin/fuse_flow_viewer*\ --offscreen*) bash -c "$command" || fail "does not work: $command" ;;
  build/bin/fuse_flow_live*\ --no-window*) bash -c "$command" || fail "does not work: $command" ;;
  build/bin/fuse_flow_live\ * | build/bin/fuse_flow_viewer\ * | build/bin/sample_visualize\ *) run_with_window "$command" || fail "does not work: $command" ;;
  build/bin/fuse_flow_simulate\ *) bash -c "$command --scale 0.15" || fail "does not work: $command" ;;  # in small, too
  *) bash -c "$command" || fail "does not work: $command" ;;
  esac
}

if [ "$page" = --wrong ]; then
  expect_failure() {  # expect_failure TEXT LINE…: the page of these lines must fail, and say the text
    printf '%s\n' '```sh' "${@:2}" '```' > "$work/page.md"
    if said=$(bash "${BASH_SOURCE[0]}" "$source" "$binary" "$work/page.md" 2>&1); then
      echo "is taken for right: ${*:2}" >&2
      exit 1
    fi
    [[ $said == *"$1"* ]] || { echo "'$said' does not say '$1'" >&2; exit 1; }
  }
  expect_failure "does not work" "build/bin/fuse_flow_fuse build/demo/recording -o clouds --no-such-option"
  expect_failure "does not work" "build/bin/fuse_flow_evaluate build/demo/recording clouds/000000.ply  # nobody has made it"
  expect_failure "a placeholder, RECORDING" "build/bin/fuse_flow_fuse RECORDING -o clouds"
  expect_failure "is no kind of command" "./configure"
  expect_failure "does not know" "./build.sh everything"
  expect_failure "there is no target nothing" "cmake --build build --target nothing"
  expect_failure "nothing before it has built sample_live" "build/bin/sample_live build/demo/pcd/*"
  expect_failure "no commands"
  exit 0
fi

mapfile -t lines < <(commands "$page")
[ ${#lines[@]} -gt 0 ] || fail "has no commands"
mkdir -p "$work/build/demo"
ln -s "$binary/bin" "$work/build/bin"
cd "$work"
build/bin/fuse_flow_simulate --scene person --rig ring-4 --sensor structured_light --frames 3 --fps 5 --position-error 2 \
  --rotation-error 0.1 --scale 0.25 -o build/demo/recording
check_json
for line in "${lines[@]}"; do run "$line"; done
