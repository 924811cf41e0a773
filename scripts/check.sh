#!/usr/bin/env bash
# The slow checks: the tests under sanitizers (docs/decisions/0007-sanitizers.md), and clang-tidy on demand.
#   scripts/check.sh [asan|tsan|tidy]...     (default: asan tsan)
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh
[ $# -gt 0 ] || set -- asan tsan

# sanitize PRESET LEFT_OUT TARGET...: builds the targets and runs their tests, but for those whose names match.
sanitize() {
  echo "check: $1" >&2
  scripts/build.sh "$1" "${@:3}"
  ctest --preset "$1" -j "$(nproc)" --no-tests=error -E "_NOT_BUILT$|$2"
}
core=(base_test math_test film_test guiding_test learning_test image_test scene_test tracing_test)

for check in "$@"; do
  case "$check" in
    # Without the tests that render for minutes: they ask whether images are right, of code that the others run too.
    asan) sanitize asan '^$' "${core[@]}" rpc_test coordinator_test farm_test client_test ;;
    # Without those that need a gRPC server, or run loops of OpenImageIO's and TBB's own: ThreadSanitizer cannot follow.
    tsan) sanitize tsan '(BadInput|InProcessFarm|Shards|Strikes|Resume|Refusal|FullDisk|JobEnd|LargePicture|LongUpload|TimeBudget)[.]|^Image[.]HalfExr|[.]BuildsTheSameTreeInAnyArena' \
            "${core[@]}" rpc_test coordinator_test ;;
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
