#!/usr/bin/env python3
"""Whether third_party.json names all that is in our binaries, and no more: the headers that the compiler read, by the
dependencies that Ninja keeps, and the libraries that the linker was given. Then whether both notices name all of it.

    test_notices.py SOURCE BUILD

Exit code 77, skipped: the build is not Ninja's, or this is no Debian machine."""

from __future__ import annotations

import json
import pathlib
import re
import subprocess
import sys
from typing import Dict, Iterable, List, Set

# What every program of the system is made with.
OF_THE_SYSTEM = re.compile(r"lib(c6|stdc\+\+-\d+|gcc-\d+|c\+\+-\d+|clang-common-\d+|omp-\d+)(-dev)?$|linux-libc-dev$|lib(gomp1|omp5-\d+)$")
# Our binaries: which object files are in them, and their names in the build.
OBJECTS = {
    "facebaker": r"core/(base/)?CMakeFiles/fb_(runtime|base)\.dir/|capi/CMakeFiles/libfacebaker\.dir/",
    "facebaker_bake": r"core/(base/|bake/|bake/linalg/)?CMakeFiles/fb_\w+\.dir/|capi/CMakeFiles/libfacebaker_bake\.dir/",
    "tool": r"core/base/CMakeFiles/fb_base\.dir/|core/bake/CMakeFiles/fb_tinygltf\.dir/|packager/(?!server/|ranks/)",
    "view": r"core/base/CMakeFiles/fb_base\.dir/|core/bake/CMakeFiles/fb_tinygltf\.dir/|packager/(?!ranks/)",
    "mpi": r"core/base/CMakeFiles/fb_base\.dir/|core/bake/CMakeFiles/fb_tinygltf\.dir/|packager/(?!server/)",
}
FILES = {
    "facebaker": "lib/libfacebaker.so",
    "facebaker_bake": "lib/libfacebaker_bake.so",
    "tool": "bin/facebaker",
    "view": "bin/facebaker-view",
    "mpi": "bin/facebaker-mpi",  # built where there is an MPI
}


def output_of(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout


def read_dependencies(build: pathlib.Path) -> Dict[str, List[str]]:
    """The headers outside of the tree that each object file was compiled from."""
    headers: Dict[str, List[str]] = {}
    current = ""
    for line in output_of("ninja", "-C", str(build), "-t", "deps").splitlines():
        if line and line[0] != " ":
            current = line.split(":")[0]
            headers[current] = []
        elif line.strip().startswith("/usr/"):
            headers[current].append(line.strip())
    return headers


def linked_files(build: pathlib.Path, file: str) -> Set[str]:
    """The libraries outside of the build that the linker was given for a file."""
    lines = (build / "build.ninja").read_text(encoding="utf-8").splitlines()
    for number, line in enumerate(lines):
        if re.match(rf"build {re.escape(file)}[\d.]*[: ]", line) and "LINKER" in line:
            for setting in lines[number:]:
                if setting.strip().startswith("LINK_LIBRARIES"):
                    return set(re.findall(r"/usr/\S+\.(?:a|so)\b\S*", setting))
    return set()


def packages_of(files: Iterable[str]) -> Set[str]:
    """The Debian packages of files, but those of the system; files of none stand for themselves."""
    found: Set[str] = set()
    paths = sorted({str(pathlib.Path(file).resolve()) for file in files})
    for begin in range(0, len(paths), 200):
        part = paths[begin : begin + 200]
        owners: Dict[str, str] = {}
        for line in output_of("dpkg-query", "--search", *part).splitlines():
            names, _, path = line.partition(": ")
            owners[path] = names
        for path in part:
            found |= {name.split(":")[0] for name in owners[path].split(", ")} if path in owners else {path}
    return {name for name in found if not OF_THE_SYSTEM.match(name)}


def headers_of(package: str) -> str:
    """The package with the headers of a shared library's; other packages stay."""
    if package == "libturbojpeg0":
        return package + "-dev"
    if re.match(r"libssl3(t64)?$", package):
        return "libssl-dev"
    return re.sub(r"^lib(meshoptimizer|microhttpd|openmpi|mpich|utf8proc|webp|png)[\d.-]+(d|t64)?$", r"lib\1-dev", package)


def main(arguments: List[str]) -> int:
    root, build = pathlib.Path(arguments[0]), pathlib.Path(arguments[1])
    if not (build / "build.ninja").exists() or not pathlib.Path("/usr/bin/dpkg-query").exists():
        print("skipped: not built by Ninja on a Debian machine")
        return 77
    sys.path.insert(0, str(root / "packager" / "packages"))
    import notices  # type: ignore[import]

    dependencies = read_dependencies(build)
    problems: List[str] = []
    built = {user: build / file for user, file in FILES.items() if user != "mpi" or (build / file).exists()}
    for user, binary in built.items():
        pattern = OBJECTS[user]
        used = {header for name, headers in dependencies.items() if re.match(pattern, name) for header in headers}
        libraries = linked_files(build, FILES[user])
        if not used or not libraries:
            problems.append(f"{user}: no object files or no libraries are known of it")
        packages = packages_of(used | libraries)
        # A shared library and its headers are two packages.
        packages = {headers_of(name) for name in packages}
        listed = {one["package"] for one in notices.linked_into(binary)}
        problems += [f"{user}: {name} is used, and not in third_party.json" for name in sorted(packages - listed)]
        problems += [f"{user}: {name} is in third_party.json, and not used" for name in sorted(listed - packages)]
    problems += check_notices(notices, list(built.values()))
    print("\n".join(problems) or f"{len(notices.used_by(built.values()))} components are named in {len(built)} binaries")
    return 1 if problems else 0


def check_notices(notices, binaries: List[pathlib.Path]) -> List[str]:  # type: ignore[no-untyped-def]
    """What the notices leave out."""
    texts = notices.notices("1.2", binaries)
    if texts != notices.notices("1.2", binaries):
        return ["the notices are not the same a second time"]
    document = json.loads(texts["facebaker.spdx.json"])
    packages = {package["SPDXID"]: package for package in document["packages"]}
    links = {(r["spdxElementId"], r["relatedSpdxElement"]): r["relationshipType"] for r in document["relationships"]}
    problems = [f"SPDX: {one} is not described" for pair in links for one in pair if one not in packages and one != "SPDXRef-DOCUMENT"]
    for one in notices.used_by(binaries).values():
        package = packages.get(notices.spdx_id(one["name"]))
        if package is None or package["licenseConcluded"] != one["licence"] or "versionInfo" not in package:
            problems.append(f"SPDX: {one['name']} has no version or licence")
        if f"\n{one['name']} " not in texts["THIRD-PARTY.txt"] or len(notices.licence_text(one["package"])) < 200:
            problems.append(f"THIRD-PARTY.txt: {one['name']} has no version or licence")
        for binary in binaries:
            used = one in notices.linked_into(binary)
            link = links.get((notices.spdx_id(notices.shown_name(binary)), notices.spdx_id(one["name"])))
            if used != (link in ("STATIC_LINK", "DYNAMIC_LINK")):
                problems.append(f"SPDX: {binary.name} and {one['name']}: {link}")
    return problems


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
