#!/usr/bin/env python3
"""test_conformance.py READER FOLDER...: the reader accepts all of FOLDER/accepted and refuses each of FOLDER/rejected."""
import pathlib
import subprocess
import sys


def run(reader, files):
    return subprocess.run([sys.executable, "-B", reader, *map(str, files)], capture_output=True, text=True)


def main(reader, *folders):
    failures = 0
    for folder in map(pathlib.Path, folders):
        accepted, rejected = (sorted((folder / kind).glob("*.fbk")) for kind in ("accepted", "rejected"))
        if not accepted or not rejected:
            print(f"{folder}: no archives")
            failures += 1
        done = run(reader, accepted)
        lines = done.stdout.splitlines()
        if done.returncode != 0 or len(lines) != len(accepted):
            print(f"{folder}: {done.stderr}")
            failures += 1
        poses = sum(int(line.rsplit(": ", 1)[1].split()[0]) for line in lines)
        print(f"{folder}: {len(lines)} accepted, {poses} poses")
        for file in rejected:
            done = run(reader, [file])
            if done.returncode != 1 or not done.stderr.startswith(f"{file}: "):
                print(f"{file}: exit code {done.returncode}: {done.stderr or 'accepted'}")
                failures += 1
        print(f"{folder}: {len(rejected)} rejected")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
