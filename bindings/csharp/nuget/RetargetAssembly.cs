// Makes of an assembly that Mono's compiler wrote one for .NET Standard 2.1: RetargetAssembly.exe IN.dll OUT.dll. Mono's classes
// are in mscorlib, those of other runtimes elsewhere; netstandard is the name by which all of them find them. The same input
// but for the module's identifier and the time, which Mono's compiler draws anew, gives the same bytes.
using System;
using Mono.Cecil;

internal static class RetargetAssembly
{
    private static readonly byte[] Token = { 0xcc, 0x7b, 0x13, 0xff, 0xcd, 0x2d, 0xdd, 0x51 };

    public static int Main(string[] arguments)
    {
        using (ModuleDefinition module = ModuleDefinition.ReadModule(arguments[0]))
        {
            if (module.AssemblyReferences.Count != 1 || module.AssemblyReferences[0].Name != "mscorlib")
            {
                // Each further one would have to become the same reference, of which an assembly may have one only.
                foreach (AssemblyNameReference one in module.AssemblyReferences)
                    Console.Error.WriteLine(arguments[0] + ": refers to " + one.Name + "; only mscorlib can be replaced");
                return 1;
            }
            AssemblyNameReference library = module.AssemblyReferences[0];
            library.Name = "netstandard";
            library.Version = new Version(2, 1, 0, 0);
            library.PublicKeyToken = Token;
            module.Write(arguments[1], new WriterParameters { DeterministicMvid = true, Timestamp = 0 });
        }
        return 0;
    }
}
