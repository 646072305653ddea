#!/bin/sh
# Tests GpuEvaluator of the npm package, "facebaker/webgpu", in Node by Dawn (npm's "webgpu", 130 MB), on SwiftShader, the
# software adapter of Debian's Chromium: every bit of positions against the processor's, of the golden archives and of a
# crowd of faces. Installs what is missing.
#   bindings/web/test_webgpu.sh [ARCHIVE]
# ARCHIVE is posed FB_FACES x FB_POSES times (1000 x 64). FB_GPU=1: on the GPU of this machine, in place of SwiftShader.
set -eu
cd "$(dirname "$0")/../.."
root=$PWD
web=$root/build/web
dawn=$root/build/dawn
if ! command -v chromium >/dev/null; then
  apt-get -q install -y --no-install-recommends -o DPkg::Lock::Timeout=600 chromium
fi
bindings/web/build.sh
mkdir -p "$dawn"
if [ ! -e "$dawn/node_modules/webgpu" ]; then
  (cd "$dawn" && npm init -y >/dev/null && npm install --no-audit --no-fund webgpu@0.6.2)
fi
rm -rf "$web/tests" "$web/tests-built"
cp -r bindings/web/tests "$web"
(cd "$web" && npx tsc -p tests)
[ -n "${FB_GPU:-}" ] || export VK_ICD_FILENAMES="${VK_ICD_FILENAMES:-/usr/lib/chromium/vk_swiftshader_icd.json}"
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-/tmp}"
archives=$(echo "$root"/tests/golden/2.0/accepted/*.fbk "$root"/tests/golden/2.1/accepted/*.fbk)
crowd=""
[ $# -eq 0 ] || crowd=$(realpath "$1")
cd "$web"
FB_DAWN=file://$dawn/node_modules/webgpu/index.js FB_ARCHIVES=$archives FB_CROWD=$crowd \
  node --test --test-force-exit tests-built/dawn/test_gpu_evaluator.js
