// The plugin's build rules over stubs of Unreal's build tool: CheckBuildRules.exe PLUGIN. Every file that they name for a platform
// is in the packed plugin, and a library that is loaded late is where FaceBakerModule.cpp loads it from.
using System;
using System.Collections.Generic;
using System.IO;
using UnrealBuildTool;

internal static class CheckBuildRules
{
    private static int checks, failures;

    private static void That(bool holds, string what)
    {
        ++checks;
        if (holds) return;
        ++failures;
        Console.Error.WriteLine("not so: " + what);
    }

    private static void CheckFiles(string plugin, string platform, IEnumerable<string> files)
    {
        foreach (string file in files)
        {
            That(file.StartsWith(plugin + "/", StringComparison.Ordinal), platform + ": " + file + " lies in the plugin");
            That(File.Exists(file), platform + ": " + file + " is packed");
        }
    }

    public static int Main(string[] arguments)
    {
        string plugin = arguments[0];
        ModuleRules.StubPluginDirectory = plugin;
        foreach (UnrealTargetPlatform platform in
                 new[] { UnrealTargetPlatform.Win64, UnrealTargetPlatform.Linux, UnrealTargetPlatform.LinuxArm64 })
        {
            var rules = new FaceBaker(new ReadOnlyTargetRules { Platform = platform });
            That(rules.PublicAdditionalLibraries.Count == 1, platform + ": a library is linked");
            CheckFiles(plugin, platform.ToString(), rules.PublicAdditionalLibraries);
            CheckFiles(plugin, platform.ToString(), rules.RuntimeDependencies.Files);
            foreach (string folder in rules.PrivateRuntimeLibraryPaths)
                That(Directory.Exists(folder), platform + ": " + folder + " is packed");
            foreach (string late in rules.PublicDelayLoadDLLs)
            {
                string file = Path.Combine(plugin, "Source", "ThirdParty", "FaceBaker", platform.ToString(), late);
                That(rules.RuntimeDependencies.Files.Contains(file), late + " is shipped where the module loads it from");
                That(rules.PrivateDependencyModuleNames.Contains("Projects"), "the module may ask for the plugin's folder");
            }
            string linked = Path.GetFileNameWithoutExtension(rules.PublicAdditionalLibraries[0]);
            That(Path.GetFileNameWithoutExtension(rules.RuntimeDependencies.Files[0]) == linked, "one name: " + linked);
        }
        That(new FaceBakerEditor(new ReadOnlyTargetRules()).PrivateDependencyModuleNames.Contains("FaceBaker"), "the editor's");
        Console.WriteLine(checks + " checks of the build rules, " + failures + " failed");
        return failures == 0 ? 0 : 1;
    }
}
