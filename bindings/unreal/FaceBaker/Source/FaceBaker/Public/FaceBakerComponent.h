#pragma once

#include "CoreMinimal.h"
#include "ProceduralMeshComponent.h"
#include "UObject/WeakObjectPtr.h"

#include <memory>

#include "FaceBakerComponent.generated.h"

class UFaceBakerAsset;
class USkeletalMesh;
class USkeletalMeshComponent;

namespace facebaker {
class Model;
namespace unreal {
class UnrealFace;
}
}  // namespace facebaker

/** A control was set to what is no number, or the archive is damaged. */
DECLARE_DYNAMIC_MULTICAST_DELEGATE_OneParam(FFaceBakerFailed, const FString&, Message);

/** A joint that the controls of a face move: of a jaw, a tongue, an eye. */
USTRUCT(BlueprintType)
struct FFaceBakerDrivenJoint {
  GENERATED_BODY()

  UPROPERTY(BlueprintReadOnly, Category = "FaceBaker")
  FString Name;
  /** Index of its parent among the driven joints, less than its own; -1: none. */
  UPROPERTY(BlueprintReadOnly, Category = "FaceBaker")
  int32 Parent = -1;
  /** How controls move it within its parent, along its own axes: turns about x, y, z are 1, 2, 4, moves 8, 16, 32,
   * lengths 64, 128, 256, pivots 512, 1024, 2048, added up. */
  UPROPERTY(BlueprintReadOnly, Category = "FaceBaker")
  int32 Numbers = 0;
  /** How many rotations it turns by beside its first, each after those before it. */
  UPROPERTY(BlueprintReadOnly, Category = "FaceBaker")
  int32 OuterRotations = 0;
  /** At rest, in the space of the component, before the skeleton moves it. */
  UPROPERTY(BlueprintReadOnly, Category = "FaceBaker")
  FTransform Rest;
};

/** Shows a baked face: poses it on the game thread, with the joints that its controls drive, moves it by the bones of a
 * skeleton where the archive has a skin, and fills mesh sections in place. */
UCLASS(ClassGroup = (Rendering), meta = (BlueprintSpawnableComponent))
class FACEBAKER_API UFaceBakerComponent : public UProceduralMeshComponent {
  GENERATED_BODY()

 public:
  UFaceBakerComponent(const FObjectInitializer& Initializer);

  /** The archive. Call Reload() where it is set at run time. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "FaceBaker")
  TObjectPtr<UFaceBakerAsset> Asset;

  /** Values of controls by name; others are at rest. Sequencer and Blueprints set controls by SetControl. */
  UPROPERTY(EditAnywhere, Category = "FaceBaker")
  TMap<FString, float> Controls;

  /** 0: the whole; fractions lie between two levels. The triangles of the level that it is rounded down to are drawn.
   */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "FaceBaker", meta = (ClampMin = "0"))
  float LevelOfDetail = 0;

  /** Whether the face is posed while no camera sees it, too: for sockets and joints that are asked for all the same. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "FaceBaker")
  bool bPoseWhenNotRendered = false;

  /** Bones of the same names as the archive's joints move the face; null: it stays at rest. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "FaceBaker")
  TObjectPtr<USkeletalMeshComponent> Skeleton;

  /** Writes the movement since the last frame into texture coordinates 1 (x, y) and 2 (z), in centimetres, for a
   * material's world position offset in the previous frame. */
  UPROPERTY(EditAnywhere, Category = "FaceBaker")
  bool bWriteMotion = true;

  /** Once a failure. */
  UPROPERTY(BlueprintAssignable, Category = "FaceBaker")
  FFaceBakerFailed OnFailed;

  /** Sets a control by its name, ARKit name or FACS name. False, and a log message with the closest name, if there is
   * none. */
  UFUNCTION(BlueprintCallable, Category = "FaceBaker")
  bool SetControl(const FString& Name, float Value);
  /** The index of a control for SetControlAt; -1 if there is none. */
  UFUNCTION(BlueprintCallable, Category = "FaceBaker")
  int32 FindControl(const FString& Name);
  /** The quickest way to set a control. */
  UFUNCTION(BlueprintCallable, Category = "FaceBaker")
  bool SetControlAt(int32 Index, float Value);
  /** Sets all controls, in the order of the archive. False unless there are as many. */
  UFUNCTION(BlueprintCallable, Category = "FaceBaker")
  bool SetControls(const TArray<float>& Values);
  /** Puts all controls at rest. */
  UFUNCTION(BlueprintCallable, Category = "FaceBaker")
  void ResetControls();
  /** Joints that the controls drive, after their parents; there may be none. */
  UFUNCTION(BlueprintCallable, Category = "FaceBaker")
  TArray<FFaceBakerDrivenJoint> GetDrivenJoints() const;
  /** The index of a driven joint for GetDrivenJoint; -1, and a log message with those there are, if there is none. */
  UFUNCTION(BlueprintCallable, Category = "FaceBaker")
  int32 FindDrivenJoint(const FString& Name);
  /** Where a driven joint was at the last tick, in the space of the component, the skeleton having moved it as the
   * vertices around it: for what hangs on a jaw or an eye, and for bones. The identity if there is no such joint. */
  UFUNCTION(BlueprintCallable, Category = "FaceBaker")
  FTransform GetDrivenJoint(int32 Index) const;
  /** Loads the asset anew. */
  UFUNCTION(BlueprintCallable, Category = "FaceBaker")
  void Reload();

  virtual void OnRegister() override;
  virtual void OnUnregister() override;
  virtual void TickComponent(float Seconds, ELevelTick TickType, FActorComponentTickFunction* Function) override;

 private:
  void Fail(const std::string& Error);
  void FindBones(const USkeletalMesh& Mesh);
  void MoveJoints();
  void FillSections();
  void FillSection(int32 Section, bool bCreate);

  std::shared_ptr<const facebaker::Model> Model;
  // Shared, because code that Unreal generates sees these types without their definitions.
  std::shared_ptr<facebaker::unreal::UnrealFace> Face;
  FString Reported;
  int32 ShownLevel = -1;  // of the triangles that sections have
  bool bPosed = false;    // since it was loaded: the first pose is made whether it is seen or not
  // Of each joint: the bone of a skeletal mesh, -1 for none, and where that is in its reference pose.
  struct FJointBone {
    int32 Bone;
    FTransform Reference;
  };
  TArray<FJointBone> JointBones;
  TWeakObjectPtr<const USkeletalMesh> JointMesh;  // whose bones they are
  // Buffers of a section, kept between frames.
  TArray<FVector> Vertices, Normals;
  TArray<FVector2D> Uvs, MotionXy, MotionZ;
  TArray<FProcMeshTangent> Tangents;
};
