#!/bin/sh
# Runs test.sh in the Blender of another release of Debian, with the libraries and the tool that were built here: in a
# chroot, which debootstrap makes. As root; takes 2 GB of disk and some minutes more than test.sh. CHROOT names a folder
# that is kept, and used again where it is there.
#   [CHROOT=DIR] bindings/blender/test_debian.sh RELEASE [BUILD] [-- TEST...]
# RELEASE: trixie (Debian 13, Blender 4.3), sid (Blender 5.2 in November 2026)
set -eu
tree=$(realpath "$(dirname "$0")/../..")
[ $# -gt 0 ] || { echo "usage: [CHROOT=DIR] bindings/blender/test_debian.sh RELEASE [BUILD] [-- TEST...]" >&2; exit 2; }
[ "$(id -u)" -eq 0 ] || { echo "$0: run it as root, for debootstrap and mounts" >&2; exit 1; }
release=$1
shift
build=$tree/build/release
if [ $# -gt 0 ] && [ "$1" != -- ]; then
  build=$(realpath "$1")
  shift
fi
[ "${1:-}" != -- ] || shift
command -v debootstrap > /dev/null ||
  env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 -q install -y --no-install-recommends debootstrap

root=${CHROOT:-}
[ -n "$root" ] || root=$(mktemp -d)
leave() {
  for place in "$build" "$tree" /dev/shm /dev /proc; do
    ! mountpoint -q "$root$place" || umount "$root$place"
  done
  # Never beneath a mount: what is mounted there is not the chroot's.
  [ -n "${CHROOT:-}" ] || rm -rf --one-file-system "$root"
}
trap leave EXIT
[ -e "$root/etc/debian_version" ] || debootstrap --variant=minbase "$release" "$root" > /dev/null
inside() {
  chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}
mkdir -p "$root$tree" "$root$build"
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"
mount --bind /dev/shm "$root/dev/shm"
mount --bind "$tree" "$root$tree"
case $build in
  "$tree"/*) ;;
  *) mount --bind "$build" "$root$build" ;;
esac
# Of a mirror that lags.
echo 'Acquire::Check-Valid-Until "false";' > "$root/etc/apt/apt.conf.d/90lagging-mirror"
inside apt-get -q update
# The last two are of the command "extension" in Blender 5.2, whose package does not ask for them.
inside apt-get -q install -y --no-install-recommends blender python3-numpy libgomp1 libstdc++6 python3-cattr python3-requests
# What the tool and the viewer, if it is built, need besides, in this machine's version.
for library in $(ldd "$build"/bin/facebaker "$build"/bin/facebaker-view 2> /dev/null | awk '$3 ~ "^/" && $1 !~ "^lib(c|m|gcc_s|stdc\\+\\+|gomp|facebaker.*)\\.so" { print $3 }'); do
  # Its own come first: Blender needs the newer one where both are there.
  inside ldconfig -p | grep -qF "$(basename "$library") " || cp -L "$library" "$root/usr/local/lib/"
done
inside ldconfig
inside dpkg-query -W blender
inside sh "$tree/bindings/blender/test.sh" "$build" -- "$@"
