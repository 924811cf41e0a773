#!/usr/bin/env bash
# Shows the farm at work: builds a release, starts a coordinator and two workers on free loopback ports, submits a scene, shows progress, and writes
# out/NAME.exr, its picture NAME.png, NAME.csv and the plot NAME-error.png. Stops everything it started, on Ctrl-C too.
#
#   scripts/demo.sh [SCENE.pbrt] [options of lodestar submit]      e.g. scripts/demo.sh scene.pbrt --spp 128 --method path
#
# Without a budget among the options it renders for a minute (LODESTAR_DEMO_TIME changes that). -o names another image. LODESTAR_BIN: folder of programs
# that are built already; then nothing is installed or built.
set -euo pipefail
here=$(pwd)
cd "$(dirname "$0")/.."
root=$(pwd)

scene=$root/scenes/door-ajar.pbrt
if [ $# -gt 0 ] && [ "${1#-}" = "$1" ]; then
  case "$1" in /*) scene=$1 ;; *) scene=$here/$1 ;; esac
  shift
fi
[ -f "$scene" ] || { echo "demo: there is no scene $scene" >&2; exit 3; }
name=$(basename "$scene" .gz)
name=$(basename "$name" .pbrt)
budget=(--time "${LODESTAR_DEMO_TIME:-60s}")
output=(-o "$root/out/$name.exr")
for option in "$@"; do
  case "$option" in
    --spp*|--time*|--error*) budget=() ;;
    -o*|--output*) output=() ;;
  esac
done

if [ -n "${LODESTAR_BIN:-}" ]; then
  bin=$(cd "$here" && cd "$LODESTAR_BIN" && pwd)
else
  scripts/setup.sh
  scripts/build.sh release lodestar lodestar-coordinator lodestar-worker
  bin=$root/build/release/bin
fi

run=$(mktemp -d "${TMPDIR:-/tmp}/lodestar-demo-XXXXXX")

# Only what was started here is ended, by its id: politely, then for good. The workers first: they hand back what they have to the coordinator.
started=()
end() {
  kill "$1" 2>/dev/null || return 0
  for _ in $(seq 100); do
    kill -0 "$1" 2>/dev/null || return 0
    sleep 0.05
  done
  kill -9 "$1" 2>/dev/null || true
}
finish() {
  local code=$? i
  trap - EXIT
  trap '' INT TERM
  for ((i = ${#started[@]} - 1; i > 0; i--)); do kill "${started[i]}" 2>/dev/null || true; done
  for ((i = ${#started[@]} - 1; i >= 0; i--)); do end "${started[i]}"; done
  if [ $code -ne 0 ] && [ $code -ne 130 ]; then
    echo "demo: failed; the last lines of the farm's logs:" >&2
    tail -n 5 "$run"/*.log >&2 || true
  fi
  rm -rf "$run"
  exit $code
}
trap finish EXIT
# lodestar itself takes a first Ctrl-C: it fetches the image so far and ends with 130, and then so does this script.
trap : INT
trap 'exit 143' TERM

# Services get a process group of their own, so that Ctrl-C reaches the client alone.
start() {
  local log=$1
  shift
  setsid "$@" >"$log" 2>&1 &
  started+=($!)
  disown  # no "Killed" from the shell
}
start "$run/coordinator.log" "$bin/lodestar-coordinator" --listen 127.0.0.1:0 --store "$run/store" --port-file "$run/port"
for _ in $(seq 100); do
  [ -s "$run/port" ] && break
  kill -0 "${started[0]}" 2>/dev/null || { echo "demo: the coordinator did not start" >&2; exit 1; }
  sleep 0.1
done
[ -s "$run/port" ] || { echo "demo: the coordinator was not ready within 10 s" >&2; exit 1; }
farm=127.0.0.1:$(cat "$run/port")

# Two workers share the machine's processors.
threads=$(( ($(nproc) + 1) / 2 ))
for i in 1 2; do
  start "$run/worker-$i.log" "$bin/lodestar-worker" --coordinator "$farm" --threads "$threads" --cache "$run/cache-$i"
done
echo "demo: coordinator on $farm, 2 workers of $threads threads" >&2

cd "$here"  # what the options name is relative to it
code=0
"$bin/lodestar" submit "$scene" --farm "$farm" ${budget[@]+"${budget[@]}"} --watch ${output[@]+"${output[@]}"} "$@" || code=$?
exit $code
