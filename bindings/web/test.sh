#!/bin/sh
# Tests the npm package: builds it, checks types, poses in Node and in Chromium and compares every bit with the native
# library, packs it and imports it from the tarball in an empty folder. Installs what is missing (Debian: Emscripten,
# Chromium; npm: what package.json names), and builds libfacebaker where it is not built.
#   bindings/web/test.sh [ARCHIVE...]
# ARCHIVEs are posed beside the golden ones of tests/golden. FB_BUILD: the native build, build/release by default.
set -eu
cd "$(dirname "$0")/../.."
root=$PWD
build=$(realpath -m "${FB_BUILD:-build/release}")
web=$root/build/web
export OMP_WAIT_POLICY=PASSIVE
if ! command -v chromium >/dev/null; then
  apt-get -q install -y --no-install-recommends -o DPkg::Lock::Timeout=600 chromium
fi
bindings/web/build.sh
if [ ! -e "$build/lib/libfacebaker.so" ]; then
  cmake --preset release
  cmake --build --preset release --parallel "$(nproc)" --target libfacebaker
fi
for program in native_poses native_solves; do
  cc -std=gnu99 -O2 -I capi/include "bindings/web/tests/$program.c" -o "$web/$program" \
    -L "$build/lib" -lfacebaker -Wl,-rpath,"$build/lib"
done

# What the native library gives.
mkdir -p "$web/expected"
golden=$root/tests/golden/2.0
solves=""
pairs="" # the last one is drawn, so it has to have a surface
number=0
for archive in "$golden"/accepted/*.fbk "$root"/tests/golden/2.1/accepted/*.fbk "$golden/accepted/character.fbk" "$@"; do
  archive=$(realpath "$archive")
  number=$((number + 1))
  dump=$web/expected/$number-$(basename "$archive" .fbk).poses # archives of several folders may have one name
  "$web/native_poses" dump "$archive" 256 "$dump"
  pairs="$pairs $archive=$dump"
  case $archive in */arithmetic.fbk | */overflow.fbk) continue ;; esac # positions are farther than targets may be
  "$web/native_solves" "$archive" 16 "${dump%.poses}.solves"
  solves="$solves $archive=${dump%.poses}.solves"
done
for archive in "$golden"/rejected/* "$root"/tests/golden/2.1/rejected/*; do echo "$archive"; done >"$web/refused.list"
# shellcheck disable=SC2046
"$web/native_poses" refuse $(cat "$web/refused.list") | paste "$web/refused.list" - >"$web/refused.txt"

export FB_ARCHIVES="$pairs" FB_SOLVES="$solves" FB_GOLDEN="$golden" FB_REFUSED="$web/refused.txt" FB_DOCS_PAGE="$root/docs/browser.md"
rm -rf "$web/tests" "$web/tests-built"
cp -r bindings/web/tests "$web"
cd "$web"
npx tsc -p tests
cp tests/browser/*.html tests-built/browser
node --expose-gc --test tests-built/test_*.js
node tests-built/browser/run_chromium.js

# As somebody gets it.
empty=$(mktemp -d)
trap 'rm -rf "$empty"' EXIT
tarball=$(npm pack --silent --pack-destination "$empty")
cd "$empty"
npm init -y >/dev/null
npm install --silent --no-audit --no-fund "./$tarball"
cat >check.mjs <<'CHECK'
import { load } from "facebaker";
import * as worker from "facebaker/worker";
import { renderMeshes } from "facebaker/geometry";
const face = await load(process.argv[2]), far = await worker.load(process.argv[2]);
const here = face.evaluate(face.createPose()), there = await far.evaluate(far.createPose());
if (renderMeshes(face).length === 0 || here.some((value, i) => value !== there[i])) throw new Error("other positions");
await far.dispose();
CHECK
node check.mjs "$golden/accepted/character.fbk"
# What a page loads that does not solve.
bytes=$(cd "$web" && { cat dist/facebaker.wasm; npx esbuild dist/index.js --bundle --minify --format=esm --log-level=error; } |
  gzip -9c | wc -c)
[ "$bytes" -le 250000 ] || { echo "module and scripts take $bytes bytes as gzip, above 250000" >&2; exit 1; }
echo "tarball: $(wc -c <"$tarball") bytes; it installs and imports in an empty folder; a page loads $bytes bytes as gzip"
