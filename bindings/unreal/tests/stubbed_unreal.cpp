/* The plugin for Unreal over stubs of its classes, which call what the engine would; that it does so is not tested
 * here.
 *
 *     stubbed_unreal FIXTURES BROKEN.fbk PLUGIN
 *
 * PLUGIN: the packed plugin, whose library is to be the one that is loaded.
 */
#include <dlfcn.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include <facebaker/facebaker_character.h>

#include "FaceBakerAsset.h"
#include "FaceBakerComponent.h"
#include "FaceBakerFactory.h"
#include "UnrealFace.h"

std::unique_ptr<IModuleInterface> stub_module_FaceBaker();

namespace {

int checks = 0, failures = 0;

void that(bool holds, const char* what) {
  ++checks;
  if (holds) return;
  ++failures;
  std::fprintf(stderr, "not so: %s\n", what);
}

UFaceBakerAsset* import_file(const std::string& path, FFeedbackContext& context) {
  UFaceBakerFactory factory{FObjectInitializer()};
  bool cancelled = true;
  UObject* made =
      factory.FactoryCreateFile(nullptr, nullptr, "face", RF_NoFlags, path.c_str(), "", &context, cancelled);
  that(!cancelled, "the import is not cancelled");
  return static_cast<UFaceBakerAsset*>(made);
}

void tick(UFaceBakerComponent& component) {
  component.TickComponent(0.016f, LEVELTICK_All, nullptr);
}

void check_component(UFaceBakerAsset* asset) {
  UFaceBakerComponent component{FObjectInitializer()};
  component.Asset = asset;
  component.OnRegister();
  const auto model = asset->Load();
  that(model.use_count() > 1, "the face is shared");
  that(!component.sections.empty(), "there are sections");
  const std::string name = model->control(0).name;
  that(component.SetControl(name.c_str(), model->control(0).maximum), "a control is set by its name");
  tick(component);
  const UProceduralMeshComponent::StubSection posed = component.sections[0];
  that(posed.updates == 1, "the section is updated");
  double motion = 0;
  for (int32 i = 0; i < posed.vertices.Num(); ++i)
    motion += std::abs(posed.motion_xy[i].X) + std::abs(posed.motion_xy[i].Y);
  that(motion > 0, "there is motion");

  std::string error;
  const auto expected = facebaker::unreal::UnrealFace::make(*model, error);
  expected->pose().set_control(0, model->control(0).maximum);
  expected->update(error);
  const std::vector<float>& positions = expected->buffers(0).positions;
  bool same = static_cast<std::size_t>(posed.vertices.Num()) * 3 == positions.size();
  for (int32 i = 0; same && i < posed.vertices.Num(); ++i)
    same = static_cast<float>(posed.vertices[i].Y) == positions[static_cast<std::size_t>(3 * i + 1)];
  that(same, "vertices are those of the engine-free part");

  tick(component);
  that(component.sections[0].updates == 2 && component.sections[0].motion_xy[0].X == 0, "then motion is 0");
  tick(component);
  that(component.sections[0].updates == 2, "and nothing more is updated");
  that(!component.SetControl("no such control", 1) && component.OnFailed.sent.size() == 1,
       "an unknown control is refused");
  component.SetControlAt(0, std::nanf(""));
  tick(component);
  tick(component);
  that(component.OnFailed.sent.size() == 2, "NaN is reported once");
  that(component.OnFailed.sent.back().find(name) != std::string::npos, "by the control's name");
  component.ResetControls();
  tick(component);
  that(component.sections[0].updates == 3, "it goes on");
  that(!component.SetControls(TArray<float>{1}), "a pose of the wrong length is refused");
  component.OnUnregister();
  that(!component.SetControlAt(0, 1), "it is closed");
}

/* The triangles are those of the level that is posed, and vertices those that they have. */
void check_levels(UFaceBakerAsset* asset) {
  UFaceBakerComponent component{FObjectInitializer()};
  component.Asset = asset;
  component.OnRegister();
  const auto model = asset->Load();
  std::string error;
  const auto expected = facebaker::unreal::UnrealFace::make(*model, error);
  const auto& levels = expected->sections()[0].levels;
  that(levels.size() > 1 && levels[1].indices.size() < levels[0].indices.size(), "there are levels");
  const float shown[] = {0, 1.5f, 9, 1, 0};
  for (const float lod : shown) {
    component.LevelOfDetail = lod;
    component.SetControlAt(0, model->control(0).maximum * (lod + 1) / 10);
    tick(component);
    const std::size_t level = std::min(static_cast<std::size_t>(lod), levels.size() - 1);
    const UProceduralMeshComponent::StubSection& section = component.sections[0];
    that(static_cast<std::size_t>(section.indices.Num()) == levels[level].indices.size(), "a level has its triangles");
    that(static_cast<std::size_t>(section.vertices.Num()) == levels[level].vertex_count, "and their vertices");
    expected->pose().set_lod(lod);
    expected->pose().set_control(0, model->control(0).maximum * (lod + 1) / 10);
    expected->update(error);
    const float y = expected->buffers(0).positions[1];
    that(static_cast<float>(section.vertices[0].Y) == y, "which are posed");
    bool within = true;
    for (int32 i = 0; i < section.indices.Num(); ++i) within = within && section.indices[i] < section.vertices.Num();
    that(within, "triangles have vertices that are written");
  }
  that(component.sections[0].made == 5, "sections are made anew where the level changes");
}

/* Crowds stop at faces that nobody sees. */
void check_visibility(UFaceBakerAsset* asset) {
  UFaceBakerComponent component{FObjectInitializer()};
  component.Asset = asset;
  component.rendered = false;
  component.OnRegister();
  const auto model = asset->Load();
  const auto move = [&](float part) {
    component.SetControlAt(0, model->control(0).maximum * part);
    tick(component);
    return component.sections[0].updates;
  };
  that(move(0.1f) == 1, "the first pose is made whether a face is seen or not");
  that(move(0.2f) == 1, "then none while nobody sees it");
  component.bPoseWhenNotRendered = true;
  that(move(0.3f) == 2, "but where that is asked for");
  component.bPoseWhenNotRendered = false;
  that(move(0.9f) == 2, "and not otherwise");
  component.rendered = true;
  tick(component);
  that(component.sections[0].updates == 3, "it goes on where it is seen again");
  bool still = true;
  for (int32 i = 0; i < component.sections[0].vertices.Num(); ++i)
    still = still && component.sections[0].motion_xy[i].X == 0 && component.sections[0].motion_xy[i].Y == 0;
  that(still, "without motion since it was seen last");
}

/* A skeleton with a bone for each joint, all of them at this height at rest, and moved from there by 5 along x. */
void make_skeleton(USkeletalMeshComponent& skeleton, const std::vector<std::string>& joints, double height) {
  for (const std::string& joint : joints) {
    skeleton.mesh.skeleton.names.push_back(joint);
    skeleton.mesh.skeleton.places.Add({FVector(0, 0, height)});
    skeleton.mesh.skeleton.parents.push_back(-1);
    skeleton.bones.push_back({FVector(5, 0, height)});
  }
}

using StubSection = UProceduralMeshComponent::StubSection;

void check_moved(const StubSection& rest, const StubSection& moved, double x, const char* what) {
  bool all = rest.vertices.Num() > 0 && rest.vertices.Num() == moved.vertices.Num();
  for (int32 i = 0; all && i < rest.vertices.Num(); ++i) {
    all = std::abs(moved.vertices[i].X - rest.vertices[i].X - x) < 1e-2 &&
          std::abs(moved.vertices[i].Z - rest.vertices[i].Z) < 1e-2;
    if (!all) std::fprintf(stderr, "vertex %d went from z %g to %g\n", i, rest.vertices[i].Z, moved.vertices[i].Z);
  }
  that(all, what);
}

/* A bone that has moved moves the vertices of its joint as far, whatever skeleton it was of before. */
void check_skeleton(UFaceBakerAsset* asset) {
  UFaceBakerComponent component{FObjectInitializer()};
  USkeletalMeshComponent skeleton, higher, other;
  component.Asset = asset;
  component.Skeleton = &skeleton;
  component.OnRegister();
  std::string error;
  const auto model = asset->Load();
  const auto names = facebaker::unreal::UnrealFace::make(*model, error)->joint_names();
  that(!names.empty(), "the face has joints");
  make_skeleton(skeleton, names, 1);
  make_skeleton(higher, names, 100);
  make_skeleton(other, {"a bone of nothing"}, 1);
  const StubSection rest = component.sections[0];
  tick(component);
  check_moved(rest, component.sections[0], 5, "vertices follow the bones");
  component.Skeleton = &higher;
  component.Reload();
  tick(component);
  check_moved(rest, component.sections[0], 5, "and those of another skeleton once the asset is loaded anew");
  component.Skeleton = &skeleton;
  tick(component);
  check_moved(rest, component.sections[0], 5, "and at once");
  component.Skeleton = &other;
  tick(component);
  check_moved(rest, component.sections[0], 0, "without bones of their names they are at rest");
}

double frame_at(const FTransform& place, int row, int column) {  // of rows: vectors come first
  return place.ToMatrixWithScale().M[row][column];
}

/* Controls move a driven joint, and bones take it along with the vertices around it. */
void check_driven_joints(UFaceBakerAsset* asset) {
  UFaceBakerComponent component{FObjectInitializer()};
  component.Asset = asset;
  that(component.GetDrivenJoints().Num() == 0, "before a face is loaded there are no driven joints");
  component.OnRegister();
  const auto model = asset->Load();
  const TArray<FFaceBakerDrivenJoint> joints = component.GetDrivenJoints();
  that(joints.Num() == static_cast<int32>(fb_driven_joint_count(model->get())) && joints.Num() > 0,
       "there are driven joints");
  std::string error;
  const auto expected = facebaker::unreal::UnrealFace::make(*model, error);
  for (int32 i = 0; i < joints.Num(); ++i) {
    that(component.FindDrivenJoint(joints[i].Name) == i, "a driven joint is found by its name");
    that(joints[i].Parent < i, "it comes after its parent");
    that(joints[i].Numbers == static_cast<int32>(expected->driven_joints()[static_cast<std::size_t>(i)].numbers),
         "it has its numbers");
    that(joints[i].OuterRotations ==
             static_cast<int32>(expected->driven_joints()[static_cast<std::size_t>(i)].outer_rotations),
         "and outer rotations");
    const float* rest = expected->driven_joints()[static_cast<std::size_t>(i)].rest.data();
    that(frame_at(joints[i].Rest, 0, 1) == rest[4] && frame_at(joints[i].Rest, 3, 2) == rest[11], "and its frame");
  }
  that(component.FindDrivenJoint("no such joint") == -1 &&
           component.OnFailed.sent.back().find("jaw") != std::string::npos,
       "an unknown one is refused by those there are");
  that(frame_at(component.GetDrivenJoint(99), 3, 0) == 0, "and is at the origin");
  for (std::uint32_t c = 0; c < model->control_count(); ++c) {
    component.SetControlAt(static_cast<int32>(c), model->control(c).maximum);
    expected->pose().set_control(c, model->control(c).maximum);
  }
  const FTransform before = component.GetDrivenJoint(0);
  tick(component);
  expected->update(error);
  float frame[12];
  expected->driven_joint_frame(0, frame);
  const FTransform posed = component.GetDrivenJoint(0);
  that(frame_at(before, 0, 1) != frame_at(posed, 0, 1), "a pose moves the joint");
  bool same = true;
  for (int i = 0; i < 12; ++i) same = same && frame_at(posed, i % 4, i / 4) == static_cast<double>(frame[i]);
  that(same, "its frame is that of the engine-free part");

  USkeletalMeshComponent skeleton;
  make_skeleton(skeleton, expected->joint_names(), 1);
  component.Skeleton = &skeleton;
  tick(component);
  that(std::abs(frame_at(component.GetDrivenJoint(0), 3, 0) - frame_at(posed, 3, 0) - 5) < 1e-2,
       "bones that move by 5 move the joint by 5");
}

/* Windows: the plugin's own library is loaded as long as the module runs. */
void check_module(const std::string& folder) {
  const std::string library = folder + "/Source/ThirdParty/FaceBaker/Win64/facebaker.dll";
  auto& plugin = IPluginManager::Get().plugins["FaceBaker"] = std::make_shared<IPlugin>();
  plugin->folder = folder.c_str();
  const auto module = stub_module_FaceBaker();
  module->StartupModule();
  that(FPlatformProcess::loaded == std::vector<std::string>{library}, "the module loads the plugin's library");
  that(FPlatformProcess::folders.empty(), "the search path is as it was");
  module->ShutdownModule();
  that(FPlatformProcess::loaded.empty(), "and frees it");
  plugin->folder = "no such folder";
  const std::size_t logged = stub_log().size();
  module->StartupModule();
  that(stub_log().size() == logged + 1 && stub_log().back().find("facebaker.dll") != std::string::npos,
       "a library that is not there is logged");
  module->ShutdownModule();
}

/* What this process runs is the library in the package. */
void check_library(const std::string& plugin) {
  Dl_info info = {};
  char found[4096], expected[4096];
  that(dladdr(reinterpret_cast<void*>(&fb_load), &info) != 0 && realpath(info.dli_fname, found) &&
           realpath((plugin + "/Source/ThirdParty/FaceBaker/Linux/libfacebaker.so").c_str(), expected) &&
           std::string(found) == expected,
       "the library is the packed one");
}

}  // namespace

void* FPlatformProcess::GetDllHandle(const char* file) {
  const std::string path = file;
  if (folders.empty() || folders.back() != path.substr(0, path.rfind('/')) || !std::ifstream(path)) return nullptr;
  loaded.push_back(path);
  return &loaded;
}

bool FFileHelper::LoadFileToArray(TArray<uint8>& to, const char* path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  for (std::istreambuf_iterator<char> at(file), end; at != end; ++at) to.Add(static_cast<uint8>(*at));
  return true;
}

int main(int count, char** arguments) {
  if (count != 4) return std::fputs("usage: stubbed_unreal FIXTURES BROKEN.fbk PLUGIN\n", stderr), 2;
  check_library(arguments[3]);
  check_module(arguments[3]);
  const std::string fixtures = arguments[1];
  FFeedbackContext context;
  UFaceBakerAsset* face = import_file(fixtures + "/character.fbk", context);
  that(face && context.sentences.empty(), "an archive is imported");
  if (!face) return 1;
  that(face->AssetImportData && face->AssetImportData->file == (fixtures + "/character.fbk").c_str(),
       "the editor knows its file");
  check_component(face);
  check_visibility(face);
  UFaceBakerAsset* levels = import_file(fixtures + "/levels.fbk", context);
  that(levels != nullptr, "so is one with levels of detail");
  if (levels) check_levels(levels);
  UFaceBakerAsset* body = import_file(fixtures + "/body.fbk", context);
  that(body != nullptr, "so is one with a skin");
  if (body) check_skeleton(body);
  UFaceBakerAsset* driven = import_file(fixtures + "/driven.fbk", context);
  that(driven != nullptr, "so is one with driven joints and a skin");
  if (driven) check_skeleton(driven);
  if (driven) check_driven_joints(driven);
  that(!import_file(arguments[2], context) && context.sentences.size() == 1, "a broken one is refused");
  that(!import_file(fixtures + "/no such file", context) && context.sentences.size() == 2,
       "so is one that is not there");
  UFaceBakerAsset damaged;
  damaged.Archive.Add(1);
  that(!damaged.Load() && !stub_log().empty(), "a damaged asset is logged");
  delete face->AssetImportData;
  delete face;
  if (levels) delete levels->AssetImportData;
  delete levels;
  if (body) delete body->AssetImportData;
  delete body;
  if (driven) delete driven->AssetImportData;
  delete driven;
  std::printf("%d checks over stubs of Unreal, %d failed\n", checks, failures);
  return failures == 0 ? 0 : 1;
}
