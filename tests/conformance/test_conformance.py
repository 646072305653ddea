#!/usr/bin/env python3
"""test_conformance.py FOLDER...: the independent reader accepts all of FOLDER/accepted and refuses each of FOLDER/rejected."""
import contextlib
import io
import pathlib
import sys
from typing import Tuple

import fbk_read


def run(file: pathlib.Path) -> Tuple[int, str, str]:
    """What the reader returns and prints."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = fbk_read.main([str(file)])
    return code, out.getvalue(), err.getvalue()


def main(*folders):
    failures = 0
    for folder in map(pathlib.Path, folders):
        accepted, rejected = (sorted((folder / kind).glob("*.fbk")) for kind in ("accepted", "rejected"))
        if not accepted or not rejected:
            print(f"{folder}: no archives")
            failures += 1
        poses = 0
        for file in accepted:
            code, out, err = run(file)
            if code != 0 or not out.startswith(f"{file}: "):
                print(f"{file}: exit code {code}: {err}")
                failures += 1
            else:
                poses += int(out.rsplit(": ", 1)[1].split()[0])
        print(f"{folder}: {len(accepted)} accepted, {poses} poses")
        for file in rejected:
            code, _, err = run(file)
            if code != 1 or not err.startswith(f"{file}: "):
                print(f"{file}: exit code {code}: {err or 'accepted'}")
                failures += 1
        print(f"{folder}: {len(rejected)} rejected")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
