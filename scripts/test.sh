#!/usr/bin/env bash
# Sets up, builds and runs all tests; ends with ctest's own summary. Arguments go to ctest, e.g. scripts/test.sh -R client
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh
scripts/build.sh release
exec ctest --preset release -j "$(nproc)" "$@"
