#!/usr/bin/env bash
# Configures and builds one preset, incrementally: build.sh [PRESET] [TARGET...]. The output is quiet unless something fails.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift || true
[ -f "build/$preset/build.ninja" ] || cmake --preset "$preset" -Wno-dev >&2
# A compiler needs up to 1.5 GB: use no more jobs than the memory allows, nor than there are processors.
memory_jobs=$(awk '/MemAvailable/ { print int($2 / 1500000) + 1 }' /proc/meminfo)
jobs=$(nproc)
[ "$memory_jobs" -lt "$jobs" ] && jobs=$memory_jobs
cmake --build "build/$preset" -j "$jobs" ${1:+--target "$@"} >&2
