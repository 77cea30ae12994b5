#!/usr/bin/env bash
# bench/emulated_network.sh RATE RANKS COMMAND…: runs COMMAND in RANKS ranks as if each were a computer of its own, joined by a switch whose links
# have RATE in each direction, as tc writes it (1gbit, 10gbit). Each rank is in a network namespace, so MPI has nothing but TCP between them; the
# cores are the ones that there are. Needs root, iproute2 and Open MPI.
#
#   sudo bench/emulated_network.sh 1gbit 2 build/bin/fuse_flow_fuse build/demo/recording -o clouds --rank-compression zstd
set -euo pipefail

if [ $# -lt 3 ]; then
  sed -n '2,6s/^# \{0,1\}//p' "$0" >&2
  exit 2
fi
rate=$1
ranks=$2
shift 2

prefix=ff$$
work=$(mktemp -d)
clean() {
  for ((r = 0; r < ranks; ++r)); do ip netns del "$prefix-$r" 2> /dev/null || true; done
  ip link del "$prefix" 2> /dev/null || true
  rm -rf "$work"
}
trap clean EXIT

ip link add "$prefix" type bridge
ip link set "$prefix" up
hosts=()
for ((r = 0; r < ranks; ++r)); do
  address=10.213.77.$((r + 1))
  ip netns add "$prefix-$r"
  ip link add "$prefix-$r" type veth peer name wire netns "$prefix-$r"
  ip link set "$prefix-$r" master "$prefix" up
  ip -n "$prefix-$r" addr add "$address/24" dev wire
  ip -n "$prefix-$r" link set wire up
  ip -n "$prefix-$r" link set lo up
  # What leaves a rank, and what the switch sends to it.
  ip netns exec "$prefix-$r" tc qdisc add dev wire root tbf rate "$rate" burst 256kb latency 50ms
  tc qdisc add dev "$prefix-$r" root tbf rate "$rate" burst 256kb latency 50ms
  hosts+=("$address:1")
done

# Instead of ssh ADDRESS COMMAND…: in the namespace of that address, under a name of its own, or MPI would take the ranks for one computer.
cat > "$work/enter" <<END
#!/usr/bin/env bash
while [[ \$1 == -* ]]; do shift; done
rank=\$((\${1##*.} - 1))
shift
exec ip netns exec "$prefix-\$rank" unshare --uts bash -c "hostname computer\$rank; cd $(printf '%q' "$PWD"); \$*"
END
chmod +x "$work/enter"

list=$(IFS=,; echo "${hosts[*]}")
# As ssh's, it is a text for a shell.
"$work/enter" 10.213.77.1 "$(printf '%q ' mpirun --allow-run-as-root --host "$list" -n "$ranks" --bind-to none --mca plm_rsh_agent "$work/enter" \
  --mca btl tcp,self --mca pml ob1 --mca btl_tcp_if_include wire --mca oob_tcp_if_include wire "$@")"
