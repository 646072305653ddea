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
python3 bindings/unreal/pack_plugin.py --out "$work/FaceBaker" --library Linux="$build/lib/libfacebaker.so"
python3 -m json.tool "$work/FaceBaker/FaceBaker.uplugin" > /dev/null

# The engine's names of headers, and what its header tool would generate.
stubs=$work/stubs
mkdir "$stubs"
for header in CoreMinimal.h UObject/Object.h ProceduralMeshComponent.h Components/SkeletalMeshComponent.h \
  Engine/SkeletalMesh.h Factories/Factory.h Misc/FeedbackContext.h Misc/FileHelper.h Modules/ModuleManager.h; do
  mkdir -p "$(dirname "$stubs/$header")"
  echo '#include "unreal_stub_core.h"' > "$stubs/$header"
done
for class in Asset Component Factory; do : > "$stubs/FaceBaker$class.generated.h"; done
source=$work/FaceBaker/Source
${CXX:-c++} -std=c++17 -O1 -g -Wall -Wextra -Wno-unused-parameter -Werror -I"$stubs" -Ibindings/unreal/tests/unreal_stubs \
  -I"$source/ThirdParty/FaceBaker/include" -I"$source/FaceBaker/Public" -I"$source/FaceBaker/Private" \
  -I"$source/FaceBakerEditor/Private" "$source"/*/Private/*.cpp bindings/unreal/tests/stubbed_unreal.cpp \
  -o "$work/stubbed_unreal" -L"$build/lib" -lfacebaker
LD_LIBRARY_PATH=$build/lib "$work/stubbed_unreal" "$build/fixtures" "$build/golden/rejected/corrupt-bit.fbk"
