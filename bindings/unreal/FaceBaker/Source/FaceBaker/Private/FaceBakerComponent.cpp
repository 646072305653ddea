#include "FaceBakerComponent.h"

#include "Components/SkeletalMeshComponent.h"
#include "Engine/SkeletalMesh.h"
#include "FaceBakerAsset.h"
#include "FaceBakerLog.h"
#include "UnrealFace.h"

using facebaker::unreal::UnrealFace;

namespace {

// Of three rows of a matrix for columns; Unreal's are for rows, which come first.
FTransform TransformOfFrame(const float* Frame) {
  FMatrix Matrix;
  for (int32 Row = 0; Row < 3; ++Row)
    for (int32 Column = 0; Column < 4; ++Column) Matrix.M[Column][Row] = Frame[4 * Row + Column];
  for (int32 Row = 0; Row < 4; ++Row) Matrix.M[Row][3] = Row < 3 ? 0 : 1;
  return FTransform(Matrix);
}

}  // namespace

UFaceBakerComponent::UFaceBakerComponent(const FObjectInitializer& Initializer) : Super(Initializer) {
  PrimaryComponentTick.bCanEverTick = true;
  PrimaryComponentTick.TickGroup = TG_PostPhysics;  // after animation has moved the skeleton
  bTickInEditor = true;
}

void UFaceBakerComponent::OnRegister() {
  Super::OnRegister();
  Reload();
}

void UFaceBakerComponent::OnUnregister() {
  Face.reset();
  Model.reset();
  Super::OnUnregister();
}

void UFaceBakerComponent::Fail(const std::string& Error) {
  const FString Message(UTF8_TO_TCHAR(Error.c_str()));
  if (Message == Reported) return;
  Reported = Message;
  UE_LOG(LogFaceBaker, Error, TEXT("%s: %s"), *GetName(), *Message);
  OnFailed.Broadcast(Message);
}

void UFaceBakerComponent::Reload() {
  Face.reset();
  ClearAllMeshSections();
  JointMesh.Reset();
  Model = Asset ? Asset->Load() : nullptr;
  if (!Model) return;
  std::string Error;
  Face = UnrealFace::make(*Model, Error);
  if (!Face) return Fail(Error);
  for (const TPair<FString, float>& Control : Controls) SetControl(Control.Key, Control.Value);
  ShownLevel = -1;
  FillSections();
  bPosed = false;
}

int32 UFaceBakerComponent::FindControl(const FString& Name) {
  if (!Face) return -1;
  std::string Error;
  const std::int64_t Index = Face->find_control(TCHAR_TO_UTF8(*Name), Error);
  if (Index < 0) Fail(Error);
  return static_cast<int32>(Index);
}

TArray<FFaceBakerDrivenJoint> UFaceBakerComponent::GetDrivenJoints() const {
  TArray<FFaceBakerDrivenJoint> Joints;
  if (!Face) return Joints;
  for (const facebaker::unreal::DrivenJoint& Joint : Face->driven_joints()) {
    FFaceBakerDrivenJoint Made;
    Made.Name = UTF8_TO_TCHAR(Joint.name.c_str());
    Made.Parent = Joint.parent;
    Made.Numbers = static_cast<int32>(Joint.numbers);
    Made.OuterRotations = static_cast<int32>(Joint.outer_rotations);
    Made.Rest = TransformOfFrame(Joint.rest.data());
    Joints.Add(Made);
  }
  return Joints;
}

int32 UFaceBakerComponent::FindDrivenJoint(const FString& Name) {
  if (!Face) return -1;
  std::string Error;
  const std::int64_t Index = Face->find_driven_joint(TCHAR_TO_UTF8(*Name), Error);
  if (Index < 0) Fail(Error);
  return static_cast<int32>(Index);
}

FTransform UFaceBakerComponent::GetDrivenJoint(int32 Index) const {
  float Frame[12];
  if (!Face || Index < 0 || !Face->driven_joint_frame(static_cast<std::uint32_t>(Index), Frame))
    return FTransform::Identity;
  return TransformOfFrame(Frame);
}

bool UFaceBakerComponent::SetControl(const FString& Name, float Value) {
  return SetControlAt(FindControl(Name), Value);
}

bool UFaceBakerComponent::SetControlAt(int32 Index, float Value) {
  return Face && Index >= 0 && Face->pose().set_control(static_cast<std::uint32_t>(Index), Value);
}

bool UFaceBakerComponent::SetControls(const TArray<float>& Values) {
  return Face && Face->pose().set_controls(Values.GetData(), static_cast<std::size_t>(Values.Num()));
}

void UFaceBakerComponent::ResetControls() {
  if (!Face) return;
  const std::vector<float> Rest = Model->rest_controls();
  Face->pose().set_controls(Rest.data(), Rest.size());
}

void UFaceBakerComponent::TickComponent(float Seconds, ELevelTick TickType, FActorComponentTickFunction* Function) {
  Super::TickComponent(Seconds, TickType, Function);
  if (!Face) return;
  if (bPosed && !bPoseWhenNotRendered && !WasRecentlyRendered()) return Face->forget_motion();
  bPosed = true;
  Face->pose().set_lod(LevelOfDetail);
  MoveJoints();
  std::string Error;
  switch (Face->update(Error)) {
    case UnrealFace::Update::unchanged:
      return;
    case UnrealFace::Update::failed:
      return Fail(Error);
    case UnrealFace::Update::changed:
      break;
  }
  Reported.Reset();
  FillSections();
}

// Another level has other triangles, for which Unreal makes the section anew; materials belong to the component, and
// stay.
void UFaceBakerComponent::FillSections() {
  const int32 Level = static_cast<int32>(Face->level());
  for (std::size_t Section = 0; Section < Face->sections().size(); ++Section)
    FillSection(static_cast<int32>(Section), Level != ShownLevel);
  ShownLevel = Level;
}

// The bone of each joint; joints are at rest until their bones move them.
void UFaceBakerComponent::FindBones(const USkeletalMesh& Mesh) {
  static const float Rest[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const FReferenceSkeleton& Reference = Mesh.GetRefSkeleton();
  JointBones.Reset();
  for (const std::string& Name : Face->joint_names()) {
    const int32 Bone = Reference.FindBoneIndex(FName(UTF8_TO_TCHAR(Name.c_str())));
    FTransform Place = FTransform::Identity;
    for (int32 Up = Bone; Up >= 0; Up = Reference.GetParentIndex(Up)) Place = Place * Reference.GetRefBonePose()[Up];
    Face->set_joint_motion(static_cast<std::uint32_t>(JointBones.Num()), Rest);
    JointBones.Add({Bone, Place});
  }
  JointMesh = &Mesh;
}

// Joints follow bones by how these have moved from their reference pose, whatever way their axes lie.
void UFaceBakerComponent::MoveJoints() {
  if (!Skeleton || Face->joint_names().empty()) return;
  const USkeletalMesh* Mesh = Skeleton->GetSkeletalMeshAsset();
  if (!Mesh) return;
  if (JointMesh.Get() != Mesh) FindBones(*Mesh);
  for (int32 Joint = 0; Joint < JointBones.Num(); ++Joint) {
    if (JointBones[Joint].Bone < 0) continue;
    const FTransform Now = Skeleton->GetBoneTransform(JointBones[Joint].Bone, FTransform::Identity);
    const FMatrix Matrix =
        (JointBones[Joint].Reference.Inverse() * Now).ToMatrixWithScale();  // of rows: vectors come first
    float Motion[12];
    for (int32 Row = 0; Row < 3; ++Row)
      for (int32 Column = 0; Column < 4; ++Column) Motion[4 * Row + Column] = static_cast<float>(Matrix.M[Column][Row]);
    Face->set_joint_motion(static_cast<std::uint32_t>(Joint), Motion);
  }
}

void UFaceBakerComponent::FillSection(int32 Section, bool bCreate) {
  const facebaker::engine::RenderSurface& Surface = Face->sections()[static_cast<std::size_t>(Section)];
  const facebaker::unreal::SectionBuffers& Buffers = Face->buffers(static_cast<std::size_t>(Section));
  const facebaker::engine::RenderLevel& Drawn = Surface.levels[Face->level()];
  const int32 Count = static_cast<int32>(Drawn.vertex_count);
  const bool bTextured = !Surface.uvs.empty();
  Vertices.SetNumUninitialized(Count);
  Normals.SetNumUninitialized(Count);
  Tangents.SetNumUninitialized(bTextured ? Count : 0);
  Uvs.SetNumUninitialized(bTextured ? Count : 0);
  MotionXy.SetNumUninitialized(bWriteMotion ? Count : 0);
  MotionZ.SetNumUninitialized(bWriteMotion ? Count : 0);
  for (int32 I = 0; I < Count; ++I) {
    const float* Position = Buffers.positions.data() + 3 * I;
    const float* Normal = Buffers.normals.data() + 3 * I;
    Vertices[I] = FVector(Position[0], Position[1], Position[2]);
    Normals[I] = FVector(Normal[0], Normal[1], Normal[2]);
    if (bTextured) {
      const float* Tangent = Buffers.tangents.data() + 3 * I;
      Tangents[I] = FProcMeshTangent(FVector(Tangent[0], Tangent[1], Tangent[2]),
                                     Surface.tangent_signs[static_cast<std::size_t>(I)] < 0);
      Uvs[I] =
          FVector2D(Surface.uvs[static_cast<std::size_t>(2 * I)], Surface.uvs[static_cast<std::size_t>(2 * I + 1)]);
    }
    if (bWriteMotion) {
      const float* Motion = Buffers.motion.data() + 3 * I;
      MotionXy[I] = FVector2D(Motion[0], Motion[1]);
      MotionZ[I] = FVector2D(Motion[2], 0);
    }
  }
  const TArray<FVector2D> NoUvs;
  const TArray<FColor> NoColours;
  if (!bCreate) {
    UpdateMeshSection(Section, Vertices, Normals, Uvs, MotionXy, MotionZ, NoUvs, NoColours, Tangents);
    return;
  }
  TArray<int32> Indices;
  for (const std::uint32_t Index : Drawn.indices) Indices.Add(static_cast<int32>(Index));
  CreateMeshSection(Section, Vertices, Indices, Normals, Uvs, MotionXy, MotionZ, NoUvs, NoColours, Tangents, false);
}
