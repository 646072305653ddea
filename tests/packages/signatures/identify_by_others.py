"""Gives archives and files of other formats to programs that identify files, under names that say nothing, and compares what they
say with what the files are. Run by run_identifiers.sh.
    identify_by_others.py FOLDER     FOLDER: holds firebird/, mime/ and file_types.mjs"""

import csv
import os
import pathlib
import shutil
import subprocess
import sys

from other_formats import other_formats
from test_signatures import DESKTOP, expected_of, golden_archives

MEDIA_TYPE = "application/x-facebaker"


def run(command, **more):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True, **more).stdout


def put_files(folder, firebird):
    """Writes all files into the folder, and returns their contents by path."""
    contents = [data for _, _, data in golden_archives()] + list(other_formats().values())
    contents += [path.read_bytes() for path in sorted(firebird.iterdir())]
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    files = {folder / f"{number:04}": data for number, data in enumerate(contents)}
    for path, data in files.items():
        path.write_bytes(data)
    return files


def compare(name, files, found, expected):
    """Fails where found, in the order of files, is not what is expected of the bytes."""
    wrong = [f"{path}: {one}" for (path, data), one in zip(files.items(), found, strict=True) if one != expected(data)]
    if wrong:
        sys.exit(f"{name} says of {len(wrong)} of {len(files)} files what they are not: {wrong[:5]}")
    archives = sum(bool(expected_of(data)) for data in files.values())
    print(f"{name}: {archives} archives and {len(files) - archives} other files as they are")


def ours(kinds):
    return [kind == MEDIA_TYPE for kind in kinds]


def is_archive(data):
    return bool(expected_of(data))


def identified_by_siegfried(folder, files):
    """By the signatures of DROID's syntax alone, compiled by roy."""
    home = folder / "siegfried"
    home.mkdir(exist_ok=True)
    shutil.copy(DESKTOP / "facebaker-signature.xml", home)
    run(["roy", "build", "-home", home, "-noreports", "-nocontainer", "-droid", "facebaker-signature.xml", home / "face.sig"])
    rows = csv.DictReader(run(["sf", "-home", home, "-sig", "face.sig", "-csv", *files]).splitlines())
    return [[row["id"]] if row["id"].startswith("dev/") else [] for row in rows]  # siegfried knows plain text by itself


def identified_by_fido(files):
    """Of PRONOM's formats and ours, those of ours; fido says nothing of empty files."""
    lines = run(["fido", "-q", "-nocontainer", "-loadformats", DESKTOP / "facebaker-fido.xml", "-matchprintf",
                 "%(info.filename)s\t%(info.puid)s\n", "-nomatchprintf", "", *files]).splitlines()
    found = {}
    for path, _, puid in (line.partition("\t") for line in lines):
        found.setdefault(path, []).extend([puid] if puid.startswith("dev/") else [])
    return [found.get(str(path), []) for path in files]


def main(folder):
    files = put_files(folder / "nameless", folder / "firebird")
    magic = ["file", "--brief", "--mime-type"]
    compare("file(1)", files, ours(run([*magic, "-m", DESKTOP / "facebaker.magic", *files]).splitlines()), is_archive)
    # The database of the folder alone: what is installed here has no say.
    shared = {**os.environ, "XDG_DATA_HOME": "/nonexistent", "XDG_DATA_DIRS": str(folder)}
    kinds = run(["mimetype", "--brief", "--magic-only", *files], env=shared).splitlines()
    compare("shared-mime-info", files, ours(kinds), is_archive)
    if shutil.which("roy") and shutil.which("sf"):
        compare("siegfried", files, identified_by_siegfried(folder, files), expected_of)
    else:
        print("siegfried: not installed (roy, sf)")
    if shutil.which("fido"):
        compare("fido", files, identified_by_fido(files), expected_of)
    else:
        print("fido: not installed")

    # Who has not heard of archives takes them for nothing else.
    archives = {path: data for path, data in files.items() if is_archive(data)}
    compare("file(1) without our magic", archives, run([*magic, *archives]).splitlines(), lambda data: "application/octet-stream")
    compare("file-type", archives, run(["node", "file_types.mjs", *archives], cwd=folder).splitlines(), lambda data: "unknown")


main(pathlib.Path(sys.argv[1]))
