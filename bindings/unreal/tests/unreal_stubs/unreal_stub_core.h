/* Not Unreal: the little of its classes that the plugin uses, written for its tests, so that it compiles and its
 * component can be ticked without the engine. Strings are UTF-8, everything is in one file, and nothing is drawn. The
 * test script makes headers of the engine's names that include this one. */
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#define UCLASS(...)
#ifndef UPROPERTY  // test.sh lists the properties of what is cooked by it
#define UPROPERTY(...)
#endif
#define UFUNCTION(...)
#define USTRUCT(...)
#define GENERATED_BODY()
#define FACEBAKER_API
#define TEXT(text) text
#define UTF8_TO_TCHAR(text) text
#define TCHAR_TO_UTF8(text) text
#define DECLARE_LOG_CATEGORY_EXTERN(name, level, most) extern int name
#define DEFINE_LOG_CATEGORY(name) int name = 0
#define UE_LOG(category, level, ...) (stub_log().push_back(stub_format(__VA_ARGS__)))
#define IMPLEMENT_MODULE(type, name)                       \
  std::unique_ptr<IModuleInterface> stub_module_##name() { \
    return std::make_unique<type>();                       \
  }
#define PLATFORM_WINDOWS 1  // for what the module does there
#ifndef WITH_EDITORONLY_DATA
#define WITH_EDITORONLY_DATA 1
#endif
#define DECLARE_DYNAMIC_MULTICAST_DELEGATE_OneParam(name, type, parameter) using name = StubDelegate<type>

using uint8 = std::uint8_t;
using int32 = std::int32_t;
using TCHAR = char;

class FString {
 public:
  FString() = default;
  FString(const char* text) : text_(text) {}
  const char* operator*() const { return text_.c_str(); }
  bool IsEmpty() const { return text_.empty(); }
  void Reset() { text_.clear(); }
  bool operator==(const FString& other) const { return text_ == other.text_; }
  bool operator<(const FString& other) const { return text_ < other.text_; }

 private:
  std::string text_;
};
using FName = FString;

inline std::vector<std::string>& stub_log() {
  static std::vector<std::string> log;
  return log;
}
inline std::string stub_format(const char*, const char* first, const char* second = "") {
  return std::string(first) + ": " + second;
}

template <typename Argument>
struct StubDelegate {
  std::vector<std::string> sent;
  void Broadcast(Argument argument) { sent.push_back(*argument); }
};

template <typename T>
class TArray {
 public:
  TArray() = default;
  TArray(std::initializer_list<T> items) : items_(items) {}
  const T* GetData() const { return items_.data(); }
  T* GetData() { return items_.data(); }
  int32 Num() const { return static_cast<int32>(items_.size()); }
  void Add(const T& item) { items_.push_back(item); }
  void Reset() { items_.clear(); }
  void SetNumUninitialized(int32 count) { items_.resize(static_cast<std::size_t>(count)); }
  T& operator[](int32 i) { return items_.at(static_cast<std::size_t>(i)); }
  const T& operator[](int32 i) const { return items_.at(static_cast<std::size_t>(i)); }

 private:
  std::vector<T> items_;
};

template <typename Key_, typename Value_>
struct TPair {
  Key_ Key;
  Value_ Value;
};

template <typename Key, typename Value>
class TMap {
 public:
  void Add(const Key& key, const Value& value) { pairs_.push_back({key, value}); }
  auto begin() const { return pairs_.begin(); }
  auto end() const { return pairs_.end(); }

 private:
  std::vector<TPair<Key, Value>> pairs_;
};

template <typename T>
using TObjectPtr = T*;

template <typename T>
class TWeakObjectPtr {
 public:
  TWeakObjectPtr& operator=(T* object) {
    object_ = object;
    return *this;
  }
  T* Get() const { return object_; }
  void Reset() { object_ = nullptr; }

 private:
  T* object_ = nullptr;
};

template <typename T>
T&& MoveTemp(T& from) {
  return static_cast<T&&>(from);
}

struct FVector {
  double X = 0, Y = 0, Z = 0;
  FVector() = default;
  FVector(double x, double y, double z) : X(x), Y(y), Z(z) {}
};
struct FVector2D {
  double X = 0, Y = 0;
  FVector2D() = default;
  FVector2D(double x, double y) : X(x), Y(y) {}
};
struct FColor {};
struct FMatrix {
  double M[4][4];
};

/* A translation alone, but for what is made of a matrix, which keeps that. */
struct FTransform {
  FVector At;
  FMatrix Matrix = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
  static const FTransform Identity;
  FTransform() = default;
  FTransform(FVector at) : At(at), Matrix{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {at.X, at.Y, at.Z, 1}}} {}
  explicit FTransform(const FMatrix& matrix) : At(matrix.M[3][0], matrix.M[3][1], matrix.M[3][2]), Matrix(matrix) {}
  FTransform Inverse() const { return {FVector(-At.X, -At.Y, -At.Z)}; }
  FTransform operator*(const FTransform& b) const { return {FVector(At.X + b.At.X, At.Y + b.At.Y, At.Z + b.At.Z)}; }
  FMatrix ToMatrixWithScale() const { return Matrix; }
};
inline const FTransform FTransform::Identity{};

class FObjectInitializer {};
class UClass {};
enum EObjectFlags { RF_NoFlags };
enum ELevelTick { LEVELTICK_All };
enum ETickingGroup { TG_PostPhysics };
struct FActorComponentTickFunction {
  bool bCanEverTick = false;
  ETickingGroup TickGroup = TG_PostPhysics;
};

class UObject {
 public:
  virtual ~UObject() = default;
  FString GetName() const { return "object"; }
  static UClass* StaticClass() { return nullptr; }
};

template <typename T>
T* NewObject(UObject*, UClass*, FName, EObjectFlags) {
  return new T;
}
template <typename T>
T* NewObject(UObject*, FName) {
  return new T;
}

/* Keeps the path as it is given; Unreal's makes it one from the project. */
class UAssetImportData : public UObject {
 public:
  FString file;
  void Update(const FString& path) { file = path; }
};

class IModuleInterface {
 public:
  virtual ~IModuleInterface() = default;
  virtual void StartupModule() {}
  virtual void ShutdownModule() {}
};
using FDefaultModuleImpl = IModuleInterface;

struct FPaths {
  static FString Combine(const FString& folder, const char* path) {
    return (std::string(*folder) + "/" + path).c_str();
  }
};

/* Loads nothing: keeps what is asked for, and finds the files that are there. */
struct FPlatformProcess {
  static inline std::vector<std::string> folders, loaded;
  static void PushDllDirectory(const char* folder) { folders.push_back(folder); }
  static void PopDllDirectory(const char*) { folders.pop_back(); }
  static void* GetDllHandle(const char* file);
  static void FreeDllHandle(void*) { loaded.pop_back(); }
};

class IPlugin {
 public:
  FString folder;
  FString GetBaseDir() const { return folder; }
};
class IPluginManager {
 public:
  std::map<std::string, std::shared_ptr<IPlugin>> plugins;
  static IPluginManager& Get() {
    static IPluginManager manager;
    return manager;
  }
  std::shared_ptr<IPlugin> FindPlugin(const char* name) { return plugins.at(name); }
};

class FReferenceSkeleton {
 public:
  std::vector<std::string> names;
  TArray<FTransform> places;
  std::vector<int32> parents;
  int32 FindBoneIndex(const FName& name) const {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == *name) return static_cast<int32>(i);
    return -1;
  }
  int32 GetParentIndex(int32 bone) const { return parents.at(static_cast<std::size_t>(bone)); }
  const TArray<FTransform>& GetRefBonePose() const { return places; }
};

class USkeletalMesh : public UObject {
 public:
  FReferenceSkeleton skeleton;
  const FReferenceSkeleton& GetRefSkeleton() const { return skeleton; }
};

class USkeletalMeshComponent : public UObject {
 public:
  USkeletalMesh mesh;
  std::vector<FTransform> bones;
  USkeletalMesh* GetSkeletalMeshAsset() { return &mesh; }
  FTransform GetBoneTransform(int32 bone, const FTransform&) const { return bones.at(static_cast<std::size_t>(bone)); }
};

struct FProcMeshTangent {
  FVector TangentX;
  bool bFlipTangentY = false;
  FProcMeshTangent() = default;
  FProcMeshTangent(FVector x, bool flip) : TangentX(x), bFlipTangentY(flip) {}
};

class UProceduralMeshComponent : public UObject {
 public:
  using Super = UProceduralMeshComponent;
  struct StubSection {
    TArray<FVector> vertices, normals;
    TArray<int32> indices;
    TArray<FVector2D> uvs, motion_xy, motion_z;
    int updates = 0, made = 0;
  };
  std::vector<StubSection> sections;
  FActorComponentTickFunction PrimaryComponentTick;
  bool bTickInEditor = false;
  bool rendered = true;

  bool WasRecentlyRendered(float = 0.2f) const { return rendered; }
  explicit UProceduralMeshComponent(const FObjectInitializer&) {}
  virtual void OnRegister() {}
  virtual void OnUnregister() {}
  virtual void TickComponent(float, ELevelTick, FActorComponentTickFunction*) {}
  void ClearAllMeshSections() { sections.clear(); }
  void CreateMeshSection(int32 section, const TArray<FVector>& vertices, const TArray<int32>& indices,
                         const TArray<FVector>& normals, const TArray<FVector2D>& uvs, const TArray<FVector2D>& uvs1,
                         const TArray<FVector2D>& uvs2, const TArray<FVector2D>&, const TArray<FColor>&,
                         const TArray<FProcMeshTangent>&, bool) {
    if (sections.size() <= static_cast<std::size_t>(section)) sections.resize(static_cast<std::size_t>(section) + 1);
    const int made = sections[static_cast<std::size_t>(section)].made + 1;
    sections[static_cast<std::size_t>(section)] = {vertices, normals, indices, uvs, uvs1, uvs2, 0, made};
  }
  void UpdateMeshSection(int32 section, const TArray<FVector>& vertices, const TArray<FVector>& normals,
                         const TArray<FVector2D>&, const TArray<FVector2D>& uvs1, const TArray<FVector2D>& uvs2,
                         const TArray<FVector2D>&, const TArray<FColor>&, const TArray<FProcMeshTangent>&) {
    StubSection& to = sections.at(static_cast<std::size_t>(section));
    if (to.vertices.Num() != vertices.Num()) return;  // Unreal logs an error
    to.vertices = vertices, to.normals = normals, to.motion_xy = uvs1, to.motion_z = uvs2;
    ++to.updates;
  }
};

namespace ELogVerbosity {
enum Type { Error };
}
class FFeedbackContext {
 public:
  std::vector<std::string> sentences;
  void Logf(ELogVerbosity::Type, const char* format, const char* first, const char* second = "") {
    sentences.push_back(stub_format(format, first, second));
  }
};

struct FFileHelper {
  static bool LoadFileToArray(TArray<uint8>& to, const char* path);
};

class UFactory : public UObject {
 public:
  using Super = UFactory;
  bool bEditorImport = false;
  UClass* SupportedClass = nullptr;
  TArray<FString> Formats;
  explicit UFactory(const FObjectInitializer&) {}
  virtual UObject* FactoryCreateFile(UClass*, UObject*, FName, EObjectFlags, const FString&, const TCHAR*,
                                     FFeedbackContext*, bool&) = 0;
};
