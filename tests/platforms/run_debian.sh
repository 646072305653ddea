#!/bin/sh
# Follows the README on another release of Debian, in a chroot of it that is made by debootstrap and removed afterwards:
# from a fresh clone of what is committed it runs the two commands of the quickstart as they stand, then what continuous
# integration runs here. Prints the time of each, and of which day the release is.
#   tests/platforms/run_debian.sh RELEASE [COMMAND]...
# RELEASE: bookworm, trixie, sid. With COMMANDs those are run in the clone instead, each a line of shell, such as
# "samples/setup.sh && bindings/python/test.sh".
# As root, with a network; installs debootstrap where it is missing. Takes 8 GB below $TMPDIR (/var/tmp), and an hour and a
# half on two cores. Nothing is left behind, also when it is interrupted. ../shared is seen inside, read-only, where it is.
set -eu
[ $# -gt 0 ] || { echo "usage: tests/platforms/run_debian.sh RELEASE [COMMAND]..." >&2; exit 2; }
[ "$(id -u)" -eq 0 ] || { echo "run_debian.sh: debootstrap and chroot need root" >&2; exit 1; }
release=$1
shift
root=$(cd "$(dirname "$0")/../.." && pwd)
command -v debootstrap >/dev/null ||
  apt-get -q install -y --no-install-recommends -o DPkg::Lock::Timeout=600 debootstrap

work=$(mktemp -d "${TMPDIR:-/var/tmp}/facebaker-$release.XXXXXX")
child=""
# What runs inside ends with its namespaces, and so do its mounts.
clean_up() {
  trap '' INT TERM HUP
  [ -z "$child" ] || { kill -KILL "$child" && wait "$child" || :; } 2>/dev/null
  for _ in 1 2 3 4 5; do rm -rf --one-file-system "$work" 2>/dev/null && break || sleep 1; done
}
trap clean_up EXIT
trap 'exit 130' INT TERM HUP

# The quickstart's commands, a line each, without what they are followed by.
[ $# -gt 0 ] || sed -n '/^## Quickstart/,/^```$/s/^\([a-z][a-z/_.]*\.sh\) .*/\1/p' "$root/README.md" >"$work/commands"
[ $# -eq 0 ] || printf '%s\n' "$@" >"$work/commands"
[ $# -gt 0 ] || { [ "$(wc -l <"$work/commands")" -eq 2 ] && echo .ci/run >>"$work/commands"; } ||
  { echo "run_debian.sh: README.md has not two commands in its quickstart" >&2; exit 1; }
git clone --quiet --no-hardlinks "file://$root" "$work/clone"
shared=""
[ ! -d "$root/../shared" ] || shared=$(cd "$root/../shared" && pwd)
# The system that is made, then what is done in it.
cat >"$work/make.sh" <<'MAKE'
set -eu
release=$1 work=$2 shared=$3
system=$work/system
debootstrap --variant=minbase "$release" "$system" ${FB_DEBIAN_MIRROR:+"$FB_DEBIAN_MIRROR"} >"$work/log" 2>&1 ||
  { tail -20 "$work/log" >&2; exit 1; }
cp /etc/resolv.conf "$system/etc/resolv.conf"
# Of a mirror that lags: its date is printed.
echo 'Acquire::Check-Valid-Until "false";' >"$system/etc/apt/apt.conf.d/90lagging-mirror"
[ -e "$system/etc/hosts" ] || echo "127.0.0.1 localhost" >"$system/etc/hosts"
mountpoint -q "$system/proc" || mount -t proc proc "$system/proc"
mount --rbind /dev "$system/dev"
mount -t tmpfs tmpfs "$system/dev/shm"
mkdir "$system/src"
mv "$work/clone" "$system/src/facebaker"
if [ -n "$shared" ]; then
  mkdir "$system/src/shared"
  mount --rbind "$shared" "$system/src/shared"
  mount -o remount,bind,ro "$system/src/shared"
fi
mv "$work/run.sh" "$work/commands" "$system/src"
exec chroot "$system" /usr/bin/env -i HOME=/root LANG=C.UTF-8 PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
  ${http_proxy:+"http_proxy=$http_proxy"} ${https_proxy:+"https_proxy=$https_proxy"} sh /src/run.sh "$release"
MAKE
cat >"$work/run.sh" <<'RUN'
set -eu
export DEBIAN_FRONTEND=noninteractive
# Whoever has a clone has git.
{ apt-get -q update && apt-get -q install -y --no-install-recommends git ca-certificates; } >/tmp/log 2>&1 ||
  { tail -20 /tmp/log >&2; exit 1; }
cd /src/facebaker
git config --global --add safe.directory /src/facebaker
date=$(sed -n 's/^Date: //p' /var/lib/apt/lists/*_InRelease | head -1)
echo "== $1, Debian $(cat /etc/debian_version) of $date; commit $(git rev-parse --short HEAD)"
failed=0
: >/tmp/results
while read -r command; do
  echo "== $command"
  begin=$(date +%s)
  result=passed
  sh -c "$command" </dev/null || { result="FAILED ($?)" failed=1; }
  seconds=$(($(date +%s) - begin))
  printf '%s: %s in %d:%02d\n' "$command" "$result" $((seconds / 60)) $((seconds % 60)) >>/tmp/results
done </src/commands
echo "== $1, Debian $(cat /etc/debian_version) of $date, $(nproc) cores, $(c++ --version 2>/dev/null | head -1)"
cat /tmp/results
exit $failed
RUN
unshare --mount --pid --fork --kill-child sh "$work/make.sh" "$release" "$work" "$shared" &
child=$!
wait "$child" && code=0 || code=$?
child=""
exit $code
