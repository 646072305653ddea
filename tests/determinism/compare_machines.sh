#!/bin/sh
# Evaluates archives with many builds of the runtime, and fails unless all of them give the same bits:
# gcc -O0, -O2, -O3 and clang, each with every instruction set of this processor, 1 to 8 threads and a host that rounds
# up; AArch64 under qemu; WebAssembly under node. Reports what is skipped because it is not installed.
#   tests/determinism/compare_machines.sh BUILD_DIR [ARCHIVE...]
# BUILD_DIR is a built tree of the project; without archives its fixture is used.
#   --install first (Debian): installs the compilers and emulators, about 1.5 GB
set -eu
if [ "${1:-}" = "--install" ]; then
  shift
  apt-get -q install -y --no-install-recommends clang libomp-dev g++-aarch64-linux-gnu qemu-user-static emscripten
fi
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
shift
[ $# -gt 0 ] || set -- "$build/fixtures/tiny.fbk"
export OMP_WAIT_POLICY=PASSIVE NODE_PATH=/usr/share/nodejs

work=$build/determinism
mkdir -p "$work/xxhash"
for header in /usr/include/xxhash.h /usr/include/xxh3.h; do
  [ ! -e "$header" ] || cp "$header" "$work/xxhash"
done
dumps=""
for archive in "$@"; do
  dump=$work/$(basename "$archive").dump
  "$build/bin/dump_model" "$archive" "${FB_POSES:-50}" "$dump"
  dumps="$dumps $dump"
done

expected=""
# pose NAME RUNNER PROGRAM
pose() {
  # shellcheck disable=SC2086
  found=$($2 "$3" $dumps) || { echo "$1: $found"; exit 1; }
  printf '%-24s %s\n' "$1" "$(echo "$found" | tr '\n' ' ')"
  [ -n "$expected" ] || expected=$found
  [ "$found" = "$expected" ] || { echo "$1 gives other bits"; exit 1; }
}
# with NAME RUNNER PROGRAM CMAKE_COMMAND CMAKE_OPTION...: builds hash_poses in its own folder, and poses with it
with() {
  name=$1 runner=$2 program=$3
  shift 3
  "$@" -S "$here" -B "$work/$name" -DFB_XXHASH="$work/xxhash" >"$work/$name.log" 2>&1 &&
    cmake --build "$work/$name" --target hash_poses >>"$work/$name.log" 2>&1 ||
    { echo "$name: does not build, see $work/$name.log"; exit 1; }
  pose "$name" "$runner" "$work/$name/$program"
}
# has NAME COMMAND...
has() {
  name=$1
  shift
  for command in "$@"; do
    command -v "$command" >/dev/null || { echo "$name: skipped, $command is not installed"; return 1; }
  done
}

pose "build tree" "" "$build/bin/hash_poses"
for level in 0 2 3; do
  with "gcc-O$level" "" hash_poses cmake -DCMAKE_CXX_COMPILER=g++ -DCMAKE_CXX_FLAGS="-O$level"
done
! has clang clang++ || with clang "" hash_poses cmake -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_FLAGS=-O2
! has aarch64 aarch64-linux-gnu-g++ qemu-aarch64-static ||
  with aarch64 "qemu-aarch64-static -cpu max -L /usr/aarch64-linux-gnu" hash_poses cmake -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
    -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ -DCMAKE_CXX_FLAGS=-O2
! has wasm emcmake node ||
  # Node has a fetch, which older Emscriptens take for a browser's.
  with wasm "node --no-experimental-fetch" hash_poses.js emcmake cmake -DCMAKE_CXX_FLAGS="-O2 -msimd128"
echo "all the same"
