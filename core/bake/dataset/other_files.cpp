#include "bake/dataset/other_files.h"

#include <string_view>

#include "base/file_extension.h"

namespace fb::bake {
namespace {

// What is no source by itself: suffixes, each with a blank behind it, and what to do.
struct OtherFile {
  std::string_view suffixes;
  const char* words;
};

constexpr OtherFile other_files[] = {
    {".blend ", "a scene of Blender, whose add-on bakes it: facebaker bake FILE --with-blender --out FACE.fbk"},
    {".fbx .dae .usd .usda .usdc .usdz ",
     "Blender imports it, and the add-on bakes that: facebaker bake FILE --with-blender --out FACE.fbk"},
    {".ma .mb ",
     "a scene of Maya, which evaluates planned poses by samples/exporters/maya_exporter.py: facebaker plan, then bake "
     "the dataset folder"},
    {".hip .hiplc .hipnc ",
     "a scene of Houdini, which evaluates planned poses by samples/exporters/houdini_exporter.py: facebaker plan, then "
     "bake the dataset folder"},
    {".uasset ",
     "an asset of Unreal, which evaluates planned poses by samples/exporters/unreal_exporter.py: facebaker plan, then "
     "bake the dataset folder"},
    {".dna ", "samples/exporters/riglogic_rig.py bakes it: python3 riglogic_rig.py FILE FACE.fbk"},
    {".npy .mdd .pc2 ", "positions without a rig: a dataset folder has them beside control values and the rest mesh"},
    {".abc ",
     "positions without controls: a dataset folder has them, as .npy, .mdd or .pc2, beside control values and the rest "
     "mesh"},
    {".obj .ply .stl ", "a mesh that does not move: a dataset folder has poses of it beside control values"},
    {".csv ", "control values without a face: pose plays them, and --poses-like trains near them"},
    {".fbk ", "a baked face; its source is the rig that it was baked from"},
};

}  // namespace

std::string way_to_bake(const std::filesystem::path& file) {
  const std::string suffix = file_extension(file) + " ";
  if (suffix.size() < 2) return "";
  for (const OtherFile& file_kind : other_files)
    if (file_kind.suffixes.find(suffix) != std::string_view::npos) return file_kind.words;
  return "";
}

}  // namespace fb::bake
