"""What build_dist.py packs: the runtime for each platform, and everything for this one, as CMake builds and installs them.
Standard library only."""

from __future__ import annotations

import os
import pathlib
import platform
import shutil
import subprocess
import sys
from typing import Dict, List, NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "build" / "dist-work"  # what is installed, and what is being packed


class Platform(NamedTuple):
    """A platform that the runtime is built for."""

    preset: str
    target: str  # of capi/platforms/build_dependencies.sh; "" where the system's packages have what is linked
    library: str  # what packages for engines carry, in what is installed
    built_on: str  # sys.platform
    tools: Dict[str, str]  # programs and files, and the Debian packages that have them


ENGINES = "lib/engines/libfacebaker.so"
MINGW = {"x86_64-w64-mingw32-g++-posix": "g++-mingw-w64-x86-64-posix", "llvm-dlltool": "llvm"}
NDK = {os.environ.get("ANDROID_NDK_HOME") or "the folder of $ANDROID_NDK_HOME": "Android's NDK, and say where it is by ANDROID_NDK_HOME"}
PLATFORMS: Dict[str, Platform] = {
    "linux-x64": Platform("runtime-only", "", ENGINES, "linux", {}),
    "linux-arm64": Platform("aarch64", "aarch64", ENGINES, "linux", {"aarch64-linux-gnu-g++": "g++-aarch64-linux-gnu"}),
    "windows-x64": Platform("windows-x64", "windows-x64", "bin/facebaker.dll", "linux", MINGW),
    "macos": Platform("macos", "", "lib/engines/libfacebaker.dylib", "darwin", {}),
    "windows-x64-msvc": Platform("windows-clang-cl", "", "bin/facebaker.dll", "win32", {}),
    "android-arm64": Platform("android-arm64", "android-arm64", "lib/libfacebaker.so", "linux", NDK),
    "android-x64": Platform("android-x64", "android-x64", "lib/libfacebaker.so", "linux", NDK),
}
ELSEWHERE = ["ios"]  # whose library Xcode makes (.github/workflows/packages.yml), and packages carry
# By default, those of which this system has packages.
USUAL = {"linux": ["linux-x64", "linux-arm64", "windows-x64"], "darwin": ["macos"], "win32": ["windows-x64-msvc"]}


def run(*words: "str | pathlib.Path", cwd: pathlib.Path = ROOT) -> None:
    """Raises subprocess.CalledProcessError; what the command says goes into this program's log (standard output)."""
    print("+", " ".join(str(word) for word in words), flush=True)
    subprocess.run([str(word) for word in words], cwd=cwd, check=True)


def build_and_install(folder: pathlib.Path, prefix: pathlib.Path, *configure: "str | pathlib.Path") -> None:
    options = os.environ.get("FB_CMAKE_OPTIONS", "").split()
    run("cmake", *configure, "-B", folder, "-D", "CMAKE_INSTALL_LIBDIR=lib", "-D", "FB_TESTS=OFF", *options)
    run("cmake", "--build", folder, "--parallel", str(os.cpu_count() or 1))
    shutil.rmtree(prefix, ignore_errors=True)
    run("cmake", "--install", folder, "--prefix", prefix, "--strip")


def build_runtime(name: str) -> pathlib.Path:
    """The runtime of a platform, installed and stripped: the folder, in which PLATFORMS[name].library is the library that packages
    for engines carry. Without OpenMP: engines have threads of their own, and not every system has its library."""
    made = PLATFORMS[name]
    if made.target:
        run(ROOT / "capi" / "platforms" / "build_dependencies.sh", made.target)
    if name == "macos":
        return join_processors(name, [build_kind(f"{name}-{one}", made, "-D", f"CMAKE_OSX_ARCHITECTURES={one}") for one in ("arm64", "x86_64")])
    prefix = build_kind(name, made)
    if name == "windows-x64":  # what other compilers link, by the names alone
        run("llvm-dlltool", "-m", "i386:x86-64", "-d", ROOT / "build" / f"dist-{name}" / "capi" / "facebaker.def",
            "-D", "facebaker.dll", "-l", prefix / "lib" / "facebaker.lib")
    return prefix


def build_kind(name: str, made: Platform, *configure: str) -> pathlib.Path:
    """One build of a platform's runtime, installed and stripped."""
    folder, prefix = ROOT / "build" / f"dist-{name}", WORK / name
    build_and_install(folder, prefix, "--preset", made.preset, "-D", "FB_OPENMP=OFF", "-D", "FB_SAMPLES=OFF", *configure)
    library = prefix / made.library
    if library.parent.name == "engines":
        library.parent.mkdir()
        shutil.copyfile(folder / made.library, library)
        run(strip_of(folder), *(["-x"] if library.suffix == ".dylib" else []), library)
    return prefix


def join_processors(name: str, prefixes: List[pathlib.Path]) -> pathlib.Path:
    """What was installed for several processors of macOS, with libraries for all of them."""
    joined = WORK / name
    shutil.rmtree(joined, ignore_errors=True)
    shutil.copytree(prefixes[0], joined, symlinks=True)
    for library in joined.rglob("*.dylib"):
        if not library.is_symlink():
            place = library.relative_to(joined)
            run("lipo", "-create", *[prefix / place for prefix in prefixes], "-output", library)
    return joined


def strip_of(folder: pathlib.Path) -> str:
    """The program by which CMake strips what it installs."""
    for line in (folder / "CMakeCache.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("CMAKE_STRIP:"):
            return line.partition("=")[2]
    return "strip"


def build_everything(viewer: bool) -> pathlib.Path:
    """All that is for this machine, as it works in any folder: libraries and tool, which has zlib and what decodes pictures in it.
    The page of the viewer is installed with it where it is wanted; where it is not built yet, samples/viewer/build.sh builds it."""
    page = ROOT / "build" / "viewer"  # where packager/server looks for it
    if viewer and not (page / "index.html").is_file():
        run(ROOT / "samples" / "viewer" / "build.sh", page)
    archives = pathlib.Path("/usr/lib") / f"{platform.machine()}-linux-gnu"
    prefix = WORK / "everything"
    build_and_install(
        ROOT / "build" / "dist-everything", prefix, "-S", ROOT, "-G", "Ninja", "-D", "CMAKE_BUILD_TYPE=Release", "-D", "FB_MPI=OFF",
        "-D", "FB_ZSH_DIR=share/zsh/site-functions", "-D", f"ZLIB_LIBRARY_RELEASE={archives / 'libz.a'}",
        "-D", f"PNG_LIBRARY_RELEASE={archives / 'libpng.a'}", "-D", f"TURBOJPEG_LIBRARY={archives / 'libturbojpeg.a'}",
        "-D", f"WEBP_LIBRARY={archives / 'libwebp.a'}")
    if not viewer:
        shutil.rmtree(prefix / "share" / "facebaker" / "viewer", ignore_errors=True)
    return prefix


def missing_tools(names: List[str]) -> List[str]:
    """Sentences about what is not there for these platforms."""
    problems = []
    for name in names:
        made = PLATFORMS[name]
        if made.built_on != sys.platform:
            problems.append(f"{name} is built on {made.built_on}, and this is {sys.platform}: leave it out of --platforms")
            continue
        problems += [f"{name} needs {tool}: install {package}" for tool, package in made.tools.items() if not is_there(tool)]
    return problems


def is_there(tool: str) -> bool:
    """Whether a program is in PATH, or a file or folder is where its path says."""
    return pathlib.Path(tool).exists() if "/" in tool else shutil.which(tool) is not None
