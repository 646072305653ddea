#!/usr/bin/env python3
"""check_hashes.py FOLDER...: FOLDER/SHA256SUMS has every archive of the folder and its SHA-256, as sha256sum prints them.

Golden archives of a frozen version never change: new ones are added with their lines."""
import hashlib
import pathlib
import sys


def main(folder: pathlib.Path) -> int:
    lines = (folder / "SHA256SUMS").read_text().splitlines()
    listed = {name: digest for digest, name in (line.split("  ", 1) for line in lines)}
    there = {str(path.relative_to(folder)): path for path in sorted(folder.rglob("*.fbk"))}
    wrong = [f"{name} is gone" for name in sorted(listed.keys() - there.keys())]
    for name, path in there.items():
        if name not in listed:
            wrong.append(f"{name} is not listed")
        elif hashlib.sha256(path.read_bytes()).hexdigest() != listed[name]:
            wrong.append(f"{name} has changed")
    print(*wrong, f"{len(there)} archives", sep="\n")
    return 1 if wrong or not there else 0


if __name__ == "__main__":
    sys.exit(max(main(pathlib.Path(folder)) for folder in sys.argv[1:]))
