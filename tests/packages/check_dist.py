"""Checks the files of a folder that build_dist.py filled: check_dist.py DIST. Each of ours has a licence and both notices; a library
for one platform is the same in every package that carries it; no file names a folder of the machine it was built on."""

import io
import pathlib
import re
import sys
import tarfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
NOTICES = ("LICENSE", "THIRD-PARTY.txt", "facebaker.spdx.json")
# Packages in which the library is another build: with baking, and for this machine alone.
OWN_BUILD = re.compile(r"^facebaker-[\d.]+-Linux|_blender|manylinux_[\d_]+_x86_64")


def read_archive(path):
    """{name in it: bytes}; links are left out."""
    data = path.read_bytes()
    if data[:2] == b"PK":
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return {name: archive.read(name) for name in archive.namelist()}
    with tarfile.open(fileobj=io.BytesIO(data)) as archive:
        return {entry.name: archive.extractfile(entry).read() for entry in archive if entry.isfile()}


def machine_of(data):
    """Of a library: the first bytes and, of ELF, the processor."""
    return data[:2] + (data[18:20] if data[:4] == b"\x7fELF" else b"")


def main():
    folder = pathlib.Path(sys.argv[1])
    problems, libraries, checked = [], {}, 0
    for path in sorted(folder.iterdir()):
        if path.name == "SHA256SUMS" or path.suffix == ".deb" or path.name.endswith("-source.tar.gz") or "_vcpkg-" in path.name:
            continue  # Debian's are tested by run.sh; sources have nothing of others in them
        checked += 1
        files = read_archive(path)
        for notice in NOTICES:
            stem = notice.split(".")[0] if notice == "LICENSE" else notice
            if not any(name.rpartition("/")[2].startswith(stem) and len(data) > 500 for name, data in files.items()):
                problems.append(f"{path.name} has no {notice}")
        for name, data in files.items():
            if str(ROOT).encode() in data:
                problems.append(f"{path.name}: {name} names {ROOT}")
            if re.search(r"(^|/)(libfacebaker\.so|facebaker\.dll)$", name) and not OWN_BUILD.search(path.name):
                libraries.setdefault((name.rpartition("/")[2], machine_of(data)), {}).setdefault(data, []).append(path.name)
    for (name, _), kinds in libraries.items():
        # Of Linux' runtime there are two, which differ in the name they are looked for by: that of engines is a file, the other a link.
        if len(kinds) > 1:
            problems.append(f"{name} is not the same in {' and '.join(packages[0] for packages in kinds.values())}")
    print("\n".join(problems) or f"{checked} packages have notices; {len(libraries)} libraries are the same in all that carry them")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
