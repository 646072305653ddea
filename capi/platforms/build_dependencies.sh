#!/bin/sh
# Builds what the runtime links (zlib, headers of xxHash) for another machine, as static libraries, from Debian's
# source packages, which apt verifies.
#   capi/platforms/build_dependencies.sh TARGET
# TARGET is the name of a toolchain file beside this script, such as wasm. The libraries are installed into
# build/cross/TARGET, where that toolchain file looks for them; once complete, nothing is built again. Sources are kept
# in build/cross/sources.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
target=${1:-}
toolchain=$here/$target.cmake
if [ -z "$target" ] || [ ! -e "$toolchain" ]; then
  echo "build_dependencies.sh: \"$target\" is none of$(cd "$here" && for file in *.cmake; do printf ' %s' "${file%.cmake}"; done)" >&2
  exit 2
fi
cross=$(dirname "$(dirname "$here")")/build/cross
prefix=$cross/$target
sources=$cross/sources
work=$cross/$target-work
if [ -e "$prefix/complete" ]; then exit 0; fi

# What a target needs beside its toolchain file: packages of its compiler.
case $target in
  wasm)
    packages=emscripten compiler=emcc
    export EMSCRIPTEN="${EMSCRIPTEN:-/usr/share/emscripten}" NODE_PATH=/usr/share/nodejs
    ;;
  windows-x64) packages=g++-mingw-w64-x86-64-posix compiler=x86_64-w64-mingw32-g++-posix tested=1 ;;
  android-* | ios-*) packages="" compiler=cmake ;; # brought by the NDK and by Xcode; not run where this is tested
  aarch64) packages=g++-aarch64-linux-gnu compiler=aarch64-linux-gnu-g++ tested=1 ;;
esac
missing=""
command -v "$compiler" >/dev/null || missing=$packages
command -v cmake >/dev/null || missing="$missing cmake"
command -v ninja >/dev/null || missing="$missing ninja-build"
[ -d "$sources/xxhash" ] || command -v dpkg-source >/dev/null || missing="$missing dpkg-dev"
# shellcheck disable=SC2086
[ -z "$missing" ] || apt-get -q install -y --no-install-recommends -o DPkg::Lock::Timeout=600 $missing

# fetch PACKAGE: unpacks its source, with Debian's patches, into $sources/PACKAGE. Lists and cache of apt are our own,
# because most machines do not list source packages. Without apt: unpack zlib and xxhash there by hand.
fetch() {
  if [ -d "$sources/$1" ]; then return; fi
  mkdir -p "$sources/apt/lists/partial" "$sources/apt/cache" "$sources/download"
  for file in /etc/apt/sources.list /etc/apt/sources.list.d/debian.*; do
    case $file in
      *.sources) [ ! -e "$file" ] || sed 's/^Types:.*/Types: deb-src/' "$file" >"$sources/apt/debian.sources" ;;
      *.list) [ ! -s "$file" ] || sed -n 's/^deb /deb-src /p' "$file" >"$sources/apt/debian.list" ;;
    esac
  done
  set -- "$1" -q -o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$sources/apt" \
    -o Dir::State::lists="$sources/apt/lists" -o Dir::Cache="$sources/apt/cache" -o APT::Sandbox::User="$(id -un)"
  package=$1
  shift
  [ -e "$sources/apt/updated" ] || { apt-get update "$@" && touch "$sources/apt/updated"; }
  (cd "$sources/download" && apt-get source --download-only "$@" "$package")
  rm -rf "$sources/$package.part"
  dpkg-source --no-check -x "$sources/download/${package}"_*.dsc "$sources/$package.part"
  mv "$sources/$package.part" "$sources/$package"
}

# install_with_cmake FOLDER CMAKE_OPTION...
install_with_cmake() {
  folder=$1 build=$work/$(basename "$1")
  shift
  cmake -S "$folder" -B "$build" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$toolchain" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_POSITION_INDEPENDENT_CODE=ON "$@"
  cmake --build "$build" --target install
}

for package in zlib xxhash; do fetch $package; done
rm -rf "$prefix" "$work"
mkdir -p "$prefix/include"
install_with_cmake "$here/zlib" -DFB_ZLIB="$sources/zlib"
if [ -n "${tested:-}" ]; then # what tests are made of
  for package in cmocka doctest; do fetch $package; done
  install_with_cmake "$sources/cmocka" -DWITH_STATIC_LIB=ON -DWITH_EXAMPLES=OFF
  cp "$work/cmocka/src/libcmocka-static.a" "$prefix/lib/libcmocka.a" # which it does not install
  sed -i 's|/lib/[^)]*)|/lib/libcmocka.a)|' "$prefix/lib/cmake/cmocka/cmocka-config.cmake"
  install_with_cmake "$sources/doctest" -DDOCTEST_WITH_TESTS=OFF
fi
cp "$sources/xxhash/xxhash.h" "$sources/xxhash/xxh3.h" "$prefix/include"
for package in zlib xxhash; do
  [ ! -e "$sources/$package/debian" ] || cp "$sources/$package/debian/copyright" "$prefix/$package.copyright"
done
rm -rf "$work"
touch "$prefix/complete"
