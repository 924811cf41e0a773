#!/usr/bin/env bash
# The slow checks: sanitizers over the core and farm tests, and clang-tidy on demand.
#   scripts/check.sh [asan|tsan|tidy]...     (default: asan tsan)
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh
[ $# -gt 0 ] || set -- asan tsan

for check in "$@"; do
  case "$check" in
    asan|tsan)
      echo "check: $check" >&2
      scripts/build.sh "$check"
      ctest --preset "$check" -j "$(nproc)"
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
