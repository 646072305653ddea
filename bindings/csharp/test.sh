#!/bin/sh
# Builds the C# package with Mono, which it installs (Debian) where there is none, and tests it: layouts against those of
# the headers, poses bit for bit against the C interface's, broken archives, threads, lifetimes, callbacks, garbage and the
# cost of calls; then the Unity package, packed, against stubs of Unity's classes. Takes a minute.
# With --aot the tests run once more without a JIT compiler, everything compiled ahead of time as IL2CPP does: two minutes.
#   bindings/csharp/test.sh [--aot] [BUILD]
set -eu
cd "$(dirname "$0")/../.."
aot=
case ${1:-} in
  --aot) aot=yes; shift ;;
  -*) echo "usage: bindings/csharp/test.sh [--aot] [BUILD]" >&2; exit 2 ;;
esac
build=$(realpath "${1:-build/release}")
if ! command -v mcs > /dev/null || ! command -v mono > /dev/null; then
  as_root=
  [ "$(id -u)" -eq 0 ] || as_root=sudo
  $as_root apt-get -o DPkg::Lock::Timeout=600 -q update
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -o DPkg::Lock::Timeout=600 -q install -y --no-install-recommends mono-mcs mono-runtime
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export OMP_WAIT_POLICY=PASSIVE PYTHONDONTWRITEBYTECODE=1
package=bindings/csharp
compile="mcs -unsafe -langversion:latest -warn:4 -warnaserror"
# The library lies beside the program, as in what a user ships.
cp "$build/lib/engines/libfacebaker.so" "$work/"
link="-L$work -lfacebaker -Wl,-rpath,\$ORIGIN"
cc="${CC:-cc} -std=c99 -Wall -Wextra -Werror -O2 -Icapi/include"

python3 $package/generate_interop.py --headers capi/include/facebaker --out "$work/NativeInterop.cs"
$compile -target:library -out:"$work/FaceBaker.dll" -doc:"$work/FaceBaker.xml" $package/runtime/*.cs "$work/NativeInterop.cs"
$compile -r:"$work/FaceBaker.dll" -out:"$work/layouts.exe" $package/tests/PrintLayouts.cs
tests="$package/tests/CheckMain.cs $package/tests/LoadTests.cs $package/tests/PoseTests.cs $package/tests/BatchTests.cs
  $package/tests/LifetimeTests.cs $package/tests/RenderTests.cs $package/tests/SolverTests.cs $package/tests/CostTests.cs"
$compile -r:"$work/FaceBaker.dll" -out:"$work/tests.exe" $tests

python3 bindings/headers/struct_layouts.py list "$work/layouts"
sort "$work/layouts" > "$work/c.layout"
mono "$work/layouts.exe" | sort > "$work/mono.layout"
diff "$work/c.layout" "$work/mono.layout"
echo "layouts of $(grep -vc '\.' "$work/c.layout") structs are those of the headers"

$cc bindings/engine/tests/dump_poses.c -o "$work/dump_poses" $link
$cc -shared -fPIC $package/tests/time_calls.c -o "$work/libtimecalls.so" $link
mkdir "$work/poses" "$work/data"
cp -rL "$build/fixtures" "$build/golden" "$work/data/"
[ ! -e "$build/../quickstart/sample.fbk" ] || cp "$build/../quickstart/sample.fbk" "$work/data/"
for face in "$work"/data/fixtures/*.fbk "$work"/data/golden/accepted/regular.fbk "$work"/data/golden/accepted/uvs.fbk \
  "$work"/data/golden/accepted/driven-exact-levels.fbk "$work"/data/golden/accepted/driven-split-rows.fbk "$work/data/sample.fbk"; do
  [ -e "$face" ] || continue  # the quickstart's, where it was run
  name=$(basename "$face" .fbk)
  "$work/dump_poses" "$face" "$work/poses/$name.poses"
  echo "$face" > "$work/poses/$name.path"
done
bindings/engine/tests/run_packed.sh "$work" "$build" mono ./tests.exe data poses

# The blocks of the pages: docs/csharp.md is a program with a class, docs/unity.md a script of the package.
mkdir "$work/pages"
python3 - "$work/pages" << 'END'
import pathlib, sys
sys.path.insert(0, "tests/docs")
from doc_pages import read_blocks
for page in ("csharp", "unity"):
    blocks = [block.text for block in read_blocks(".", f"docs/{page}.md") if block.language == "csharp"]
    for number, text in enumerate(blocks):
        pathlib.Path(sys.argv[1], f"{page}_{number}.cs").write_text(text, encoding="utf-8")
END
$compile -r:"$work/FaceBaker.dll" -out:"$work/page.exe" "$work"/pages/csharp_*.cs
bindings/engine/tests/run_packed.sh "$work" "$build" mono ./page.exe data/fixtures/character.fbk

# The Unity package as it is packed, in one assembly with stubs of Unity's classes, beside its library as in a player.
python3 $package/pack_unity.py --out "$work/unity" --library linux-x64="$build/lib/engines/libfacebaker.so"
python3 $package/tests/check_package.py "$work/unity"
mkdir "$work/player"
cp "$work/unity/Plugins/linux-x64/libfacebaker.so" "$work/player/"
cp -r "$work/data" "$work/poses" "$work/player/"
$compile -define:UNITY_5_3_OR_NEWER -out:"$work/player/stubbed_unity.exe" "$work"/unity/Runtime/*.cs "$work"/unity/Editor/*.cs \
  $package/tests/unity_stubs/*.cs $package/tests/CheckMain.cs $package/tests/StubbedUnityTests.cs "$work"/pages/unity_*.cs
bindings/engine/tests/run_packed.sh "$work/player" "$build" mono ./stubbed_unity.exe data poses

[ -n "$aot" ] || exit 0
mkdir "$work/aot"
cp "$work/FaceBaker.dll" "$work/tests.exe" "$work"/*.so "$work/aot/"
libraries=$(dirname "$(dirname "$(realpath "$(command -v mono)")")")/lib/mono/4.5
for assembly in mscorlib System System.Core System.Configuration System.Xml System.Security System.Numerics Mono.Security; do
  cp -L "$libraries/$assembly.dll" "$work/aot/"
done
cd "$work/aot"
export MONO_PATH=$work/aot
for assembly in *.dll tests.exe; do mono --aot=full "$assembly" > log 2>&1 || { cat log >&2; exit 1; }; done
echo "ahead of time:"
mono --full-aot tests.exe "$work/data" "$work/poses"
