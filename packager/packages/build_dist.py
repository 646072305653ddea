#!/usr/bin/env python3
"""Builds what is given to users, for every platform that this machine builds for, with checksums:

    build_dist.py [--only PART,...] [--without PART,...] [--debs] [--without-viewer] [--platforms NAME,...]
                  [--library PLATFORM=FILE]... [--uncommitted] [OUT_DIR]     by default build/dist

docs/packages.md has a table of the files and parts. A whole run takes an hour or so on two cores; builds are kept
in build/dist-*. OUT_DIR is made anew; with --only or --without, files of other parts stay. SHA256SUMS is of all that are
there. Files appear when all of them are made, dated by the commit: the same commit gives the same bytes on the same machine.

--platforms: what the runtime, wheels and plugins are made for. --library: a library that was built elsewhere, such as
macos=libfacebaker.dylib, for the packages that carry those of several platforms. FB_CMAKE_OPTIONS in the environment: for every
build, such as those by which a compiler cache knows sources again.
Python 3.11 or newer; standard library only."""

from __future__ import annotations

import argparse
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
from typing import Callable, Iterable, List, Optional

sys.dont_write_bytecode = True
import dist_builds  # noqa: E402
from dist_builds import PLATFORMS, ROOT, WORK  # noqa: E402
from dist_parts import PARTS, Work  # noqa: E402
import engine_package  # noqa: E402 (dist_parts says where it is)


def parse(arguments: Optional[List[str]]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Builds what is given to users, with checksums.")
    parser.add_argument("--only", type=names_of(PARTS), metavar="PART,...", help=f"of {', '.join(PARTS)}")
    parser.add_argument("--without", type=names_of(PARTS), metavar="PART,...", default=[], help="all parts but these")
    parser.add_argument("--debs", action="store_true", help="Debian packages as well, which are built apart")
    parser.add_argument("--without-viewer", action="store_true", help="the tool without its page for the browser")
    parser.add_argument("--platforms", type=names_of(PLATFORMS), metavar="NAME,...", help=f"of {', '.join(PLATFORMS)}")
    parser.add_argument("--library", action="append", default=[], metavar="PLATFORM=FILE", help="a library built elsewhere")
    parser.add_argument("--uncommitted", action="store_true", help="build a tree that is no commit's")
    parser.add_argument("out", nargs="?", type=pathlib.Path, default=ROOT / "build" / "dist", metavar="OUT_DIR")
    return parser.parse_args(arguments)


def names_of(known: Iterable[str]) -> Callable[[str], List[str]]:
    """Reads a list of names with commas."""

    def read(text: str) -> List[str]:
        names = text.split(",")
        for name in names:
            if name not in known:
                raise argparse.ArgumentTypeError(f"\"{name}\" is none of {', '.join(known)}")
        return names

    return read


def chosen_parts(options: argparse.Namespace) -> List[str]:
    if options.only:
        return [name for name in PARTS if name in options.only and name not in options.without]
    here = [name for name, part in PARTS.items() if sys.platform == "linux" or not part.linux]
    return [name for name in here if name not in options.without and (name != "debs" or options.debs)]


def problems_with(parts: List[str], platforms: List[str], uncommitted: bool) -> List[str]:
    """What is to be done before anything is built, in sentences."""
    problems = dist_builds.missing_tools(platforms)
    for name in parts:
        missing = [(tool, cure) for tool, cure in PARTS[name].tools if not dist_builds.is_there(tool)]
        problems += [f"{name} needs {tool}: {cure}, or leave it out: --without {name}" for tool, cure in missing]
    if sys.platform == "linux" and "linux-x64" not in platforms and {"godot3", "godot4"} & set(parts):
        problems.append("Godot's addons need linux-x64 among --platforms")
    if not uncommitted:
        changed = subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
        problems += ["the tree is no commit's: commit what is changed, or say --uncommitted"] if changed else []
    return problems


def write_sums(folder: pathlib.Path) -> None:
    """As sha256sum reads them."""
    files = sorted(path for path in folder.iterdir() if path.name != "SHA256SUMS")
    lines = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files]
    (folder / "SHA256SUMS").write_bytes("".join(lines).encode())  # with the ends of lines of Unix on every system


def deliver(made: pathlib.Path, out: pathlib.Path, whole: bool) -> None:
    """The folder of what was made gets its name; unless it is the whole, it takes the files of other parts along."""
    if out.exists() and not whole:
        for path in out.iterdir():
            if not (made / path.name).exists() and path.name != "SHA256SUMS":
                shutil.copy2(path, made / path.name)
    write_sums(made)
    made.chmod(0o755)
    if out.exists():
        old = pathlib.Path(tempfile.mkdtemp(prefix=".old-", dir=out.parent))
        os.replace(out, old / "dist")
        os.replace(made, out)
        shutil.rmtree(old)
    else:
        os.replace(made, out)


def main(arguments: Optional[List[str]] = None) -> int:
    options = parse(arguments)
    parts = chosen_parts(options)
    platforms = dist_builds.USUAL[sys.platform] if options.platforms is None else options.platforms
    try:
        given = engine_package.read_libraries(options.library, [*PLATFORMS, *dist_builds.ELSEWHERE])
        needed = [name for name in platforms if name not in dict(given) or "runtime" in parts]
        problems = problems_with(parts, needed, options.uncommitted)
    except (ValueError, OSError, subprocess.CalledProcessError) as error:
        problems = [str(error)]
    if problems:
        print("\n".join(f"build_dist.py: {problem}" for problem in problems), file=sys.stderr)
        return 1
    date = subprocess.run(["git", "log", "-1", "--format=%ct"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    os.environ.setdefault("SOURCE_DATE_EPOCH", date.strip())
    out = options.out.resolve()
    for folder in (WORK, out.parent):
        folder.mkdir(parents=True, exist_ok=True)
    made = pathlib.Path(tempfile.mkdtemp(prefix=".dist-", dir=out.parent))
    try:
        work = Work(platforms, given, viewer=not options.without_viewer)
        for name in parts:
            print(f"build_dist.py: {name}", flush=True)
            PARTS[name].make(work, made)
        deliver(made, out, whole=not options.only and not options.without)
    except subprocess.CalledProcessError as error:
        command = " ".join(str(word) for word in error.cmd)
        print(f"build_dist.py: {name}: exit code {error.returncode} of {command}", file=sys.stderr)
        return 1
    except (ValueError, OSError) as error:
        print(f"build_dist.py: {name}: {error}", file=sys.stderr)
        return 1
    finally:
        shutil.rmtree(made, ignore_errors=True)
    for path in sorted(out.iterdir()):
        print(f"{path.stat().st_size:12,}  {path.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
