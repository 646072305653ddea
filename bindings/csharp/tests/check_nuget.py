"""Checks a packed NuGet package: check_nuget.py PACKAGE PLATFORM... Its parts are those that the format demands, what points
at a part points at one that is there, and it has the libraries of exactly these platforms (pack_nuget.py's names)."""

import json
import pathlib
import re
import sys
import zipfile
from xml.etree import ElementTree

ROOT = pathlib.Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "bindings" / "csharp"))
import pack_nuget  # noqa: E402

ALWAYS = {"FaceBaker.nuspec", "README.md", "LICENSE.txt", "THIRD-PARTY.txt", "facebaker.spdx.json", "_rels/.rels",
          "[Content_Types].xml", "lib/netstandard2.1/FaceBaker.dll", "lib/netstandard2.1/FaceBaker.xml"}
# The first bytes of a shared library: ELF, PE, Mach-O of one processor and of several.
MAGIC = {".so": (b"\x7fELF",), ".dll": (b"MZ",), ".dylib": (b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe")}


def named(element, name):
    """The children of a name, in whatever namespace."""
    return [one for one in element.iter() if one.tag.rpartition("}")[2] == name]


def part_problems(parts, platforms):
    properties = [path for path in parts if re.fullmatch(r"package/services/metadata/core-properties/[0-9a-f]{32}\.psmdcp", path)]
    natives = {f"runtimes/{pack_nuget.PLATFORMS[one].rid}/native/{pack_nuget.PLATFORMS[one].file}" for one in platforms}
    problems = [] if len(properties) == 1 else [f"{len(properties)} parts of core properties"]
    expected = ALWAYS | natives | set(properties)
    problems += [f"there is no {path}" for path in sorted(expected - set(parts))]
    problems += [f"there is {path}" for path in sorted(set(parts) - expected)]
    for path in natives & set(parts):
        if not parts[path].startswith(MAGIC[pathlib.PurePosixPath(path).suffix]):
            problems.append(f"{path} is no library of its platform")
    return problems


def reference_problems(parts):
    """Of what the format's own parts say of the others."""
    problems = []
    targets = [one.get("Target") for one in named(ElementTree.fromstring(parts["_rels/.rels"]), "Relationship")]
    problems += [f"_rels/.rels points at {one}" for one in targets if one.lstrip("/") not in parts]
    if not any(one == "/FaceBaker.nuspec" for one in targets):
        problems.append("_rels/.rels does not point at the manifest")
    types = ElementTree.fromstring(parts["[Content_Types].xml"])
    extensions = {one.get("Extension") for one in named(types, "Default")}
    overridden = {one.get("PartName") for one in named(types, "Override")}
    for path in set(parts) - {"[Content_Types].xml"}:
        name = path.rpartition("/")[2]
        if name.rpartition(".")[2] not in extensions and f"/{path}" not in overridden:
            problems.append(f"{path} has no content type")
    return problems


def manifest_problems(parts):
    manifest = ElementTree.fromstring(parts["FaceBaker.nuspec"])
    fields = {name: named(manifest, name)[0].text for name in ("id", "version", "license", "readme", "description", "authors")}
    version = (ROOT / "VERSION").read_text(encoding="utf-8").strip()
    wanted = {"id": "FaceBaker", "version": version, "license": "Apache-2.0", "readme": "README.md"}
    problems = [f"FaceBaker.nuspec: {name} is {fields[name]}" for name, text in wanted.items() if fields[name] != text]
    bill = json.loads(parts["facebaker.spdx.json"])
    if "xxHash" not in {package["name"] for package in bill["packages"]} and any(path.startswith("runtimes/") for path in parts):
        problems.append("facebaker.spdx.json does not name xxHash")
    return problems


def problems_of(package, platforms):
    with zipfile.ZipFile(package) as archive:
        if archive.testzip():
            return [f"{archive.testzip()} is damaged"]
        parts = {name: archive.read(name) for name in archive.namelist()}
    problems = part_problems(parts, platforms)
    return problems or reference_problems(parts) + manifest_problems(parts)


def main():
    problems = problems_of(sys.argv[1], sys.argv[2:])
    print("\n".join(problems) or f"{sys.argv[1]}: the parts are as they should be, for {', '.join(sys.argv[2:])}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
