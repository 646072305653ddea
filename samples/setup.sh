#!/bin/sh
# Installs the Debian packages that building FaceBaker needs; does nothing when nothing is missing.
#   samples/setup.sh                what the release build and its tests need
#   samples/setup.sh --sanitizers   and what the presets asan and tsan need besides
#   samples/setup.sh --docs         and what docs/build_reference.sh needs besides
set -eu

packages="g++ cmake ninja-build pkg-config libeigen3-dev libdraco-dev libmeshoptimizer-dev libtinygltf-dev libstb-dev nlohmann-json3-dev
  zlib1g-dev libssl-dev libpng-dev libturbojpeg0-dev libwebp-dev libxxhash-dev libutf8proc-dev libcli11-dev libmicrohttpd-dev libcmocka-dev doctest-dev python3-numpy python3-pip mypy file openssl"
case "${1:-}" in
  "") ;;
  --sanitizers) packages="$packages clang libclang-rt-dev libomp-dev lld" ;;
  --docs) packages="$packages doxygen" ;;
  *) echo "usage: samples/setup.sh [--sanitizers | --docs]" >&2; exit 2 ;;
esac

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  echo "samples/setup.sh: this is not a Debian machine; install the like of these packages yourself: $packages" >&2
  exit 1
fi

missing=""
for package in $packages; do
  dpkg-query --show --showformat='${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed ||
    missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=""
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "samples/setup.sh: installing needs root; as root, run: apt-get install --no-install-recommends$missing" >&2
    exit 1
  fi
  as_root="sudo"
fi

echo "installing:$missing" >&2
# $as_root is empty or one word, and $missing is a list of words.
# shellcheck disable=SC2086
{
  $as_root apt-get -o DPkg::Lock::Timeout=600 -q update
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -o DPkg::Lock::Timeout=600 -q install -y --no-install-recommends $missing
}
