/* The plugin for Unreal over stubs of its classes, which call what the engine would; that it does so is not tested
 * here.
 *
 *     stubbed_unreal FIXTURES BROKEN.fbk
 */
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include "FaceBakerAsset.h"
#include "FaceBakerComponent.h"
#include "FaceBakerFactory.h"
#include "UnrealFace.h"

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

/* A bone that has moved moves the vertices of its joint as far. */
void check_skeleton(UFaceBakerAsset* asset) {
  UFaceBakerComponent component{FObjectInitializer()};
  USkeletalMeshComponent skeleton;
  component.Asset = asset;
  component.Skeleton = &skeleton;
  component.OnRegister();
  std::string error;
  const auto model = asset->Load();
  const auto names = facebaker::unreal::UnrealFace::make(*model, error)->joint_names();
  that(!names.empty(), "the face has joints");
  for (const std::string& joint : names) {
    skeleton.mesh.skeleton.names.push_back(joint);
    skeleton.mesh.skeleton.places.Add({FVector(0, 0, 1)});
    skeleton.mesh.skeleton.parents.push_back(-1);
    skeleton.bones.push_back({FVector(5, 0, 1)});  // all have moved by 5 along x
  }
  const UProceduralMeshComponent::StubSection rest = component.sections[0];
  tick(component);
  const UProceduralMeshComponent::StubSection& moved = component.sections[0];
  bool all = rest.vertices.Num() > 0;
  for (int32 i = 0; i < rest.vertices.Num(); ++i)
    all = all && std::abs(moved.vertices[i].X - rest.vertices[i].X - 5) < 1e-2 &&
          std::abs(moved.vertices[i].Z - rest.vertices[i].Z) < 1e-2;
  that(all, "vertices follow the bones");
}

}  // namespace

bool FFileHelper::LoadFileToArray(TArray<uint8>& to, const char* path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  for (std::istreambuf_iterator<char> at(file), end; at != end; ++at) to.Add(static_cast<uint8>(*at));
  return true;
}

int main(int count, char** arguments) {
  if (count != 3) return std::fputs("usage: stubbed_unreal FIXTURES BROKEN.fbk\n", stderr), 2;
  const std::string fixtures = arguments[1];
  FFeedbackContext context;
  UFaceBakerAsset* face = import_file(fixtures + "/character.fbk", context);
  that(face && context.sentences.empty(), "an archive is imported");
  if (!face) return 1;
  check_component(face);
  UFaceBakerAsset* body = import_file(fixtures + "/body.fbk", context);
  that(body != nullptr, "so is one with a skin");
  if (body) check_skeleton(body);
  that(!import_file(arguments[2], context) && context.sentences.size() == 1, "a broken one is refused");
  that(!import_file(fixtures + "/no such file", context) && context.sentences.size() == 2,
       "so is one that is not there");
  UFaceBakerAsset damaged;
  damaged.Archive.Add(1);
  that(!damaged.Load() && !stub_log().empty(), "a damaged asset is logged");
  delete face;
  delete body;
  std::printf("%d checks over stubs of Unreal, %d failed\n", checks, failures);
  return failures == 0 ? 0 : 1;
}
