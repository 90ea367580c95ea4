#!/usr/bin/env bash
# Installs the packages for building and testing, all from Debian 12. Prints nothing and needs no
# privileges if none is missing.
#
#   deploy/install_dependencies.sh [--lint]     --lint: also the packages for deploy/lint.sh
set -euo pipefail

build_packages=(
  g++ cmake ninja-build pkgconf ccache mold
  libopenvdb-dev libtbb-dev libeigen3-dev libboost-iostreams-dev libpcl-dev
  libgrpc++-dev protobuf-compiler-grpc libprotobuf-dev protobuf-compiler
  librocksdb-dev libzstd-dev libpng-dev zlib1g-dev libjpeg62-turbo-dev
  libopenexr-dev libtiff-dev libcairo2-dev libjemalloc-dev
  libspdlog-dev libcli11-dev nlohmann-json3-dev libtomlplusplus-dev libsystemd-dev
  libgtest-dev libgmock-dev libbenchmark-dev
  python3 python3-grpcio python3-protobuf python3-numpy python3-zstandard python3-crc32c
  python3-pip python3-setuptools python3-wheel python3-matplotlib
)
lint_packages=(
  clang clang-format clang-tidy shellcheck black pyflakes3 git g++-aarch64-linux-gnu
)

fail() {
  echo "install_dependencies: $*" >&2
  exit 1
}

wanted=("${build_packages[@]}")
for argument in "$@"; do
  case "$argument" in
    --lint) wanted+=("${lint_packages[@]}") ;;
    *) fail "unknown argument '$argument'; usage: install_dependencies.sh [--lint]" ;;
  esac
done

is_installed() {
  [[ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" == installed ]]
}

command -v dpkg-query >/dev/null || fail "needs Debian 12, found a system without dpkg"
missing=()
for package in "${wanted[@]}"; do
  is_installed "$package" || missing+=("$package")
done
((${#missing[@]})) || exit 0

# shellcheck source=/dev/null
system=$(. /etc/os-release 2>/dev/null && echo "${ID:-unknown} ${VERSION_ID:-unknown}") || system=unknown
[[ "$system" == "debian 12" ]] || fail "needs Debian 12, found $system; missing: ${missing[*]}"

as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null ||
    fail "needs root or sudo to install: ${missing[*]}"
  as_root=(sudo)
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
# Waits for another package manager instead of failing.
apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -q -y -o DPkg::Lock::Timeout=300 "$@" >"$log" 2>&1
}

echo "install_dependencies: installing ${#missing[@]} packages: ${missing[*]}"
# The package lists of a fresh machine are empty and those of an old one outdated; only then is an
# update needed.
if ! apt install --no-install-recommends "${missing[@]}"; then
  echo "install_dependencies: updating the package lists first"
  if ! { apt update && apt install --no-install-recommends "${missing[@]}"; }; then
    tail -n 20 "$log" >&2
    fail "apt-get could not install: ${missing[*]}"
  fi
fi
echo "install_dependencies: done"
