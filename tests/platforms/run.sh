#!/bin/sh
# The runtime on other platforms: builds it, runs its tests under Wine or QEMU, and compares the bits of poses, from the
# archive on, with the hash that every machine gives. Installs compilers and emulators (Debian) where they are missing.
#   tests/platforms/run.sh BUILD_DIR [windows|aarch64|msvc]...
# BUILD_DIR is a built tree of the project, for its fixtures. Without names: all.
#   windows  facebaker.dll by MinGW, tests under Wine: 1.1 GB of packages
#   aarch64  libfacebaker.so, tests under QEMU: 390 MB
#   msvc     syntax alone: public headers for MSVC's target, the runtime's sources with clang and MinGW's headers
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
build=$(cd "$1" && pwd)
shift
[ $# -gt 0 ] || set -- windows aarch64 msvc
export OMP_WAIT_POLICY=PASSIVE

fail() {
  echo "FAILED: $*"
  exit 1
}
# needs COMMAND PACKAGE...: installs the packages if there is no such command or file
needs() {
  command -v "$1" >/dev/null || [ -x "/usr/lib/wine/$1" ] && return
  shift
  apt-get -q install -y --no-install-recommends -o DPkg::Lock::Timeout=600 "$@"
}
# build_and_test PRESET TEST_OPTION...
build_and_test() {
  preset=$1
  shift
  "$root/capi/platforms/build_dependencies.sh" "$preset"
  cd "$root"
  cmake --preset "$preset" -DFB_TESTS=ON -DFB_FIXTURES="$build/fixtures"
  cmake --build --preset "$preset" --parallel "${JOBS:-2}"
  ctest --test-dir "build/$preset" --output-on-failure --timeout 600 "$@"
}

windows() {
  needs wine64 wine64
  WINEPREFIX=$root/build/wine
  WINEDEBUG=-all
  export WINEPREFIX WINEDEBUG
  build_and_test windows-x64
  # The DLL imports the system's libraries alone, and exports what the map lists.
  dll=$root/build/windows-x64/bin/facebaker.dll
  x86_64-w64-mingw32-objdump -p "$dll" >"$dll.headers"
  imports=$(sed -n 's/^[[:space:]]*DLL Name: //p' "$dll.headers")
  [ -n "$imports" ] || fail "$dll imports nothing"
  for name in $imports; do
    case $name in
      KERNEL32.dll | msvcrt.dll | ntdll.dll | api-ms-win-crt-*.dll | ucrtbase.dll) ;;
      *) fail "$dll imports $name" ;;
    esac
  done
  sed 's/#.*//' "$root/capi/facebaker.map" | grep -o 'fb_[a-z0-9_]*' | sort >"$dll.listed"
  sed -n 's/^[[:space:]]*\[ *[0-9]*\] \(+base\[ *[0-9]*\] *[0-9a-f]* \)\{0,1\}\(fb_[a-z0-9_]*\)$/\2/p' "$dll.headers" |
    sort >"$dll.exported"
  diff "$dll.listed" "$dll.exported" || fail "$dll exports other names than facebaker.map lists"
  x86_64-w64-mingw32-strip -o "$dll.stripped" "$dll"
  echo "windows: $(echo "$imports" | tr "\n" " ")imported; $(wc -l <"$dll.exported") functions; $(wc -c <"$dll.stripped") bytes stripped"
}

# aligned LIBRARY: its segments may be mapped where pages have 16 KB, as Android demands
aligned() {
  loads=$(readelf --wide --program-headers "$1" | awk '$1 == "LOAD" { print $NF }')
  [ -n "$loads" ] || fail "$1 has no segments"
  for align in $loads; do
    [ $((align % 16384)) -eq 0 ] || fail "$1: a segment is aligned to $align"
  done
  echo "$1: segments aligned to $(echo "$loads" | sort -u | tr '\n' ' ')"
}

aarch64() {
  needs qemu-aarch64-static qemu-user-static
  build_and_test aarch64
  aligned build/aarch64/lib/libfacebaker.so
  # As Android's build links it.
  cmake --preset aarch64 -DCMAKE_SHARED_LINKER_FLAGS=-Wl,-z,max-page-size=16384
  cmake --build --preset aarch64 --target libfacebaker
  aligned build/aarch64/lib/libfacebaker.so
  cmake --preset aarch64 -DCMAKE_SHARED_LINKER_FLAGS=
}

msvc() {
  needs clang clang
  "$root/capi/platforms/build_dependencies.sh" windows-x64
  cd "$root"
  # Public headers need the compiler's own and string.h, of which MSVC's is not here.
  headers=$root/build/msvc-headers
  mkdir -p "$headers"
  printf '#include <stddef.h>\nvoid* memset(void*, int, size_t);\nsize_t strlen(const char*);\n' >"$headers/string.h"
  for header in capi/include/facebaker/*.h; do
    for definition in FB_BUILDING FB_STATIC FB_USED; do
      echo "#include <facebaker/$(basename "$header")>" |
        clang --target=x86_64-pc-windows-msvc -fms-compatibility -fms-extensions -ffreestanding -std=c99 -Wall -Wextra \
          -Wgnu -pedantic-errors -Werror -D$definition -Icapi/include -I"$headers" -fsyntax-only -x c -
    done
  done
  # The sources that a build for Windows has, by clang with the headers of the other compiler.
  cmake --preset windows-x64 -B build/windows-x64-sources >/dev/null
  includes=$(x86_64-w64-mingw32-g++-posix -E -x c++ -v - </dev/null 2>&1 | sed -n '/^#include </,/^End/s/^ \(.*\)/-isystem \1/p' |
    grep -v '/include-fixed$\|/[0-9]*-posix/include$')
  count=0
  for source in $(git ls-files 'core/*.cpp' 'capi/*.cpp'); do
    grep -q "/$source\"" build/windows-x64-sources/compile_commands.json || continue
    case $source in # as core/runtime/CMakeLists.txt has them
      */avx2.cpp) flags=-mavx2 ;;
      */avx_vnni.cpp) flags="-mavx2 -mavxvnni" ;;
      */avx512_vnni.cpp) flags="-mavx512f -mavx512bw -mavx512vl -mavx512vnni" ;;
      *) flags="" ;;
    esac
    # shellcheck disable=SC2086
    clang++ --target=x86_64-w64-mingw32 -std=c++20 -Wall -Wextra -Werror -Wno-format $flags -Icore -Icapi -Icapi/include \
      -Ibuild/windows-x64-sources/capi -DFB_BUILDING -DFB_LINKED='""' $includes -isystem build/cross/windows-x64/include -fsyntax-only "$source"
    count=$((count + 1))
  done
  [ $count -gt 40 ] || fail "only $count sources"
  echo "msvc: public headers for MSVC's target, $count sources with clang for Windows"
}

for platform in "$@"; do
  case $platform in
    windows | aarch64 | msvc) "$platform" ;;
    *) fail "\"$platform\" is none of windows, aarch64, msvc" ;;
  esac
done
