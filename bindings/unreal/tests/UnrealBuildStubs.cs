// Not Unreal: the little of its build tool that the plugin's build rules use.
using System.Collections.Generic;

namespace UnrealBuildTool
{
    public enum UnrealTargetPlatform { Win64, Linux, LinuxArm64, Mac }

    public sealed class ReadOnlyTargetRules { public UnrealTargetPlatform Platform; }

    public sealed class RuntimeDependencyList
    {
        public readonly List<string> Files = new List<string>();
        public void Add(string file) { Files.Add(file); }
        public void Add(string file, string source) { Files.Add(file); }
    }

    public class ModuleRules
    {
        public enum PCHUsageMode { UseExplicitOrSharedPCHs }

        public static string StubPluginDirectory;

        public PCHUsageMode PCHUsage;
        public bool bEnableExceptions;
        public readonly List<string> PublicDependencyModuleNames = new List<string>(),
            PrivateDependencyModuleNames = new List<string>(), PrivateIncludePaths = new List<string>(),
            PublicAdditionalLibraries = new List<string>(), PublicDelayLoadDLLs = new List<string>(),
            PrivateRuntimeLibraryPaths = new List<string>();
        public readonly RuntimeDependencyList RuntimeDependencies = new RuntimeDependencyList();

        public ModuleRules(ReadOnlyTargetRules target) { }
        public string PluginDirectory { get { return StubPluginDirectory; } }
    }
}
