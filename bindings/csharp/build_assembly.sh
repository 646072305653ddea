#!/bin/sh
# Compiles the C# package with Mono for .NET Standard 2.1: DIR gets FaceBaker.dll and FaceBaker.xml, its documentation. The same
# sources give the same bytes.
#   bindings/csharp/build_assembly.sh DIR
set -eu
[ $# -eq 1 ] || { echo "usage: bindings/csharp/build_assembly.sh DIR" >&2; exit 2; }
out=$(realpath -m "$1")
cd "$(dirname "$0")/../.."
for command in mcs mono python3; do
  command -v $command > /dev/null || {
    echo "build_assembly.sh: there is no $command: install mono-mcs, mono-runtime, libmono-cecil-private-cil and python3" >&2
    exit 1
  }
done
cecil=$(find /usr/lib/mono/gac/Mono.Cecil -name Mono.Cecil.dll 2> /dev/null | sort -V | tail -n 1)
[ -n "$cecil" ] || { echo "build_assembly.sh: there is no Mono.Cecil.dll: install libmono-cecil-private-cil" >&2; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/out" "$work/tool"
python3 -B bindings/csharp/generate_interop.py --headers capi/include/facebaker --out "$work/NativeInterop.cs"
version=$(head -n 1 VERSION)
cat > "$work/AssemblyVersion.cs" << END
[assembly: System.Reflection.AssemblyVersion("$version.0")]
[assembly: System.Reflection.AssemblyFileVersion("$version.0")]
[assembly: System.Reflection.AssemblyTitle("FaceBaker")]
[assembly: System.Runtime.Versioning.TargetFramework(".NETStandard,Version=v2.1")]
END
mcs -unsafe -optimize -langversion:latest -warn:4 -warnaserror -target:library -out:"$work/FaceBaker.dll" \
  -doc:"$work/out/FaceBaker.xml" bindings/csharp/runtime/*.cs "$work"/*.cs
mcs -r:"$cecil" -out:"$work/tool/RetargetAssembly.exe" bindings/csharp/nuget/RetargetAssembly.cs
mono "$work/tool/RetargetAssembly.exe" "$work/FaceBaker.dll" "$work/out/FaceBaker.dll"
mkdir -p "$out"
mv "$work/out/FaceBaker.dll" "$work/out/FaceBaker.xml" "$out/"
