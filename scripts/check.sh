#!/usr/bin/env bash
# The slow checks: sanitizers over the tests that pass under them, and clang-tidy on demand.
#   scripts/check.sh [asan|tsan|tidy]...     (default: asan tsan)
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh
[ $# -gt 0 ] || set -- asan tsan

# sanitize PRESET NAMES TARGET...: builds the targets and runs the tests whose names begin so.
sanitize() {
  echo "check: $1" >&2
  scripts/build.sh "$1" "${@:3}"
  ctest --preset "$1" -j "$(nproc)" --no-tests=error -R "^($2)[.]"
}

for check in "$@"; do
  case "$check" in
    # The other test programs have not been run under AddressSanitizer yet.
    asan) sanitize asan 'Advance|BsdfFraction|DirectionalTree|SdTree|SdTreeStatistics|SpatialTree' guiding_test ;;
    # Without a gRPC server only: gRPC, protobuf and Abseil as packaged are not instrumented, so ThreadSanitizer does not
    # see how they hand a call over and reports them by the hundred (BadInput, InProcessFarm, Strikes).
    tsan)
      sanitize tsan 'Convert|Retry|Status|UnknownFields|LeaseTableTest|LeaseUnits|StoreTest|Scheduler' \
        rpc_test coordinator_test
      ;;
    tidy)
      tidy=$(command -v clang-tidy clang-tidy-16 clang-tidy-14 | head -n 1) || {
        echo "check: clang-tidy is not installed; try: apt-get install clang-tidy" >&2
        exit 1
      }
      [ -f build/dev/compile_commands.json ] || cmake --preset dev >&2
      # Generated headers must exist before their users can be parsed.
      scripts/build.sh dev
      git ls-files '*.cpp' | xargs -P "$(nproc)" -n 4 "$tidy" -p build/dev --quiet
      ;;
    *)
      echo "check: unknown check '$check'; there are asan, tsan and tidy" >&2
      exit 2
      ;;
  esac
done
