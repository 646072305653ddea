#!/bin/sh
# Builds and runs projects of Vite 6, 7 and 8, webpack 5, esbuild and Next from the packed package, with their development
# servers too, in Chromium: a face is loaded and posed in the page and in a worker, by Next on the server too; checks the
# types that TypeScript finds as CommonJS and as ES modules; and mounts faces in React's StrictMode. All of it has the
# lines of docs/bundlers.md and no others. Takes tools from npm, in the versions below, into build/web-bundlers.
#   bindings/web/test_bundlers.sh [NAME...]
# NAME: some of vite6 vite7 vite8 webpack esbuild next types react; all of them by default. FB_TARBALL: a package to test;
# by default bindings/web/build.sh builds it, unless FB_WEB_BUILT=1 says that build/web has it. FB_FACE: an archive to show.
set -eu
cd "$(dirname "$0")/../.."
root=$PWD
web=$root/build/web
work=$root/build/web-bundlers
face=$(realpath "${FB_FACE:-tests/golden/2.0/accepted/character.fbk}")
projects=$root/bindings/web/tests/bundlers
three="three@0.187.0 @types/three@0.187.0"
react="react@19.3.1 react-dom@19.3.1"
export NEXT_TELEMETRY_DISABLED=1 NO_UPDATE_NOTIFIER=1
if ! command -v chromium >/dev/null; then
  apt-get -q install -y --no-install-recommends -o DPkg::Lock::Timeout=600 chromium
fi
mkdir -p "$work"
[ -n "${FB_WEB_BUILT:-}" ] || [ -n "${FB_TARBALL:-}" ] || bindings/web/build.sh
if [ -n "${FB_TARBALL:-}" ]; then tarball=$(realpath "$FB_TARBALL"); else
  tarball=$work/$(cd "$web" && npm pack --silent --pack-destination "$work")
fi
rm -rf "$web/tests" "$web/tests-built"
cp -r bindings/web/tests "$web"
(cd "$web" && npx tsc -p tests)
check() { node "$web/tests-built/browser/check_bundled.js" "$@"; }

# begin PROJECT FOLDER PACKAGE...: a copy of tests/bundlers/PROJECT with the packed package and others installed.
begin() {
  mkdir -p "$work/$2"
  cd "$work/$2"
  find . -mindepth 1 -maxdepth 1 ! -name node_modules ! -name package.json -exec rm -rf {} +
  cp -r "$projects/$1/." .
  cp "$projects/check_face.js" .
  mkdir -p public
  cp "$face" public/face.fbk
  echo '{ "private": true }' >package.json
  shift 2
  rm -rf node_modules/facebaker node_modules/.vite
  # shellcheck disable=SC2086
  npm install --ignore-scripts --no-package-lock --no-audit --no-fund --prefer-offline --loglevel=error $three "$@" "$tarball" >/dev/null
}

test_vite() {
  begin page "vite$1" "vite@$2"
  npx vite build --logLevel warn
  check "Vite $2, built" "$PWD/dist"
  check "Vite $2, development" "$PWD" npx vite
}
test_vite6() { test_vite 6 6.4.6; }
test_vite7() { test_vite 7 7.3.8; }
test_vite8() { test_vite 8 8.3.8; }

test_webpack() {
  begin page webpack webpack@5.113.0 webpack-cli@7.3.1 webpack-dev-server@5.2.7
  npx webpack ./main.js --mode production --output-path www
  cp index.html public/face.fbk www
  check "webpack 5.113.0, built" "$PWD/www"
  cp index.html public
  check "webpack 5.113.0, development" "$PWD" npx webpack serve --entry ./main.js --mode development
}

test_esbuild() {
  begin page esbuild esbuild@0.28.2
  npx esbuild main.js --bundle --format=esm --outdir=www --log-level=warning
  cp node_modules/facebaker/dist/facebaker*.wasm node_modules/facebaker/dist/worker_main.js www
  cp index.html public/face.fbk www
  check "esbuild 0.28.2, built" "$PWD/www"
}

test_next() {
  # shellcheck disable=SC2086
  begin next next next@16.4.6 $react
  npx next build
  check "Next 16.4.6, built" "$PWD" npx next start --port 0
  check "Next 16.4.6, development" "$PWD" npx next dev --port 0
  npx next build --webpack
  check "Next 16.4.6 by webpack, built" "$PWD" npx next start --port 0
  rm next.config.mjs # which pages do not need
  mv client_page.jsx app/page.jsx
  npx next build
  check "Next 16.4.6, pages alone, built" "$PWD" npx next start --port 0
  check "Next 16.4.6, pages alone, development" "$PWD" npx next dev --port 0
}

test_types() {
  begin types types typescript@5.9.3 @types/node@20 @arethetypeswrong/cli@0.18.5
  cp "$tarball" package.tgz
  options="--strict --target es2022 --lib es2022,dom --types node --skipLibCheck --outDir built"
  # shellcheck disable=SC2086
  {
    npx tsc $options --module nodenext commonjs.cts modules.mts
    node built/commonjs.cjs public/face.fbk
    node built/modules.mjs public/face.fbk
    npx tsc $options --noEmit --module node16 commonjs.cts modules.mts
    npx tsc $options --noEmit --module preserve --moduleResolution bundler modules.mts
    cp commonjs.cts oldest.ts
    npx tsc $options --noEmit --module commonjs --moduleResolution node10 oldest.ts
  }
  # ES modules alone, as three.js' WebGPURenderer and Babylon.js are.
  npx attw package.tgz --format ascii --exclude-entrypoints three-webgpu babylon playcanvas aframe facebaker.wasm facebaker-scalar.wasm \
    facebaker_solve.wasm facebaker_solve-scalar.wasm worker_main.js
}

test_react() {
  # shellcheck disable=SC2086
  begin react react vite@8.3.8 $react
  mv strict_mode.html index.html
  check "React's StrictMode" "$PWD" npx vite # in development, which is where React mounts twice
}

for name in ${*:-vite6 vite7 vite8 webpack esbuild next types react}; do "test_$name"; done
