#include "FaceBakerLog.h"
#include "HAL/PlatformProcess.h"
#include "Interfaces/IPluginManager.h"
#include "Misc/Paths.h"
#include "Modules/ModuleManager.h"

/* On Windows facebaker.dll is loaded on the first call into it, by its name (delay-loaded: FaceBaker.Build.cs), and
 * that finds what is loaded already: the plugin's own, from its folder, as long as the module runs. */
class FFaceBakerModule : public IModuleInterface {
 public:
  virtual void StartupModule() override {
#if PLATFORM_WINDOWS
    const FString Plugin = IPluginManager::Get().FindPlugin(TEXT("FaceBaker"))->GetBaseDir();
    const FString Folder = FPaths::Combine(Plugin, TEXT("Source/ThirdParty/FaceBaker/Win64"));
    const FString File = FPaths::Combine(Folder, TEXT("facebaker.dll"));
    FPlatformProcess::PushDllDirectory(*Folder);
    Library = FPlatformProcess::GetDllHandle(*File);
    FPlatformProcess::PopDllDirectory(*Folder);
    if (!Library) UE_LOG(LogFaceBaker, Error, TEXT("%s cannot be loaded"), *File);
#endif
  }

  virtual void ShutdownModule() override {
    if (Library) FPlatformProcess::FreeDllHandle(Library);
    Library = nullptr;
  }

 private:
  void* Library = nullptr;
};

IMPLEMENT_MODULE(FFaceBakerModule, FaceBaker)
