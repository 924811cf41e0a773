#!/bin/sh
# A coordinator and N workers on this machine, on a free loopback port, until interrupted.
# Usage: deploy/local-cluster.sh [WORKERS] [THREADS-EACH]    LODESTAR_BIN: folder of the programs; LODESTAR_STORE: folder to use, and find again
set -eu
workers=${1:-2}
threads=${2:-1}
bin=${LODESTAR_BIN:-$(dirname "$0")/../build/release/bin}
for program in lodestar-coordinator lodestar-worker; do
  [ -x "$bin/$program" ] || { echo "no $program in $bin: build it with scripts/build.sh, or name its folder with LODESTAR_BIN" >&2; exit 1; }
done
folder=${LODESTAR_STORE:-$(mktemp -d "${TMPDIR:-/tmp}/lodestar.XXXXXX")}
mkdir -p "$folder"
rm -f "$folder/port"
pids=
stop() {
  # Workers first: what they have at hand is still delivered.
  for pid in $pids; do kill "$pid" 2>/dev/null || true; done
  for pid in $pids; do wait "$pid" 2>/dev/null || true; done
  kill "$coordinator" 2>/dev/null || true
  wait "$coordinator" 2>/dev/null || true
}
"$bin/lodestar-coordinator" --listen 127.0.0.1:0 --store "$folder/store" --port-file "$folder/port" >/dev/null 2>"$folder/coordinator.log" &
coordinator=$!
trap stop EXIT
trap 'exit 0' INT TERM
while [ ! -e "$folder/port" ]; do
  kill -0 "$coordinator" 2>/dev/null || { cat "$folder/coordinator.log" >&2; exit 1; }
  sleep 0.05
done
farm=127.0.0.1:$(cat "$folder/port")
i=0
while [ "$i" -lt "$workers" ]; do
  i=$((i + 1))
  "$bin/lodestar-worker" --coordinator "$farm" --threads "$threads" --cache "$folder/cache" --name "local-$i" 2>"$folder/worker-$i.log" &
  pids="$pids $!"
done
echo "farm: $farm   logs and store: $folder"
echo "  export LODESTAR_FARM=$farm; $bin/lodestar submit scene.pbrt --watch"
wait "$coordinator"
