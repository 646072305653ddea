using System.IO;
using UnrealBuildTool;

public class FaceBaker : ModuleRules
{
    public FaceBaker(ReadOnlyTargetRules Target) : base(Target)
    {
        PCHUsage = PCHUsageMode.UseExplicitOrSharedPCHs;
        bEnableExceptions = true; // facebaker.hpp reports errors so; UnrealFace.cpp catches all of them
        PublicDependencyModuleNames.AddRange(new[] { "Core", "CoreUObject", "Engine", "ProceduralMeshComponent" });
        PrivateDependencyModuleNames.Add("Projects"); // where the plugin's folder is

        // ThirdParty is made by pack_plugin.py: headers, and a library for each platform.
        string thirdParty = Path.Combine(PluginDirectory, "Source", "ThirdParty", "FaceBaker");
        PrivateIncludePaths.Add(Path.Combine(thirdParty, "include"));
        if (Target.Platform == UnrealTargetPlatform.Win64)
        {
            PublicAdditionalLibraries.Add(Path.Combine(thirdParty, "Win64", "facebaker.lib"));
            PublicDelayLoadDLLs.Add("facebaker.dll"); // FaceBakerModule.cpp loads it
            RuntimeDependencies.Add(Path.Combine(thirdParty, "Win64", "facebaker.dll"));
        }
        else if (Target.Platform == UnrealTargetPlatform.Linux || Target.Platform == UnrealTargetPlatform.LinuxArm64)
        {
            string folder = Path.Combine(thirdParty, Target.Platform.ToString());
            string library = Path.Combine(folder, "libfacebaker.so");
            PublicAdditionalLibraries.Add(library);
            PrivateRuntimeLibraryPaths.Add(folder);
            RuntimeDependencies.Add(library);
        }
        else if (Target.Platform == UnrealTargetPlatform.Mac)
        {
            string library = Path.Combine(thirdParty, "Mac", "libfacebaker.dylib");
            PublicAdditionalLibraries.Add(library);
            RuntimeDependencies.Add(library);
        }
    }
}
