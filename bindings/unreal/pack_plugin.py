#!/usr/bin/env python3
"""Packs the plugin for Unreal: a folder for a project's Plugins.

    pack_plugin.py --out DIR [--library PLATFORM=FILE]...

Sources and public headers come from this tree, the version from VERSION. PLATFORM is one of Linux, LinuxArm64, Mac and Win64; Win64
takes two files, facebaker.dll and its import library facebaker.lib. DIR appears complete or not at all, and must not be there yet.
Standard library only."""

from __future__ import annotations

import pathlib
import shutil
import sys
from typing import List, Optional

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "bindings" / "engine"))
import engine_package  # noqa: E402

FILES = {"Linux": ("libfacebaker.so",), "LinuxArm64": ("libfacebaker.so",), "Mac": ("libfacebaker.dylib",), "Win64": ("facebaker.dll", "facebaker.lib")}


def pack(plugin: pathlib.Path, libraries: engine_package.Libraries) -> None:
    """Fills an empty folder. Raises OSError, or ValueError on a library of another name than the build rules know."""
    for platform, file in libraries:
        if file.name not in FILES[platform]:
            raise ValueError(f"{file}: a library for {platform} is called {' or '.join(FILES[platform])}")
    shutil.copytree(HERE / "FaceBaker", plugin, ignore=shutil.ignore_patterns("*.in"), dirs_exist_ok=True)
    manifest = (HERE / "FaceBaker" / "FaceBaker.uplugin.in").read_text(encoding="utf-8")
    manifest = manifest.replace("@VERSION@", engine_package.version())
    (plugin / "FaceBaker.uplugin").write_text(manifest, encoding="utf-8")
    for name in ("face_pose", "linear_skin", "render_surfaces"):
        for suffix in (".h", ".cpp"):
            shutil.copy(ROOT / "bindings" / "engine" / (name + suffix), plugin / "Source" / "FaceBaker" / "Private")
    third_party = plugin / "Source" / "ThirdParty" / "FaceBaker"
    headers = third_party / "include" / "facebaker"
    headers.mkdir(parents=True)
    for name in ("facebaker.h", "facebaker.hpp", "facebaker_character.h", "facebaker_solve.h"):
        shutil.copy(ROOT / "capi" / "include" / "facebaker" / name, headers)
    shutil.copy(ROOT / "LICENSE", plugin / "LICENSE")
    for platform, file in libraries:
        (third_party / platform).mkdir(exist_ok=True)
        shutil.copyfile(file, third_party / platform / file.name)
    engine_package.write_notices(plugin, [(platform, file) for platform, file in libraries if file.suffix != ".lib"])


def main(arguments: Optional[List[str]] = None) -> int:
    return engine_package.main("pack_plugin.py", "Packs the plugin for Unreal.", FILES, pack, arguments)


if __name__ == "__main__":
    sys.exit(main())
