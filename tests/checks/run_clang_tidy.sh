#!/bin/sh
# clang-tidy, with the list in .clang-tidy, over core, capi and packager of a build folder.
#   tests/checks/run_clang_tidy.sh [BUILD_FOLDER [FILE...]]
# Without files: all. Installs clang-tidy where it is missing. Exit code 0 only if it finds nothing.
set -eu
cd "$(dirname "$0")/../.."
build=${1:-build/release}
[ $# -eq 0 ] || shift
[ -f "$build/compile_commands.json" ] || { echo "$build: configure it first: cmake --preset release" >&2; exit 2; }
command -v clang-tidy >/dev/null || apt-get install -y -q --no-install-recommends clang-tidy

# Without the options of GCC that clang refuses.
commands=$(mktemp -d)
trap 'rm -rf "$commands"' EXIT
sed 's/ -fno-tree-reassoc//g' "$build/compile_commands.json" >"$commands/compile_commands.json"

[ $# -gt 0 ] || set -- $(git ls-files 'core/*.cpp' 'capi/*.cpp' 'packager/*.cpp')
# Files that this build does not compile, such as kernels for another processor, are left out.
compiled=$(for file in "$@"; do grep -q "/$file\"" "$commands/compile_commands.json" && echo "$file"; done)
echo "$compiled" | xargs -P "$(nproc)" -n 4 clang-tidy -p "$commands" --quiet \
  --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-ignored-optimization-argument
