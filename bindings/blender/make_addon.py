#!/usr/bin/env python3
"""Packs the add-on with all it needs into a zip that Blender installs, as an extension from 4.2 on and as an add-on before:

    make_addon.py BUILD OUT.zip

BUILD is a build folder of FaceBaker, such as build/release, or one that it was installed into. In the zip are the add-on, the
Python package, the tool and the libraries, with those they need that not every system has, and notices of all of it; and the
viewer, where it is installed or samples/viewer/build.sh has built it into the folder `viewer` beside BUILD. Standard library
only."""

import ast
import json
import os
import pathlib
import platform
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
PYTHON = HERE.parent / "python"
sys.path.insert(0, str(PYTHON / "wheel"))

from facebaker_wheel import DATE, ROOT, needed_libraries, notices_of, notices_of_linked, version  # noqa: E402

MACHINES = {"x86_64": "x64", "aarch64": "arm64"}  # as Blender calls them


def addon_files(build):
    """{path in the zip: bytes}"""
    tool, runtime = build / "bin" / "facebaker", build / "lib" / "libfacebaker.so"
    for path in tool, runtime:
        if not path.is_file():
            raise SystemExit(f"{path}: is not there; build the targets facebaker and libfacebaker")
    files = {f"facebaker_blender/{path.name}": path.read_bytes() for path in (HERE / "facebaker_blender").glob("*.py")}
    carried = "facebaker_blender/carried"
    for path in (PYTHON / "facebaker").glob("*.py"):
        files[f"{carried}/facebaker/{path.name}"] = path.read_bytes()
    files[f"{carried}/facebaker/libfacebaker.so"] = runtime.read_bytes()
    programs = [tool]
    server, page = build / "bin" / "facebaker-view", build / "share" / "facebaker" / "viewer"
    if not page.is_dir():
        page = build.parent / "viewer"
    if server.is_file() and (page / "index.html").is_file():
        programs.append(server)
        pages = [path for path in page.rglob("*") if path.is_file()]
        files.update({f"{carried}/share/facebaker/viewer/{path.relative_to(page)}": path.read_bytes() for path in pages})
    for program in programs:
        files[f"{carried}/bin/{program.name}"] = program.read_bytes()
        for needed in needed_libraries(program):
            files[f"{carried}/lib/{needed.name}"] = needed.read_bytes()
            files.update({f"{carried}/{name}": text for name, text in notices_of(needed).items()})
    for needed in needed_libraries(runtime):
        files[f"{carried}/facebaker/carried/{needed.name}"] = needed.read_bytes()
    for place, text in notices_of_linked([*programs, runtime]).items():
        files[f"facebaker_blender/{pathlib.PurePosixPath(place).name}"] = text
    files["facebaker_blender/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files["facebaker_blender/blender_manifest.toml"] = manifest().encode()
    return files


def manifest():
    """What Blender wants to know of an extension, as TOML. Its strings and lists are written as JSON has them."""
    tree = ast.parse((HERE / "facebaker_blender" / "__init__.py").read_text(encoding="utf-8"))
    info = next(ast.literal_eval(item.value) for item in tree.body if isinstance(item, ast.Assign))
    fields = {
        "schema_version": "1.0.0",
        "id": "facebaker_blender",  # also the folder that Blender unpacks it into, which the scripts import it by
        "version": version(),
        "name": info["name"],
        "tagline": info["description"],
        "maintainer": info["author"],
        "type": "add-on",
        "blender_version_min": "4.2.0",
        "license": ["SPDX:Apache-2.0"],
        "platforms": [f"linux-{MACHINES[platform.machine()]}"],
        "tags": ["Animation", info["category"]],
    }
    lines = [f"{key} = {json.dumps(value)}" for key, value in fields.items()]
    files = "Bakes copies of the scene, beside the archives that it writes"
    return "\n".join([*lines, "", "[permissions]", f"files = {json.dumps(files)}", ""])


def main(words):
    """What the script does: its exit code."""
    if len(words) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    out = pathlib.Path(words[1])
    partial = out.with_name(out.name + ".facebaker-partial")
    with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as packed:
        for path, data in sorted(addon_files(pathlib.Path(words[0]).resolve()).items()):
            entry = zipfile.ZipInfo(path, DATE)
            entry.external_attr = (0o755 if "/carried/bin/" in path else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            packed.writestr(entry, data)
    os.replace(partial, out)
    print(f"{out}: {out.stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
