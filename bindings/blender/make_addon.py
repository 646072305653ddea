#!/usr/bin/env python3
"""Packs the add-on with all it needs into a zip that Blender installs:

    make_addon.py BUILD OUT.zip

BUILD is a build folder of FaceBaker, such as build/release. In the zip are the add-on, the Python package, the tool and the
libraries, with those they need that not every system has. Standard library only."""

import os
import pathlib
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
PYTHON = HERE.parent / "python"
sys.path.insert(0, str(PYTHON / "wheel"))

from facebaker_wheel import DATE, ROOT, needed_libraries, notices_of  # noqa: E402


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
    files[f"{carried}/bin/facebaker"] = tool.read_bytes()
    for needed in needed_libraries(tool):
        files[f"{carried}/lib/{needed.name}"] = needed.read_bytes()
        files.update({f"{carried}/{name}": text for name, text in notices_of(needed).items()})
    for needed in needed_libraries(runtime):
        files[f"{carried}/facebaker/carried/{needed.name}"] = needed.read_bytes()
    files["facebaker_blender/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    return files


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
            entry.external_attr = (0o755 if path.endswith("/bin/facebaker") else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            packed.writestr(entry, data)
    os.replace(partial, out)
    print(f"{out}: {out.stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
