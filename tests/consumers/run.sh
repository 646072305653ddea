#!/bin/sh
# Builds projects that use FaceBaker in every way there is, and poses a face in each, with the hash that every machine
# gives: within their own build (add_subdirectory, FetchContent) and installed, in a prefix that was moved (find_package,
# pkg-config, a compiler alone); shared, static and with link-time optimisation; without exceptions and RTTI, and without
# OpenMP.
#   tests/consumers/run.sh BUILD_DIR [WORK_DIR]
# BUILD_DIR is a built tree of the project, for its fixture; WORK_DIR (default BUILD_DIR/consumers) is kept between runs.
# In the environment: FB_CMAKE_OPTIONS, for every build, such as those by which a compiler cache knows sources again.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
build=$(cd "$1" && pwd)
work=${2:-$build/consumers}
face=$build/fixtures/tiny.fbk
hash=0b13ddff07a91577 # as in tests/determinism
options=${FB_CMAKE_OPTIONS:-}
export OMP_WAIT_POLICY=PASSIVE
mkdir -p "$work"
work=$(cd "$work" && pwd)

fail() {
  echo "FAILED: $*"
  exit 1
}
# quietly NAME COMMAND...: shows what a command said only if it fails
quietly() {
  log=$work/$1.log
  shift
  "$@" >"$log" 2>&1 || { tail -n 40 "$log"; fail "$*"; }
}
# no_symbols_but_c NAME LIBRARY: no defined symbol of ours is visible but the C functions
no_symbols_but_c() {
  visible=$(readelf --wide --syms "$2" | awk '$5 != "LOCAL" && $6 == "DEFAULT" && $7 != "UND" { print $8 }' |
    grep -E '^_Z(N|NK|TI|TS|TV|TT|GV)?(N|NK)?2fb' || true)
  [ -z "$visible" ] || fail "$1: visible in $2: $(echo "$visible" | c++filt | head -n 5)"
}
# pose NAME PROGRAM_DIR
pose() {
  quietly "$1-pose" "$2/pose" 200 "$face=$hash"
  quietly "$1-strict" "$2/strict" "$face"
  [ ! -e "$2/author" ] || quietly "$1-author" "$2/author"
  echo "$1: the same bits"
}
# embed NAME CMAKE_OPTION...
embed() {
  name=$1
  shift
  # shellcheck disable=SC2086 # options without spaces
  quietly "$name-configure" cmake -G Ninja -S "$here/embedded" -B "$work/$name" -DCMAKE_BUILD_TYPE=Release \
    -DPROGRAM="$root/tests/determinism/hash_archive.c" "$@" $options
  quietly "$name-build" cmake --build "$work/$name" --parallel "${JOBS:-2}"
  pose "$name" "$work/$name"
  exported=$(nm --dynamic --defined-only "$work/$name/libplugin.so" | awk '$3 ~ /^fb_|2fb/ { print $3 }')
  [ -z "$exported" ] || fail "$name: a plugin exports $exported"
  quietly "$name-install" cmake --install "$work/$name" --prefix "$work/$name/prefix"
  [ ! -e "$work/$name/prefix" ] || fail "$name: installs something"
}

# Only what is linked is built: the authoring library is there, and is not.
embed subdirectory -DFACEBAKER="$root"
[ -z "$(find "$work/subdirectory" -name 'libfacebaker_bake.so*')" ] || fail "subdirectory: builds what nothing links"
embed subdirectory-static -DFACEBAKER="$root" -DBUILD_SHARED_LIBS=OFF -DFB_RUNTIME_ONLY=ON
embed subdirectory-lto -DFACEBAKER="$root" -DFB_RUNTIME_ONLY=ON -DCMAKE_INTERPROCEDURAL_OPTIMIZATION=ON
embed static-lto -DFACEBAKER="$root" -DFB_RUNTIME_ONLY=ON -DCMAKE_INTERPROCEDURAL_OPTIMIZATION=ON -DBUILD_SHARED_LIBS=OFF
# A host that forbids exceptions and asks for quick arithmetic everywhere.
embed subdirectory-flags -DFACEBAKER="$root" -DFB_RUNTIME_ONLY=ON \
  -DCMAKE_CXX_FLAGS="-fno-exceptions -fno-rtti -ffast-math -march=native"

(cd "$root" && git ls-files -z --cached --others --exclude-standard | tar --null -T - -czf "$work/facebaker.tar.gz")
embed fetched -DFACEBAKER_ARCHIVE="$work/facebaker.tar.gz" -DBAKE=ON -DCMAKE_UNITY_BUILD=ON

# by_pkg_config NAME PACKAGE COMPILER SOURCE PROGRAM: compiles with what pkg-config says of the installed package
by_pkg_config() {
  prefix=$work/$1/prefix
  flags=$(PKG_CONFIG_PATH=$prefix/lib/pkgconfig pkg-config --cflags --libs "$2")
  # $3 is a compiler with its options, and $flags are many.
  # shellcheck disable=SC2086
  quietly "$1-pkg-config-$5" $3 -Wall -Wextra -Werror "$4" $flags -Wl,-rpath,"$prefix/lib" -o "$work/$1/app/$5"
}
# install_kind NAME CMAKE_OPTION...: installs a build of its own, moves it, and finds it with CMake and with pkg-config
install_kind() {
  name=$1
  shift
  # shellcheck disable=SC2086 # options without spaces
  quietly "$name-configure" cmake -G Ninja -S "$root" -B "$work/$name" -DCMAKE_BUILD_TYPE=Release \
    -DFB_TOOL=OFF -DFB_SAMPLES=OFF -DFB_TESTS=OFF -DCMAKE_INSTALL_LIBDIR=lib "$@" $options
  quietly "$name-build" cmake --build "$work/$name" --parallel "${JOBS:-2}"
  rm -rf "$work/$name/installed" "$work/$name/prefix"
  quietly "$name-install" cmake --install "$work/$name" --prefix "$work/$name/installed"
  mv "$work/$name/installed" "$work/$name/prefix"
  quietly "$name-app" cmake -G Ninja -S "$here/app" -B "$work/$name/app" -DCMAKE_PREFIX_PATH="$work/$name/prefix" \
    -DHELLO="$root/samples/hello_face/hello_face.c"
  quietly "$name-app-build" cmake --build "$work/$name/app"
  by_pkg_config "$name" facebaker "cc -std=c99" "$root/tests/determinism/hash_archive.c" pose
  if [ -e "$work/$name/app/author" ]; then # the authoring library is installed too
    by_pkg_config "$name" facebaker_bake "c++ -std=c++17" "$here/app/author.cpp" author-by-pkg-config
    quietly "$name-author-by-pkg-config" "$work/$name/app/author-by-pkg-config"
  fi
  pose "$name" "$work/$name/app"
}
install_kind installed-static -DBUILD_SHARED_LIBS=OFF -DCMAKE_UNITY_BUILD=ON
[ -e "$work/installed-static/app/author" ] || fail "installed-static: has no authoring library"
no_symbols_but_c installed-static "$work/installed-static/prefix/lib/libfacebaker.a"
no_symbols_but_c installed-static "$work/installed-static/prefix/lib/libfacebaker_bake.a"
# A host that compiles with neither.
prefix=$work/installed-static/prefix
mkdir -p "$work/static-alone"
quietly static-alone cc -std=c99 -DFB_STATIC -I"$prefix/include" "$root/tests/determinism/hash_archive.c" \
  "$prefix/lib/libfacebaker.a" -lz -lstdc++ -lm -fopenmp -o "$work/static-alone/pose"
quietly static-alone-pose "$work/static-alone/pose" 200 "$face=$hash"
echo "static-alone: the same bits"

install_kind installed-runtime -DFB_RUNTIME_ONLY=ON -DFB_OPENMP=OFF
no_symbols_but_c installed-runtime "$work/installed-runtime/prefix/lib/libfacebaker.so"
readelf --dynamic "$work/installed-runtime/prefix/lib/libfacebaker.so" | grep -E 'NEEDED.*(gomp|libomp)' &&
  fail "installed-runtime: needs OpenMP"
echo "all consumers pose the same face"
