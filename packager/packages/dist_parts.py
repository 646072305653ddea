"""The parts of what build_dist.py makes: each function writes its files into a folder. Standard library only."""

from __future__ import annotations

import gzip
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile
from typing import Any, Callable, Dict, List, NamedTuple, Tuple

from dist_builds import WORK, PLATFORMS, ROOT, build_everything, build_runtime, run

for folder in ("bindings/engine", "bindings/csharp", "bindings/unreal", "bindings/blender", "bindings/python/wheel"):
    sys.path.insert(0, str(ROOT / folder))
import engine_package  # noqa: E402
import pack_nuget  # noqa: E402
import pack_plugin  # noqa: E402
import pack_unity  # noqa: E402
from package_archives import Member, Members, read_members, tar_bytes, zip_bytes  # noqa: E402

PYTHON = "/usr/bin/python3" if pathlib.Path("/usr/bin/python3").exists() else sys.executable
VERSION = engine_package.version()
UNREAL = {"linux-x64": "Linux", "linux-arm64": "LinuxArm64", "macos": "Mac", "windows-x64": "Win64", "windows-x64-msvc": "Win64"}
GODOT_HEADERS = {"3": ROOT / "build" / "gdnative", "4": ROOT / "build" / "gdextension"}


class Work:
    """What parts are made of: each build is made once, when the first part asks for it."""

    def __init__(self, platforms: List[str], given: engine_package.Libraries, viewer: bool) -> None:
        self.platforms, self.given, self.viewer = platforms, given, viewer
        self._prefixes: Dict[str, pathlib.Path] = {}

    def runtime(self, name: str) -> pathlib.Path:
        if name not in self._prefixes:
            self._prefixes[name] = build_runtime(name)
        return self._prefixes[name]

    def everything(self) -> pathlib.Path:
        if "everything" not in self._prefixes:
            self._prefixes["everything"] = build_everything(self.viewer)
        return self._prefixes["everything"]

    def libraries(self, known: Any) -> engine_package.Libraries:
        """The libraries that packages for engines carry, of those platforms that the package knows; those that were given come
        before those that are built here."""
        given = dict(self.given)
        names = [name for name in known if name in given or name in self.platforms]
        return [(name, given.get(name) or self.runtime(name) / PLATFORMS[name].library) for name in names]


def source(work: Work, out: pathlib.Path) -> None:
    name = f"facebaker-{VERSION}"
    tar = subprocess.run(["git", "archive", "--format=tar", f"--prefix={name}/", "HEAD"], cwd=ROOT, check=True, capture_output=True)
    (out / f"{name}-source.tar.gz").write_bytes(gzip.compress(tar.stdout, compresslevel=9, mtime=0))


def vcpkg(work: Work, out: pathlib.Path) -> None:
    """A port, with the source beside it."""
    source(work, WORK)
    archive = WORK / f"facebaker-{VERSION}-source.tar.gz"
    port = ROOT / "packager" / "packages" / "vcpkg"
    members = {f"facebaker/{path.name}": Member(path.read_bytes()) for path in (port / "portfile.cmake", port / "usage", archive)}
    manifest = (port / "vcpkg.json.in").read_text(encoding="utf-8").replace("@VERSION@", VERSION)
    members["facebaker/vcpkg.json"] = Member(manifest.encode())
    (out / f"facebaker_vcpkg-{VERSION}.zip").write_bytes(zip_bytes(members))


def linux(work: Work, out: pathlib.Path) -> None:
    name = f"facebaker-{VERSION}-Linux-{platform.machine()}"
    (out / f"{name}.tar.gz").write_bytes(tar_bytes(read_members(work.everything(), name + "/")))


def debs(work: Work, out: pathlib.Path) -> None:
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        run(ROOT / "packager" / "packages" / "build_debs.sh", *([] if work.viewer else ["--without-viewer"]), folder)
        for package in pathlib.Path(folder).glob("*.deb"):
            shutil.copy(package, out)


def runtime(work: Work, out: pathlib.Path) -> None:
    """For each platform headers, libraries, and what CMake and pkg-config find them by."""
    for name in work.platforms:
        prefix = work.runtime(name)
        folder = f"facebaker-runtime-{VERSION}-{name.replace('-msvc', '')}"
        members = {f"{folder}/{path}": member for path, member in read_members(prefix).items()}
        texts = engine_package.notices([prefix / PLATFORMS[name].library])
        texts["LICENSE"] = (ROOT / "LICENSE").read_text(encoding="utf-8")
        members.update({f"{folder}/share/doc/facebaker/{file}": Member(text.encode()) for file, text in texts.items()})
        windows = name.startswith("windows")
        (out / f"{folder}{'.zip' if windows else '.tar.gz'}").write_bytes(zip_bytes(members) if windows else tar_bytes(members))


def wheels(work: Work, out: pathlib.Path) -> None:
    """For this machine one that bakes and poses, for other platforms one that poses."""
    import facebaker_wheel  # which needs Python 3.11

    if sys.platform == "linux":
        facebaker_wheel.build_wheel(str(out), {"libraries": str(work.everything() / "lib")})
    for name, library in work.libraries([*facebaker_wheel.PLATFORMS, "windows-x64-msvc"]):
        facebaker_wheel.build_wheel(str(out), {"libraries": str(library.parent), "platform": name.replace("-msvc", "")})


def npm(work: Work, out: pathlib.Path) -> None:
    run(ROOT / "bindings" / "web" / "build.sh")
    package = ROOT / "build" / "web"
    bill = engine_package.notices(sorted((package / "dist").glob("*.wasm")))["facebaker.spdx.json"]
    (package / "facebaker.spdx.json").write_text(bill, encoding="utf-8")
    run("npm", "pack", "--silent", "--pack-destination", out, package)


def nupkg(work: Work, out: pathlib.Path) -> None:
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        run(ROOT / "bindings" / "csharp" / "build_assembly.sh", folder)
        members = pack_nuget.package_members(pathlib.Path(folder), work.libraries(pack_nuget.PLATFORMS))
    (out / f"{pack_nuget.ID}.{VERSION}.nupkg").write_bytes(zip_bytes(members))


def packed_folder(pack: Callable[[pathlib.Path, engine_package.Libraries], None], libraries: engine_package.Libraries,
                  prefix: str) -> Members:
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        pack(pathlib.Path(folder), libraries)
        return read_members(pathlib.Path(folder), prefix)


def unity(work: Work, out: pathlib.Path) -> None:
    members = packed_folder(pack_unity.pack, work.libraries(pack_unity.PLATFORMS), "package/")
    (out / f"{pack_unity.PACKAGE}-{VERSION}.tgz").write_bytes(tar_bytes(members))


def unreal(work: Work, out: pathlib.Path) -> None:
    libraries = []
    for name, library in work.libraries(UNREAL):
        libraries.append((UNREAL[name], library))
        if library.suffix == ".dll":  # which is linked by its import library
            libraries.append((UNREAL[name], library.parents[1] / "lib" / "facebaker.lib"))
    (out / f"facebaker_unreal-{VERSION}.zip").write_bytes(zip_bytes(packed_folder(pack_plugin.pack, libraries, "FaceBaker/")))


def godot(version: str, work: Work, out: pathlib.Path) -> None:
    headers = GODOT_HEADERS[version]
    if not headers.exists() and version == "3":
        run(ROOT / "bindings" / "godot" / "get_headers.sh", headers)
    libraries = dict(work.libraries(["linux-x64", "linux-arm64", "windows-x64"]))
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        addon = pathlib.Path(folder, "addon")
        others = [word for name in ("linux-arm64", "windows-x64") if name in libraries
                  for word in (f"--{name}", str(libraries[name].parent))]
        run(ROOT / "bindings" / "godot" / "build_addon.sh", "--godot", version, "--headers", headers,
            "--libraries", libraries["linux-x64"].parent, *others, "--out", addon)
        (out / f"facebaker_godot{version}-{VERSION}.zip").write_bytes(zip_bytes(read_members(addon, "addons/facebaker/")))


def godot3(work: Work, out: pathlib.Path) -> None:
    godot("3", work, out)


def godot4(work: Work, out: pathlib.Path) -> None:
    godot("4", work, out)


def blender(work: Work, out: pathlib.Path) -> None:
    name = f"facebaker_blender-{VERSION}-Linux-{platform.machine()}.zip"
    run(PYTHON, "-B", ROOT / "bindings" / "blender" / "make_addon.py", work.everything(), out / name)


class Part(NamedTuple):
    """What makes a part, what it needs besides the builds (programs or files, and where they come from), and whether it
    needs Linux."""

    make: Callable[[Work, pathlib.Path], None]
    tools: Tuple[Tuple[str, str], ...] = ()
    linux: bool = True


MONO = (("mcs", "install mono-mcs"), ("mono", "install mono-runtime"),
        ("/usr/lib/mono/gac/Mono.Cecil", "install libmono-cecil-private-cil"))
GODOT4 = (str(GODOT_HEADERS["4"] / "gdextension_interface.h"), "`godot --dump-gdextension-interface` of Godot 4 writes it")
PARTS: Dict[str, Part] = {
    "source": Part(source, (("git", "install git"),)),
    "vcpkg": Part(vcpkg, (("git", "install git"),)),
    "linux": Part(linux),
    "debs": Part(debs),
    "runtime": Part(runtime, linux=False),
    "wheels": Part(wheels, linux=False),
    "npm": Part(npm, (("npm", "install nodejs and npm"),)),
    "nupkg": Part(nupkg, MONO),
    "unity": Part(unity),
    "unreal": Part(unreal),
    "godot3": Part(godot3),
    "godot4": Part(godot4, (GODOT4,)),
    "blender": Part(blender),
}
