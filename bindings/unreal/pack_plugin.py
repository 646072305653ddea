#!/usr/bin/env python3
"""Packs the plugin for Unreal: a folder for a project's Plugins.

    pack_plugin.py --out DIR [--library PLATFORM=FILE]...

Sources and public headers come from this tree, the version from VERSION. PLATFORM is one of Linux, Mac and Win64; Win64 takes
two files, facebaker.dll and its import library facebaker.lib. DIR appears complete or not at all, and must not be there yet.
Standard library only."""

from __future__ import annotations

import argparse
import os
import pathlib
import shutil
import sys
import tempfile
from typing import List, Optional, Tuple

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FILES = {"Linux": ("libfacebaker.so",), "Mac": ("libfacebaker.dylib",), "Win64": ("facebaker.dll", "facebaker.lib")}


def read_libraries(texts: List[str]) -> List[Tuple[str, pathlib.Path]]:
    """Raises ValueError on what is no PLATFORM=FILE, or has another name than the build rules know."""
    libraries = []
    for text in texts:
        platform, equals, name = text.partition("=")
        file = pathlib.Path(name)
        if not equals or platform not in FILES:
            raise ValueError(f"--library takes PLATFORM=FILE, with one of {', '.join(FILES)}, and not \"{text}\"")
        if file.name not in FILES[platform]:
            raise ValueError(f"{file}: a library for {platform} is called {' or '.join(FILES[platform])}")
        if not file.is_file():
            raise ValueError(f"there is no library {file}")
        libraries.append((platform, file))
    return libraries


def pack(plugin: pathlib.Path, libraries: List[Tuple[str, pathlib.Path]]) -> None:
    """Fills a folder that is not there. Raises OSError."""
    shutil.copytree(HERE / "FaceBaker", plugin, ignore=shutil.ignore_patterns("*.in"))
    version = (ROOT / "VERSION").read_text(encoding="utf-8").strip()
    manifest = (HERE / "FaceBaker" / "FaceBaker.uplugin.in").read_text(encoding="utf-8").replace("@VERSION@", version)
    (plugin / "FaceBaker.uplugin").write_text(manifest, encoding="utf-8")
    for name in ("face_pose", "linear_skin", "render_surfaces"):
        for suffix in (".h", ".cpp"):
            shutil.copy(ROOT / "bindings" / "engine" / (name + suffix), plugin / "Source" / "FaceBaker" / "Private")
    third_party = plugin / "Source" / "ThirdParty" / "FaceBaker"
    headers = third_party / "include" / "facebaker"
    headers.mkdir(parents=True)
    for name in ("facebaker.h", "facebaker.hpp", "facebaker_character.h"):
        shutil.copy(ROOT / "capi" / "include" / "facebaker" / name, headers)
    shutil.copy(ROOT / "LICENSE", plugin / "LICENSE")
    for platform, file in libraries:
        (third_party / platform).mkdir(exist_ok=True)
        shutil.copyfile(file, third_party / platform / file.name)


def main(arguments: Optional[List[str]] = None) -> int:
    parser = argparse.ArgumentParser(description="Packs the plugin for Unreal.")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="the folder to make")
    parser.add_argument("--library", action="append", default=[], metavar="PLATFORM=FILE", help="a native library to pack")
    options = parser.parse_args(arguments)
    try:
        libraries = read_libraries(options.library)
        if options.out.exists():
            raise ValueError(f"{options.out} exists already")
        options.out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=options.out.parent) as folder:
            pack(pathlib.Path(folder, "plugin"), libraries)
            os.replace(pathlib.Path(folder, "plugin"), options.out)
    except (ValueError, OSError) as error:
        print(f"pack_plugin.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
