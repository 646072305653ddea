#!/bin/sh
# Builds the viewer as a folder of static files that works from any web server, and from `facebaker view --page FOLDER`.
# Builds the npm package facebaker first (bindings/web/build.sh, which installs what it needs) and gets three.js, Vite
# and TypeScript by npm into build/viewer-work.
#   samples/viewer/build.sh FOLDER [DEMO.fbk...]
# FOLDER: made anew, complete or not at all; one that holds something else is refused. DEMO.fbk: a face to show at the
# start, or two to show side by side.
# Environment: FB_WEB_BUILT=1 takes the package that is in build/web already.
set -eu
[ $# -ge 1 ] && [ $# -le 3 ] || { sed -n '2,8s/^# *//p' "$0" >&2; exit 2; }
out=$(realpath -m "$1")
shift
for demo; do [ -f "$demo" ] || { echo "samples/viewer/build.sh: $demo: no such file" >&2; exit 1; }; done
if [ -d "$out" ] && [ -n "$(ls -A "$out")" ] && ! grep -qs "FaceBaker viewer" "$out/index.html"; then
  echo "samples/viewer/build.sh: $out holds something that is no viewer" >&2
  exit 1
fi
here=$(realpath "$(dirname "$0")")
root=$(realpath "$here/../..")
[ -n "${FB_WEB_BUILT-}" ] || "$root/bindings/web/build.sh" >&2
work=$root/build/viewer-work
mkdir -p "$work"
rm -rf "$work/src" "$work/public" "$work/node_modules/facebaker" "$work/node_modules/.package-lock.json"
cp -r "$here/src" "$here/public" "$here/index.html" "$here/package.json" "$here/tsconfig.json" "$here/vite.config.ts" "$work"
new=$out.partial
rm -rf "$new"
trap 'rm -rf "$new"' EXIT
(
  cd "$work"
  # As a copy: a linked package would bring a three.js of its own.
  npm install --install-links --ignore-scripts --no-package-lock --no-audit --no-fund --prefer-offline
  npm run check
  npm run build -- --outDir "$new" --emptyOutDir
) >&2
{
  printf 'The scripts of this page have three.js in them:\n\n'
  cat "$work/node_modules/three/LICENSE"
  echo
  cat "$work/node_modules/facebaker/THIRD-PARTY.txt"
} >"$new/THIRD-PARTY.txt"
number=0
faces=
for demo; do
  cp "$demo" "$new/$number.fbk"
  faces="$faces${faces:+, }{ \"name\": \"$(basename "$demo" | sed 's/[\\"]/\\&/g')\", \"url\": \"$number.fbk\" }"
  number=$((number + 1))
done
echo "{ \"faces\": [$faces] }" >"$new/view.json"
rm -rf "$out"
mkdir -p "$(dirname "$out")"
mv "$new" "$out"
echo "$out"
