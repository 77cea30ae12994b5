#!/usr/bin/env bash
# mpi_ranks.sh MPIEXEC PROGRAM: the ranks of mpi_ranks.cpp, one to five, and some of which one stops, or leaves.
set -euo pipefail
program=$2
launch=("$1")
if "$1" --version 2> /dev/null | grep -q "Open MPI\|open-mpi"; then
  # More ranks than cores; as root in containers; and no look for networks: all of them are here.
  launch+=(--oversubscribe --allow-run-as-root --mca btl self,vader --mca pml ob1)
fi
export OMPI_MCA_mpi_yield_when_idle=1

for ranks in 1 2 3 5; do
  "${launch[@]}" -n "$ranks" "$program" | tee /dev/stderr | grep -q "^$ranks ranks: the same bytes$"
done

for instead in stops leaves; do
  start=$SECONDS
  if output=$(timeout 60 "${launch[@]}" -n 3 "$program" "$instead" 2>&1); then
    echo "$output"
    echo "rank 1 $instead, and nobody noticed" >&2
    exit 1
  fi
  echo "$output"
  if [ $((SECONDS - start)) -gt 40 ]; then
    echo "rank 1 $instead, and it took $((SECONDS - start)) s to end" >&2
    exit 1
  fi
  # Who is silent is named; of who leaves, the launcher knows.
  if [ "$instead" = stops ]; then grep -q "rank 1 has not answered rank [02] for 4 s" <<< "$output"; fi
done
