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

/** Shows a baked face: poses it on the game thread, before skinning, moves it by the joints of a skeleton where the
 * archive has a skin, and fills mesh sections in place. */
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

  /** 0: the whole; fractions lie between two levels. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "FaceBaker", meta = (ClampMin = "0"))
  float LevelOfDetail = 0;

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
  void FillSection(int32 Section, bool bCreate);

  std::shared_ptr<const facebaker::Model> Model;
  // Shared, because code that Unreal generates sees these types without their definitions.
  std::shared_ptr<facebaker::unreal::UnrealFace> Face;
  FString Reported;
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
