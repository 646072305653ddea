#!/bin/sh
# Builds the npm package into build/web: the WebAssembly modules, the scripts and their types. Installs Emscripten where
# there is none (Debian), and TypeScript and what else package.json names by npm. A page that is developed in this tree
# depends on "file:.../build/web"; `npm pack build/web` makes the tarball.
#   bindings/web/build.sh
set -eu
cd "$(dirname "$0")/../.."
out=build/web
capi/platforms/build_dependencies.sh wasm
for preset in wasm wasm-scalar; do
  cmake --preset $preset >/dev/null
  cmake --build --preset $preset --parallel "$(nproc)" --target facebaker_wasm facebaker_solve_wasm
done
mkdir -p "$out/dist"
sed "s/\"version\": \"[^\"]*\"/\"version\": \"$(head -n 1 VERSION)\"/" bindings/web/package.json >"$out/package.json.new"
if ! cmp -s "$out/package.json.new" "$out/package.json"; then
  mv "$out/package.json.new" "$out/package.json"
  (cd "$out" && npm install --no-package-lock --no-audit --no-fund)
fi
rm -rf "$out/package.json.new" "$out/src"
cp -r bindings/web/src bindings/web/tsconfig.json "$out"
python3 -B bindings/headers/struct_layouts.py typescript "$out/src/struct_layouts.ts"
cp LICENSE bindings/web/README.md "$out"
{
  echo "facebaker.wasm and facebaker_solve.wasm have these libraries in them:"
  for package in zlib xxhash; do
    printf '\n---- %s ----\n\n' "$package"
    cat "build/cross/wasm/$package.copyright"
  done
} >"$out/THIRD-PARTY.txt"
# ES modules, the same as CommonJS (three.js has none of its WebGPURenderer, Babylon.js none at all, and the adapters for
# engines are ES modules alone), and the worker as one script.
rm -rf "$out/cjs"
cp -r "$out/src" "$out/cjs"
for urls in asset_urls solver_urls; do mv "$out/cjs/${urls}_cjs.ts" "$out/cjs/$urls.ts"; done
rm -f "$out/cjs/worker_main.ts" "$out/cjs/three_webgpu.ts" "$out/cjs/aframe.ts" "$out"/cjs/babylon*.ts "$out"/cjs/playcanvas*.ts
echo '{ "type": "commonjs", "sideEffects": false }' | tee "$out/cjs/package.json" >"$out/package.cjs"
sed 's|"src|"cjs|; s|"dist"|"dist/cjs"|' bindings/web/tsconfig.json >"$out/tsconfig.cjs.json"
(
  cd "$out"
  rm -rf dist/*.js dist/*.d.ts dist/cjs
  npx tsc -p .
  npx tsc -p tsconfig.cjs.json
  npx esbuild dist/worker_main.js --bundle --format=iife --target=es2022 --log-level=warning --allow-overwrite \
    --outfile=dist/worker_main.js
  mv package.cjs dist/cjs/package.json
)
for module in facebaker facebaker_solve; do
  cp "build/wasm/bin/$module.wasm" "$out/dist/$module.wasm"
  cp "build/wasm-scalar/bin/$module.wasm" "$out/dist/$module-scalar.wasm"
done
