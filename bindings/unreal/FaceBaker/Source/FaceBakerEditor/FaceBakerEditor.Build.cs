using UnrealBuildTool;

public class FaceBakerEditor : ModuleRules
{
    public FaceBakerEditor(ReadOnlyTargetRules Target) : base(Target)
    {
        PCHUsage = PCHUsageMode.UseExplicitOrSharedPCHs;
        PrivateDependencyModuleNames.AddRange(new[] { "Core", "CoreUObject", "Engine", "UnrealEd", "FaceBaker" });
    }
}
