#!/usr/bin/env python3
"""Packs the Unity package: a folder for "Add package from disk", or for an archive of it.

    pack_unity.py --out DIR [--library PLATFORM=FILE]...

Sources come from this tree, the interop layer from the public headers, the version from VERSION. PLATFORM is one of
linux-x64, windows-x64, macos, android-arm64, ios: each library goes where Unity finds it, with import settings for that platform
alone. Every file gets its .meta with an identifier made of its path, so that references in projects outlive a new version. DIR
appears complete or not at all, and must not be there yet. Standard library only."""

from __future__ import annotations

import hashlib
import pathlib
import shutil
import sys
from typing import Dict, List, NamedTuple, Optional

import generate_interop

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "bindings" / "engine"))
import engine_package  # noqa: E402

PACKAGE = "org.facebaker.unity"


class Platform(NamedTuple):
    """Where a library goes, and what Unity calls its platform, processor and, in the editor, system."""

    file: str
    unity: str
    cpu: str
    editor: Optional[str]


PLATFORMS: Dict[str, Platform] = {
    "linux-x64": Platform("libfacebaker.so", "Standalone: Linux64", "x86_64", "Linux"),
    "windows-x64": Platform("facebaker.dll", "Standalone: Win64", "x86_64", "Windows"),
    "macos": Platform("libfacebaker.dylib", "Standalone: OSXUniversal", "AnyCPU", "OSX"),
    "android-arm64": Platform("libfacebaker.so", "Android: Android", "ARM64", None),
    "ios": Platform("libfacebaker.a", "iPhone: iOS", "AnyCPU", None),
}


def guid(path: str) -> str:
    """An identifier that stays the same as long as the path does."""
    return hashlib.md5(f"{PACKAGE}/{path}".encode()).hexdigest()


def platform_data(first: str, enabled: bool, settings: Dict[str, str]) -> List[str]:
    lines = ["  - first:", f"      {first}", "    second:", f"      enabled: {int(enabled)}"]
    return lines + (["      settings:"] + [f"        {name}: {value}" for name, value in settings.items()] if settings
                    else ["      settings: {}"])


def plugin_lines(platform: Platform) -> List[str]:
    """Import settings of a library: for its platform, and for the editor on the same system."""
    editor = {"CPU": platform.cpu, "DefaultValueInitialized": "true", "OS": platform.editor} if platform.editor else {}
    return ["PluginImporter:", "  serializedVersion: 2", "  isPreloaded: 0", "  isOverridable: 0", "  platformData:",
            *platform_data("Any: ", False, {}), *platform_data("Editor: Editor", bool(platform.editor), editor),
            *platform_data(platform.unity, True, {"CPU": platform.cpu})]


def importer_lines(path: pathlib.Path) -> List[str]:
    if path.is_dir():
        return ["folderAsset: yes", "DefaultImporter:", "  externalObjects: {}"]
    if path.parent.parent.name == "Plugins":
        return plugin_lines(PLATFORMS[path.parent.name])
    if path.suffix == ".cs":
        return ["MonoImporter:", "  serializedVersion: 2", "  executionOrder: 0"]
    if path.suffix == ".asmdef":
        return ["AssemblyDefinitionImporter:", "  externalObjects: {}"]
    return ["TextScriptImporter:", "  externalObjects: {}"] if path.name != "package.json" else [
        "PackageManifestImporter:", "  externalObjects: {}"]


def write_metas(package: pathlib.Path) -> None:
    for path in sorted(package.rglob("*")):
        lines = ["fileFormatVersion: 2", "guid: " + guid(path.relative_to(package).as_posix()), *importer_lines(path)]
        path.with_name(path.name + ".meta").write_text("\n".join(lines) + "\n", encoding="utf-8")


def pack(package: pathlib.Path, libraries: engine_package.Libraries) -> None:
    """Fills an empty folder. Raises OSError, or HeaderError of generate_interop."""
    for folder in ("Runtime", "Editor"):
        shutil.copytree(HERE / "unity" / folder, package / folder)
    for source in sorted((HERE / "runtime").glob("*.cs")):
        shutil.copy(source, package / "Runtime" / source.name)
    headers = ROOT / "capi" / "include" / "facebaker"
    interop = generate_interop.interop_lines(headers)
    (package / "Runtime" / "NativeInterop.cs").write_text("\n".join(interop) + "\n", encoding="utf-8")
    manifest = (HERE / "unity" / "package.json.in").read_text(encoding="utf-8")
    manifest = manifest.replace("@VERSION@", engine_package.version())
    (package / "package.json").write_text(manifest, encoding="utf-8")
    shutil.copy(HERE / "unity" / "README.md", package / "README.md")
    shutil.copy(ROOT / "LICENSE", package / "LICENSE.md")
    for name, library in dict(libraries).items():
        place = package / "Plugins" / name / PLATFORMS[name].file
        place.parent.mkdir(parents=True)
        shutil.copyfile(library, place)
    engine_package.write_notices(package, libraries)
    write_metas(package)


def main(arguments: Optional[List[str]] = None) -> int:
    return engine_package.main("pack_unity.py", "Packs the Unity package.", PLATFORMS, pack, arguments)


if __name__ == "__main__":
    sys.exit(main())
