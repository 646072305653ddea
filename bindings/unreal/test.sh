#!/bin/sh
# Packs the plugin for Unreal, compiles it against stubs of Unreal's classes, and runs its importer and component over them.
# Nothing here is Unreal: that the engine takes the plugin is not tested. Takes half a minute.
#   bindings/unreal/test.sh [BUILD]
set -eu
cd "$(dirname "$0")/../.."
build=$(realpath "${1:-build/release}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export PYTHONDONTWRITEBYTECODE=1 OMP_WAIT_POLICY=PASSIVE
mkdir "$work/packed"
plugin=$work/packed/FaceBaker
python3 bindings/unreal/pack_plugin.py --out "$plugin" --library Linux="$build/lib/engines/libfacebaker.so"
python3 -m json.tool "$plugin/FaceBaker.uplugin" > /dev/null

# The engine's names of headers, and what its header tool would generate.
stubs=$work/stubs
mkdir "$stubs"
for header in CoreMinimal.h UObject/Object.h ProceduralMeshComponent.h Components/SkeletalMeshComponent.h \
  Engine/SkeletalMesh.h Factories/Factory.h Misc/FeedbackContext.h Misc/FileHelper.h Modules/ModuleManager.h; do
  mkdir -p "$(dirname "$stubs/$header")"
  echo '#include "unreal_stub_core.h"' > "$stubs/$header"
done
for class in Asset Component Factory; do : > "$stubs/FaceBaker$class.generated.h"; done
source=$plugin/Source
third_party=Source/ThirdParty/FaceBaker
${CXX:-c++} -std=c++17 -O1 -g -Wall -Wextra -Wno-unused-parameter -Werror -I"$stubs" -Ibindings/unreal/tests/unreal_stubs \
  -I"$plugin/$third_party/include" -I"$source/FaceBaker/Public" -I"$source/FaceBaker/Private" \
  -I"$source/FaceBakerEditor/Private" "$source"/*/Private/*.cpp bindings/unreal/tests/stubbed_unreal.cpp \
  -o "$work/packed/stubbed_unreal" -L"$plugin/$third_party/Linux" -lfacebaker \
  -Wl,-rpath,"\$ORIGIN/FaceBaker/$third_party/Linux"

cp -rL "$build/fixtures" "$build/golden/rejected/corrupt-bit.fbk" "$work/packed/"
bindings/engine/tests/run_packed.sh "$work/packed" "$build" ./stubbed_unreal fixtures corrupt-bit.fbk
