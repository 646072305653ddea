#!/bin/sh
# Compares the C interface of both libraries with what the last release had (tests/abi/*.abi), by abidiff. Fails on
# everything but functions that were added and structs that grew at their ends.
#   tests/abi/check.sh [BUILD]             BUILD has libraries with debug information of capi (cmake -D FB_ABI_INFO=ON), in
#                                          BUILD/lib; without, they are built in build/abi
#   tests/abi/check.sh --update [BUILD]    writes the dumps instead: for a release, and where the SONAME has changed
# Installs abigail-tools where it is missing (Debian, as root).
set -eu
cd "$(dirname "$0")/../.."
update=no
if [ "${1:-}" = --update ]; then
  update=yes
  shift
fi
build=${1:-build/abi}
if [ "$(uname -m)" != x86_64 ]; then
  echo "tests/abi/check.sh: the dumps are of x86_64" >&2
  exit 77
fi
if ! command -v abidw >/dev/null; then
  apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=600 abigail-tools
fi
if [ $# -eq 0 ]; then
  samples/setup.sh
  cmake --preset release -B "$build" -D FB_TESTS=OFF -D FB_ABI_INFO=ON
  cmake --build "$build" --parallel "$(nproc)" --target libfacebaker libfacebaker_bake
fi

headers=capi/include/facebaker
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=no
for library in "$build/lib/libfacebaker.so" "$build/lib/libfacebaker_bake.so"; do
  [ -e "$library" ] || continue # a build of the runtime alone
  soname=$(readelf --dynamic --wide "$library" | sed -n 's/.*SONAME.*\[\(.*\)\].*/\1/p')
  dump=tests/abi/$soname.abi
  abidw --headers-dir "$headers" --drop-private-types --no-show-locs --no-corpus-path --no-comp-dir-path "$library" |
    /usr/bin/python3 -B tests/abi/public_types.py "$headers" >"$work/now.abi"
  grep -q "<function-decl" "$work/now.abi" || { echo "tests/abi/check.sh: $library has no debug information" >&2; exit 1; }
  if [ $update = yes ]; then
    cp "$work/now.abi" "$dump"
    continue
  fi
  [ -e "$dump" ] || { echo "tests/abi/check.sh: there is no $dump; see --update" >&2; exit 1; }
  code=0
  abidiff --no-added-syms "$dump" "$work/now.abi" >"$work/report" || code=$?
  # A mask: 1 failed, 2 wrong use, 4 something changed, 8 incompatibly.
  if [ $((code & 3)) -ne 0 ]; then
    cat "$work/report"
    echo "FAILED: abidiff ended with $code"
    failed=yes
  elif [ $((code & 8)) -ne 0 ] || ! /usr/bin/python3 -B tests/abi/grown_only.py "$dump" "$work/now.abi" >"$work/offences"; then
    cat "$work/report" "$work/offences" 2>/dev/null || true
    echo "FAILED: programs built against $soname would break"
    failed=yes
  else
    echo "$soname: $(cat "$work/offences")"
  fi
done
[ $failed = no ]
