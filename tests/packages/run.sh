#!/bin/sh
# Builds the packages, has lintian look at them, installs them into a copy of this system, uses the tool, C by pkg-config and
# by CMake, and Python there, removes them and looks for what is left. Then the archives of source and installation.
#   tests/packages/run.sh [PACKAGES]      PACKAGES: a folder of packager/packages/build_debs.sh; by default they are built
# As root on Debian; installs what it needs. The system itself is not changed: the copy is an overlay in memory.
set -eu
cd "$(dirname "$0")/../.."
packages=${1:-build/packages}
[ $# -gt 0 ] || packager/packages/build_debs.sh "$packages"
packages=$(cd "$packages" && pwd)
missing=""
for package in lintian man-db groff-base mandoc file pkg-config libmeshoptimizer-dev python3-numpy; do
  dpkg-query --show --showformat='${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || missing="$missing $package"
done
# shellcheck disable=SC2086
[ -z "$missing" ] || apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=600 $missing

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# The target: what a player ships fits in 600 kB.
runtime=$(ls "$packages"/libfacebaker[0-9]*.deb)
size=$(stat -c %s "$runtime")
echo "$(basename "$runtime"): $size bytes"
[ "$size" -lt 600000 ] || fail "$runtime has 600,000 bytes or more"

lintian --allow-root --fail-on error,warning --suppress-tags-from-file tests/packages/lintian-suppressed "$packages"/*.deb ||
  fail "lintian"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/layers"
# The mounts are those of the shell that makes them, and go with it.
unshare --mount sh -eu -c '
  mount -t tmpfs tmpfs "$1/layers"
  mkdir "$1/layers/upper" "$1/layers/work" "$1/layers/merged"
  mount -t overlay overlay -o "lowerdir=/,upperdir=$1/layers/upper,workdir=$1/layers/work" "$1/layers/merged"
  mount -t proc proc "$1/layers/merged/proc"
  mount --bind /dev "$1/layers/merged/dev"
  mkdir "$1/layers/merged/tmp/installed"
  cp -r "$2" "$1/layers/merged/tmp/installed/packages"
  git archive HEAD tests samples VERSION capi/include | tar -x -C "$1/layers/merged/tmp/installed"
  exec chroot "$1/layers/merged" sh /tmp/installed/tests/packages/use_installed.sh
' sh "$work" "$packages"

# What is installed also works from any folder.
tar -xzf "$packages"/facebaker-*-Linux-*.tar.gz -C "$work"
prefix=$(ls -d "$work"/facebaker-*)
for file in LICENSE THIRD-PARTY.txt facebaker.spdx.json; do
  [ -s "$prefix/share/doc/facebaker/$file" ] || fail "the archive has no $file"
done
"$prefix/bin/facebaker" verify tests/golden/2.0/accepted/tiny.fbk
cmake -S tests/consumers/app -B "$work/app" -D CMAKE_PREFIX_PATH="$prefix" -D HELLO="$PWD/samples/hello_face/hello_face.c" >/dev/null
cmake --build "$work/app" >/dev/null
"$work/app/hello" tests/golden/2.0/accepted/tiny.fbk jaw_open 1
tar -xzf "$packages"/facebaker-*-source.tar.gz -C "$work"
[ -s "$work/facebaker-$(cat VERSION)/capi/include/facebaker/facebaker.h" ] || fail "the source archive is not whole"
echo "packages work, and leave nothing behind"
