#!/bin/sh
# Packs the plugin for Unreal, compiles it against stubs of Unreal's classes, and runs its importer and component over them.
# Nothing here is Unreal: that the engine takes the plugin is not tested.
# Its build rules are run by Mono, which it installs (Debian) where there is none. Takes half a minute.
#   bindings/unreal/test.sh [BUILD]
set -eu
cd "$(dirname "$0")/../.."
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
export PYTHONDONTWRITEBYTECODE=1 OMP_WAIT_POLICY=PASSIVE
# Windows' files are no libraries, and AArch64's is this machine's: what their names do is tested; Windows' are those of
# docs/platforms.md.
names=$(sed -n 's/^lib .*\/name:\([^ ]*\) \/out:\([^ ]*\)$/\1 \2/p' docs/platforms.md)
dll=${names% *} import=${names#* }
mkdir "$work/windows" "$work/packed"
echo none > "$work/windows/$dll"
echo none > "$work/windows/$import"
python3 bindings/unreal/pack_plugin.py --out "$work/packed/FaceBaker" --library Linux="$build/lib/engines/libfacebaker.so" \
  --library LinuxArm64="$build/lib/engines/libfacebaker.so" --library Win64="$work/windows/$dll" --library Win64="$work/windows/$import"
rm -r "$work/windows"
plugin=$work/packed/FaceBaker
python3 -m json.tool "$plugin/FaceBaker.uplugin" > /dev/null
# The build rules, as Unreal's build tool would ask for them.
mcs -langversion:latest -warn:4 -warnaserror -out:"$work/build_rules.exe" "$plugin"/Source/*/*.Build.cs bindings/unreal/tests/*.cs
mono "$work/build_rules.exe" "$plugin"

# The engine's names of headers, and what its header tool would generate.
stubs=$work/stubs
mkdir "$stubs"
for header in CoreMinimal.h UObject/Object.h UObject/WeakObjectPtr.h ProceduralMeshComponent.h \
  Components/SkeletalMeshComponent.h Engine/SkeletalMesh.h EditorFramework/AssetImportData.h Factories/Factory.h \
  HAL/PlatformProcess.h Interfaces/IPluginManager.h Misc/FeedbackContext.h Misc/FileHelper.h Misc/Paths.h \
  Modules/ModuleManager.h; do
  mkdir -p "$(dirname "$stubs/$header")"
  echo '#include "unreal_stub_core.h"' > "$stubs/$header"
done
for class in Asset Component Factory; do : > "$stubs/FaceBaker$class.generated.h"; done
source=$plugin/Source
# What of an asset is cooked: its archive, and no path of the machine that imported it.
cooked=$(${CXX:-c++} -std=c++17 -E -P -DWITH_EDITORONLY_DATA=0 -D'UPROPERTY(...)=cooked' -I"$stubs" \
  -Ibindings/unreal/tests/unreal_stubs -include "$source/FaceBaker/Public/FaceBakerAsset.h" -x c++ /dev/null |
  tr -s ' \n' ' ' | grep -o 'cooked [^;]*;')
[ "$cooked" = "cooked TArray<uint8> Archive;" ] || { echo "not so: of an asset its archive alone is cooked: $cooked" >&2; exit 1; }

third_party=Source/ThirdParty/FaceBaker
${CXX:-c++} -std=c++17 -O1 -g -Wall -Wextra -Wno-unused-parameter -Werror -I"$stubs" -Ibindings/unreal/tests/unreal_stubs \
  -I"$plugin/$third_party/include" -I"$source/FaceBaker/Public" -I"$source/FaceBaker/Private" \
  -I"$source/FaceBakerEditor/Private" "$source"/*/Private/*.cpp bindings/unreal/tests/stubbed_unreal.cpp \
  -o "$work/packed/stubbed_unreal" -L"$plugin/$third_party/Linux" -lfacebaker \
  -Wl,-rpath,"\$ORIGIN/FaceBaker/$third_party/Linux" -ldl

cp -rL "$build/fixtures" "$build/golden/rejected/corrupt-bit.fbk" "$work/packed/"
bindings/engine/tests/run_packed.sh "$work/packed" "$build" ./stubbed_unreal fixtures corrupt-bit.fbk "$plugin"
