#!/usr/bin/env bash
# compute_sanitizer.sh TESTS LOGS [PROCESSES [FILTER]]: the GPU test binary TESTS, or those of its tests that the GoogleTest filter
# lets through, under each tool of compute-sanitizer, a process a test: a tool that hangs, or that makes an error of its own, then
# spoils one test. Few processes at a time, by default 3 for each GPU: processes that share a GPU wait for each other, and with ten a test
# takes ten times as long. Leaves a log a test in LOGS; tests with a log are not run again.
set -euo pipefail
tests=$(realpath "$1")
mkdir -p "$2"
cd "$2"
gpus=$(nvidia-smi -L | wc -l)
export tests gpus FUSE_FLOW_TEST_SHORT=1

check() {  # check TOOL TEST
  local log=$1.${2//\//_}.log options=() result=0
  if [ -e "$log" ]; then return; fi
  # One test runs out of memory, which memcheck takes for a mistake.
  if [ "$1" = memcheck ]; then options=(--report-api-errors no); fi
  if [ "$1" = racecheck ]; then export FUSE_FLOW_TEST_WARM=1; fi
  for _ in 1 2 3; do
    result=0
    CUDA_VISIBLE_DEVICES=$((${slot:-0} % gpus)) timeout 300 compute-sanitizer --tool "$1" "${options[@]}" --error-exitcode 9 \
      "$tests" --gtest_brief=1 --gtest_filter="$2" > "$log.part" 2>&1 || result=$?
    # Of several threads that launch at once racecheck at times loses a launch, and fails by that.
    if ! grep -q "Internal Sanitizer Error" "$log.part"; then break; fi
  done
  unset FUSE_FLOW_TEST_WARM
  if grep -q "before first instrumented API call" "$log.part"; then result="needs no GPU"; fi
  echo "result: $result" >> "$log.part"
  mv "$log.part" "$log"
}
export -f check

names=$("$tests" --gtest_filter="${4:-*}" --gtest_list_tests | awk '/^[^ ]/ {suite = $1} /^ / {print suite $1}' | grep '\.')
for tool in memcheck initcheck synccheck racecheck; do
  for name in $names; do
    # Alone: no other process would have memory meanwhile.
    if [[ $name != GpuErrors.RunningOut* ]]; then echo "$tool $name"; fi
  done
done | xargs -P $((${3:-3} * gpus)) --process-slot-var=slot -L 1 bash -c 'check "$@"' check
for tool in memcheck initcheck synccheck racecheck; do
  for name in $names; do check "$tool" "$name"; done  # what is left
  echo "$tool: $(grep -l '^result: 0' "$tool".*.log | wc -l) tests clean, $(grep -l '^result: needs' "$tool".*.log | wc -l) need no GPU"
done
grep -LE '^result: (0|needs)' ./*.log || true  # and what is not clean
