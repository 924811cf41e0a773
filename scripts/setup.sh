#!/usr/bin/env bash
# Installs the Debian 12 packages that the build and the tests need: only those that are missing, and nothing on a second run.
set -euo pipefail

packages=(
  g++ cmake ninja-build ccache pkg-config
  libgrpc++-dev protobuf-compiler-grpc libprotobuf-dev protobuf-compiler
  libembree-dev libtbb-dev libopenimageio-dev openimageio-tools libimath-dev
  libspdlog-dev libsqlite3-dev libzstd-dev libssl-dev zlib1g-dev
  libcli11-dev nlohmann-json3-dev libxsimd-dev
  libgtest-dev libgmock-dev libbenchmark-dev libboost-dev
  python3 python3-numpy python3-matplotlib
)

missing=()
for package in "${packages[@]}"; do
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

if [ "$(id -u)" -eq 0 ]; then
  as_root=()
elif command -v sudo >/dev/null; then
  as_root=(sudo)
else
  echo "setup: these packages are missing and only root can install them: ${missing[*]}" >&2
  echo "setup: run as root: apt-get install --no-install-recommends ${missing[*]}" >&2
  exit 1
fi
echo "setup: installing ${missing[*]}" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
export DEBIAN_FRONTEND=noninteractive
install() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >"$log" 2>&1; }
# Package lists may be absent or stale on a fresh machine: refresh them once if the first attempt fails.
install || { "${as_root[@]}" apt-get update -qq >"$log" 2>&1 && install; } || {
  echo "setup: apt-get failed; its last lines were:" >&2
  tail -n 20 "$log" >&2
  exit 1
}
