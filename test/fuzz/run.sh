#!/usr/bin/env bash
# test/fuzz/run.sh BUILD RUNS [SECONDS [TARGET…]] — what ./build.sh fuzz calls after it has built: makes the seeds, and runs each fuzzer RUNS
# times, but no longer than SECONDS (0: any time). One line a target: runs, seconds, findings, peak memory. The corpus stays in
# BUILD/fuzz/corpus, so that a second call goes on from there; what was found lies in BUILD/fuzz/findings. Exits with 1 if there is a finding.
set -euo pipefail
build=$1 runs=$2 seconds=${3:-0}
targets=("${@:4}")
if [ ${#targets[@]} -eq 0 ]; then
  for program in "$build"/bin/fuse_flow_fuzz_*; do
    name=${program##*/fuse_flow_fuzz_}
    if [ "$name" != seeds ]; then targets+=("$name"); fi
  done
fi
mkdir -p "$build"/fuzz/{corpus,seeds,findings,logs}
"$build/bin/fuse_flow_fuzz_seeds" "$build/fuzz/seeds"

# What a run may take at most: a hang is a finding, too.
options=(-timeout=30 -rss_limit_mb=4096 -malloc_limit_mb=1024 -print_final_stats=1 -close_fd_mask=1 -verbosity=0)
export ASAN_OPTIONS=allocator_may_return_null=1:detect_stack_use_after_return=0 OMP_NUM_THREADS=1
status=0
printf '%-22s %10s %9s %9s %9s\n' target runs seconds findings MiB
for name in "${targets[@]}"; do
  log=$build/fuzz/logs/$name.log
  mkdir -p "$build/fuzz/corpus/$name" "$build/fuzz/findings/$name"
  began=$(date +%s)
  found=0
  # Each target has its own seeds, and none of them more than one process.
  "$build/bin/fuse_flow_fuzz_$name" -runs="$runs" -max_total_time="$seconds" "${options[@]}" \
    -artifact_prefix="$build/fuzz/findings/$name/" "$build/fuzz/corpus/$name" "$build/fuzz/seeds/$name" \
    < /dev/null > "$log" 2>&1 || found=1
  printf '%-22s %10s %9d %9d %9s\n' "$name" "$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")" \
    $(($(date +%s) - began)) "$found" "$(sed -n 's/^stat::peak_rss_mb: *//p' "$log")"
  if [ "$found" -ne 0 ]; then
    status=1
    grep -m 1 -E 'ERROR: |runtime error|what\(\)|SUMMARY' "$log" || true
  fi
done
exit $status
