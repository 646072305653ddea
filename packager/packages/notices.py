#!/usr/bin/env python3
"""Writes what of others is in our libraries and programs: THIRD-PARTY.txt, with the texts of the licences, and
facebaker.spdx.json, a software bill of materials (SPDX 2.3).

    notices.py OUT_DIR VERSION BINARY...

BINARY: built libraries and programs, of any platform; what is linked into libfacebaker, libfacebaker_bake, the tool, the tool
with a web server, facebaker-view, and the tool with MPI, facebaker-mpi, is listed in third_party.json, which a test
compares with what the compiler read and the linker was given, and what MinGW links into each library of Windows. The same
library for several processors counts once. Versions and licences are those of the Debian packages of
this machine; on other systems versions are left out and licences are named only.
Standard library only; the same inputs give the same bytes, dated by SOURCE_DATE_EPOCH or 1980."""

from __future__ import annotations

import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
from typing import Any, Dict, List, Optional

HERE = pathlib.Path(__file__).resolve().parent
DOCUMENTATION = pathlib.Path("/usr/share/doc")
LIBRARY = re.compile(r"(?:lib)?(facebaker(?:_bake)?)(?:_solve)?(?:-scalar)?\.(?:so|dll|dylib|a|wasm)\b")
Component = Dict[str, Any]


def components() -> List[Component]:
    """The table of what is linked: dictionaries of name, licence (an SPDX expression), package, home, in, of library,
    the name of the shared library where it is not the component's, and of only_loaded: whether it counts for the
    binaries alone that load it, as one MPI of several."""
    table: List[Component] = json.loads((HERE / "third_party.json").read_text(encoding="utf-8"))
    return table


def user_of(binary: pathlib.Path) -> str:
    """By which of our names a binary is known in the table."""
    found = LIBRARY.match(binary.name)
    if found:
        return found.group(1)
    return {"facebaker-view": "view", "facebaker-mpi": "mpi"}.get(binary.name, "tool")


def linked_into(binary: pathlib.Path) -> List[Component]:
    users = {user_of(binary)}
    if binary.suffix == ".dll" and b"Mingw-w64" in binary.read_bytes():  # else Visual Studio's libraries are loaded
        users.add("mingw")
    listed = [one for one in components() if users & set(one["in"])]
    return [one for one in listed if not one.get("only_loaded") or is_loaded(one, needed_of(binary))]


def used_by(binaries: List[pathlib.Path]) -> Dict[str, Component]:
    """What is linked into any of the binaries, by name."""
    table = {str(one["name"]): one for binary in binaries for one in linked_into(binary)}
    return dict(sorted(table.items(), key=lambda item: item[0].lower()))


def debian_version(package: str) -> str:
    """Of an installed package, without epoch, revision and marks of repacking; "" if there is none."""
    try:
        shown = subprocess.run(
            ["dpkg-query", "--show", "--showformat=${Version}", package], capture_output=True, text=True
        )
    except OSError:
        return ""
    upstream = re.sub(r"^\d+:|-[^-]*$", "", shown.stdout.strip())
    return re.sub(r"[+.](ds|dfsg)$", "", upstream)


def licence_text(package: str) -> str:
    """The copyright file of an installed Debian package; "" elsewhere."""
    file = DOCUMENTATION / package / "copyright"
    return file.read_text(encoding="utf-8") if file.is_file() else ""


def needed_of(binary: pathlib.Path) -> List[str]:
    """The shared libraries that a binary loads, by their names; none are known where there is no readelf."""
    try:
        shown = subprocess.run(["readelf", "--dynamic", "--wide", binary], capture_output=True, text=True).stdout
    except OSError:
        return []
    return re.findall(r"\(NEEDED\).*\[(.+?)\]", shown)


def is_loaded(component: Component, needed: List[str]) -> bool:
    """Whether a component is a shared library that is loaded, and not part of the binary."""
    stem = component.get("library", component["name"].lower())
    return any(name.startswith(f"lib{stem}.so") for name in needed)


def third_party_text(binaries: List[pathlib.Path]) -> str:
    """For people: who uses what, then each licence."""
    used = used_by(binaries)
    lines = ["FaceBaker is under the Apache License 2.0, see LICENSE. It has parts of others in it:", ""]
    for name, one in used.items():
        users = [binary for binary in binaries if one in linked_into(binary)]
        loaded = any(is_loaded(one, needed_of(binary)) for binary in users)
        version = debian_version(one["package"])
        lines.append(f"{name}{' ' + version if version else ''}, {one['licence']}, {one['home']}")
        lines.append(f"    {'loaded by' if loaded else 'linked into'} {', '.join(shown_name(user) for user in users)}")
    for name, one in used.items():
        text = licence_text(one["package"]) or f"{one['licence']}; its text is at {one['home']}\n"
        lines += ["", "=" * 100, name, "=" * 100, "", text.rstrip()]
    return "\n".join(lines) + "\n"


def shown_name(binary: pathlib.Path) -> str:
    return re.sub(r"\.(so.*|dylib|a)$", "", binary.name)


def spdx_id(name: str) -> str:
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", name)


def spdx_package(name: str, version: str, licence: str, home: str, purpose: Optional[str] = None) -> Dict[str, Any]:
    package: Dict[str, Any] = {
        "SPDXID": spdx_id(name),
        "name": name,
        "downloadLocation": home or "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": licence,
        "licenseDeclared": licence,
        "copyrightText": "NOASSERTION",
    }
    if version:
        package["versionInfo"] = version
    if purpose:
        package["primaryPackagePurpose"] = purpose
    return package


def bill_of_materials(version: str, binaries: List[pathlib.Path]) -> Dict[str, Any]:
    """The SPDX document: our binaries, what is linked into each, and what each loads."""
    packages, relationships = [], []
    loaded_packages: Dict[str, Dict[str, Any]] = {}
    used = used_by(binaries)
    for binary in binaries:
        name, needed = shown_name(binary), needed_of(binary)
        purpose = "LIBRARY" if LIBRARY.match(binary.name) else "APPLICATION"
        packages.append(spdx_package(name, version, "Apache-2.0", "", purpose))
        relationships.append(relation("SPDXRef-DOCUMENT", "DESCRIBES", spdx_id(name)))
        for one in linked_into(binary):
            kind = "DYNAMIC_LINK" if is_loaded(one, needed) else "STATIC_LINK"
            relationships.append(relation(spdx_id(name), kind, spdx_id(one["name"])))
        known = [one for one in linked_into(binary) if is_loaded(one, needed)]
        for library in needed:
            if any(is_loaded(one, [library]) for one in known) or library.startswith("ld-linux"):
                continue
            own = re.sub(r"\.so.*", "", library) in {shown_name(other) for other in binaries}
            if not own:
                loaded_packages[library] = spdx_package(library, "", "NOASSERTION", "", "LIBRARY")
            target = spdx_id(shown_name(pathlib.Path(library)) if own else library)
            relationships.append(relation(spdx_id(name), "DYNAMIC_LINK", target))
    for one in used.values():
        packages.append(spdx_package(one["name"], debian_version(one["package"]), one["licence"], one["home"], "LIBRARY"))
    packages += [loaded_packages[name] for name in sorted(loaded_packages)]
    contents = json.dumps([packages, relationships], sort_keys=True)
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"facebaker-{version}",
        "documentNamespace": f"urn:sha256:{hashlib.sha256(contents.encode()).hexdigest()}",
        "creationInfo": {"created": date_of_creation(), "creators": ["Tool: facebaker-notices"]},
        "packages": packages,
        "relationships": relationships,
    }


def relation(one: str, kind: str, other: str) -> Dict[str, str]:
    return {"spdxElementId": one, "relationshipType": kind, "relatedSpdxElement": other}


def date_of_creation() -> str:
    epoch = datetime.datetime(1980, 1, 1, tzinfo=datetime.timezone.utc)
    if os.environ.get("SOURCE_DATE_EPOCH"):
        epoch = datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), tz=datetime.timezone.utc)
    return epoch.strftime("%Y-%m-%dT%H:%M:%SZ")


def notices(version: str, binaries: List[pathlib.Path]) -> Dict[str, str]:
    """Both files, by their names."""
    first = {shown_name(binary): binary for binary in reversed(binaries)}
    binaries = [binary for binary in binaries if first[shown_name(binary)] == binary]
    document = json.dumps(bill_of_materials(version, binaries), indent=1, ensure_ascii=False) + "\n"
    return {"THIRD-PARTY.txt": third_party_text(binaries), "facebaker.spdx.json": document}


def main(arguments: List[str]) -> int:
    if len(arguments) < 3:
        print("usage: notices.py OUT_DIR VERSION BINARY...", file=sys.stderr)
        return 2
    folder = pathlib.Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in notices(arguments[1], [pathlib.Path(one) for one in arguments[2:]]).items():
        partial = folder / (name + ".partial")
        partial.write_text(text, encoding="utf-8")
        partial.replace(folder / name)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
