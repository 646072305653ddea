#!/bin/sh
# A face beside the paper's network in ONNX Runtime, fetched from npm into build/onnx-runtime; both measured in turns.
#   tests/bench/bench_onnx_runtime.sh ARCHIVE [SOURCE]
set -eu
archive=$(realpath "$1")
source=${2:-}
cd "$(dirname "$0")/../.."
folder=build/onnx-runtime
mkdir -p "$folder"
[ -d "$folder/node_modules/onnxruntime-node" ] ||
  npm install --prefix "$folder" --ignore-scripts --no-audit --no-fund onnxruntime-node
cp tests/bench/bench_onnx_runtime.mjs "$folder"
node "$folder/bench_onnx_runtime.mjs" build/release/bin/facebaker "$archive" $source
