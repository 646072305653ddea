#!/bin/sh
# Draws faces by the viewers of docs/web-engines.md, by the code that is written there, in headless Chromium, and compares
# the pixels of three poses with what each viewer's own glTF loader draws of the processor's positions and normals; with
# the sign of one control turned they have to differ. Takes engines from npm, in the versions below, into
# build/web-viewers, and leaves the pictures of both in its folder `pictures`.
#   bindings/web/test_viewers.sh [VIEWER...] [-- FACE.fbk...]
# VIEWER: some of three-webgl three-webgpu react babylon babylon-left playcanvas aframe model-viewer; all by default.
# FACEs are drawn as they are, beside golden archives with a skin and driven joints, which get materials of all kinds.
# FB_BUILD: the native build, whose tool exports .glb files for model-viewer, build/release by default; FB_WEB_BUILT=1:
# build/web is built.
set -eu
cd "$(dirname "$0")/../.."
root=$PWD
web=$root/build/web
work=$root/build/web-viewers
build=$(realpath -m "${FB_BUILD:-build/release}")
engines="three@0.187.0 @react-three/fiber@9.8.2 react@19.3.1 react-dom@19.3.1 @babylonjs/core@9.28.0 @babylonjs/loaders@9.28.0
  playcanvas@2.23.3 super-three@0.184.0"
types="@types/three@0.187.0 @types/react@19"
if ! command -v chromium >/dev/null; then
  apt-get -q install -y --no-install-recommends -o DPkg::Lock::Timeout=600 chromium
fi
[ -n "${FB_WEB_BUILT:-}" ] || bindings/web/build.sh
if [ ! -e "$build/bin/facebaker" ]; then
  cmake --preset release
  cmake --build --preset release --parallel "$(nproc)" --target facebaker
fi
mkdir -p "$work/archives"
cd "$work"
if [ "$(cat engines.txt 2>/dev/null)" != "$engines $types" ]; then
  rm -rf node_modules package.json
  echo '{ "private": true }' >package.json
  # shellcheck disable=SC2086
  npm install --ignore-scripts --no-package-lock --no-audit --no-fund --loglevel=error $engines $types >/dev/null
  # These two are whole in one file; what else they name is not needed, and A-Frame names a repository.
  for package in aframe@1.8.0 @google/model-viewer@4.4.0; do
    tarball=$(npm pack --silent "$package")
    mkdir -p "node_modules/${package%@*}"
    tar -xzf "$tarball" -C "node_modules/${package%@*}" --strip-components=1
    rm "$tarball"
  done
  echo "$engines $types" >engines.txt
fi
# The package as somebody gets it.
rm -rf node_modules/facebaker src
mkdir node_modules/facebaker
tarball=$(cd "$web" && npm pack --silent --pack-destination "$work")
tar -xzf "$tarball" -C node_modules/facebaker --strip-components=1
rm "$tarball"
cp -r "$root/bindings/web/tests/viewers" src
rm -rf "$web/tests" "$web/tests-built"
cp -r "$root/bindings/web/tests" "$web"
(cd "$web" && npx tsc -p tests)
node "$web/tests-built/viewers/docs_examples.js" "$root/docs/web-engines.md" src/examples
"$web/node_modules/.bin/tsc" -p src

viewers=""
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  viewers="$viewers $1"
  shift
done
[ $# -eq 0 ] || shift
golden=$root/tests/golden
archives=""
for archive in "$golden/2.0/accepted/character.fbk" "$golden/2.0/accepted/body.fbk" "$golden/2.1/accepted/driven.fbk" "$@"; do
  name=$(basename "$archive" .fbk)
  case $archive in /*) ;; *) archive=$root/$archive ;; esac
  cp "$archive" "archives/$name.fbk"
  "$build/bin/facebaker" export "archives/$name.fbk" "archives/$name.glb" --shapes 1000 >/dev/null
  archives="$archives $work/archives/$name.fbk"
done
# shellcheck disable=SC2086
node "$web/tests-built/viewers/run_viewers.js" "$work" $viewers -- $archives
