using System;
using System.Reflection;
using System.Runtime.InteropServices;

namespace FaceBaker.Tests
{
    /// <summary>Prints the size and offsets of every struct that is generated from the headers, as
    /// bindings/headers/struct_layouts.py lists them.</summary>
    internal static class PrintLayouts
    {
        public static int Main()
        {
            foreach (Type type in typeof(Face).Assembly.GetTypes())
            {
                if (!type.IsValueType || !type.Name.StartsWith("fb_")) continue;
                Console.WriteLine(type.Name + " " + Marshal.SizeOf(type));
                foreach (FieldInfo field in type.GetFields(BindingFlags.Instance | BindingFlags.Public))
                    Console.WriteLine(type.Name + "." + field.Name + " " + Marshal.OffsetOf(type, field.Name));
            }
            return 0;
        }
    }
}
