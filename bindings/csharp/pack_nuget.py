#!/usr/bin/env python3
"""Packs the NuGet package, without NuGet: FaceBaker.VERSION.nupkg, a zip file by the Open Packaging Conventions.

    pack_nuget.py --out DIR --assembly DIR [--library PLATFORM=FILE]...

The folder of --assembly is one that build_assembly.sh has filled. PLATFORM is one of linux-x64, linux-arm64, windows-x64, macos,
android-arm64, android-x64; each library goes where .NET finds it for that platform (runtimes/RID/native). The same files
give the same bytes, dated by SOURCE_DATE_EPOCH. The package appears in DIR complete or not at all. Standard library only."""

from __future__ import annotations

import argparse
import hashlib
import pathlib
import sys
from typing import Dict, List, NamedTuple, Optional
from xml.sax.saxutils import escape

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "bindings" / "engine"))
import engine_package  # noqa: E402
from package_archives import Member, Members, write_whole, zip_bytes  # noqa: E402

ID = "FaceBaker"
FRAMEWORK = "netstandard2.1"
DESCRIPTION = ("Poses facial rigs that FaceBaker has baked into .fbk archives: positions, normals, joints and channels from "
               "control values, and controls from points. With the native library for each platform.")
TAGS = "animation face facial-rig blendshapes"
HEADER = '<?xml version="1.0" encoding="utf-8"?>\n'
# Names by which the format knows what a part is.
CONTENT_TYPES = "http://schemas.openxmlformats.org/package/2006/content-types"
RELATIONSHIPS = "http://schemas.openxmlformats.org/package/2006/relationships"
CORE_PROPERTIES = "http://schemas.openxmlformats.org/package/2006/metadata/core-properties"
MANIFEST = "http://schemas.microsoft.com/packaging/2010/07/manifest"
NUSPEC = "http://schemas.microsoft.com/packaging/2013/05/nuspec.xsd"


class Platform(NamedTuple):
    """How .NET calls a platform (its runtime identifier), and the library that it looks for there."""

    rid: str
    file: str


PLATFORMS: Dict[str, Platform] = {
    "linux-x64": Platform("linux-x64", "libfacebaker.so"),
    "linux-arm64": Platform("linux-arm64", "libfacebaker.so"),
    "windows-x64": Platform("win-x64", "facebaker.dll"),
    "macos": Platform("osx", "libfacebaker.dylib"),
    "android-arm64": Platform("android-arm64", "libfacebaker.so"),
    "android-x64": Platform("android-x64", "libfacebaker.so"),
}


def nuspec(version: str) -> str:
    fields = {"id": ID, "version": version, "authors": "FaceBaker developers", "description": DESCRIPTION, "tags": TAGS}
    lines = [f"    <{name}>{escape(text)}</{name}>" for name, text in fields.items()]
    return "\n".join([
        HEADER + f'<package xmlns="{NUSPEC}">', "  <metadata>", *lines,
        "    <requireLicenseAcceptance>false</requireLicenseAcceptance>",
        '    <license type="expression">Apache-2.0</license>',
        "    <readme>README.md</readme>",
        "    <dependencies>", '      <group targetFramework=".NETStandard2.1" />', "    </dependencies>",
        "  </metadata>", "</package>", ""])


def properties(version: str) -> str:
    """What the format wants to know of any package."""
    return "\n".join([
        HEADER + f'<coreProperties xmlns="{CORE_PROPERTIES}" xmlns:dc="http://purl.org/dc/elements/1.1/">',
        "  <dc:creator>FaceBaker developers</dc:creator>",
        f"  <dc:description>{escape(DESCRIPTION)}</dc:description>", f"  <dc:identifier>{ID}</dc:identifier>",
        f"  <version>{version}</version>", f"  <keywords>{escape(TAGS)}</keywords>", "</coreProperties>", ""])


def relationships(properties_path: str) -> str:
    parts = [(f"{MANIFEST}", f"/{ID}.nuspec"),
             ("http://schemas.openxmlformats.org/package/2006/relationships/metadata/core-properties", f"/{properties_path}")]
    lines = [f'  <Relationship Type="{kind}" Target="{target}" Id="R{hashlib.sha256(target.encode()).hexdigest()[:16].upper()}" />'
             for kind, target in parts]
    return "\n".join([HEADER + f'<Relationships xmlns="{RELATIONSHIPS}">', *lines, "</Relationships>", ""])


def content_types(paths: List[str]) -> str:
    """The kind of each part, by its extension; those without one are named."""
    known = {"rels": "application/vnd.openxmlformats-package.relationships+xml",
             "psmdcp": "application/vnd.openxmlformats-package.core-properties+xml"}
    extensions = sorted({path.rpartition(".")[2] for path in paths if "." in path.rpartition("/")[2]} | set(known))
    lines = [f'  <Default Extension="{one}" ContentType="{known.get(one, "application/octet")}" />' for one in extensions]
    lines += [f'  <Override PartName="/{path}" ContentType="application/octet" />'
              for path in sorted(paths) if "." not in path.rpartition("/")[2]]
    return "\n".join([HEADER + f'<Types xmlns="{CONTENT_TYPES}">', *lines, "</Types>", ""])


def package_members(assembly: pathlib.Path, libraries: engine_package.Libraries) -> Members:
    """All parts by their paths. Raises OSError, or ValueError on a library of a name that .NET would not look for."""
    version = engine_package.version()
    texts = {f"{ID}.nuspec": nuspec(version)}
    files = {f"lib/{FRAMEWORK}/{name}": (assembly / name).read_bytes() for name in ("FaceBaker.dll", "FaceBaker.xml")}
    for name, file in libraries:
        platform = PLATFORMS[name]
        if file.name != platform.file:
            raise ValueError(f"{file}: a library for {name} is called {platform.file}")
        files[f"runtimes/{platform.rid}/native/{file.name}"] = file.read_bytes()
    files["README.md"] = (HERE / "nuget" / "PACKAGE.md").read_bytes()
    files["LICENSE.txt"] = (ROOT / "LICENSE").read_bytes()
    texts.update(engine_package.notices([file for _, file in libraries]))
    files.update({name: text.encode() for name, text in texts.items()})
    digest = hashlib.sha256(b"".join(path.encode() + files[path] for path in sorted(files))).hexdigest()[:32]
    properties_path = f"package/services/metadata/core-properties/{digest}.psmdcp"
    files[properties_path] = properties(version).encode()
    files["_rels/.rels"] = relationships(properties_path).encode()
    files["[Content_Types].xml"] = content_types(list(files)).encode()
    return {path: Member(data) for path, data in files.items()}


def main(arguments: Optional[List[str]] = None) -> int:
    parser = argparse.ArgumentParser(description="Packs the NuGet package.")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="the folder of the package")
    parser.add_argument("--assembly", type=pathlib.Path, required=True, help="a folder that build_assembly.sh has filled")
    parser.add_argument("--library", action="append", default=[], metavar="PLATFORM=FILE", help="a native library to pack")
    options = parser.parse_args(arguments)
    try:
        libraries = engine_package.read_libraries(options.library, PLATFORMS)
        if len({name for name, _ in libraries}) != len(libraries):
            raise ValueError("--library names a platform twice")
        package = zip_bytes(package_members(options.assembly, libraries))
        write_whole(options.out / f"{ID}.{engine_package.version()}.nupkg", package)
    except (ValueError, OSError) as error:
        print(f"pack_nuget.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
