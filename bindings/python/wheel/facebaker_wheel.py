"""The build backend of the package (PEP 517): makes a wheel that carries libfacebaker and libfacebaker_bake.

The libraries are those of the folder that `--config-settings libraries=FOLDER` or the environment variable
FACEBAKER_LIBRARIES names, else those of build/release/lib if they are there, else CMake builds them in build/wheel.
With `--config-settings platform=NAME` as well, the wheel is for another platform (PLATFORMS) and carries libfacebaker alone:
it poses, and does not bake.
Standard library only; Python 3.11 or newer builds, any that pyproject.toml allows uses the wheel."""

import base64
import ctypes
import hashlib
import importlib.util
import os
import pathlib
import re
import subprocess
import sysconfig
import tomllib
import zipfile

HERE = pathlib.Path(__file__).resolve().parents[1]
ROOT = HERE.parents[1]
LIBRARIES = ("facebaker", "facebaker_bake")
# What every system that the platform tag stands for has; the wheel carries all else.
OF_THE_SYSTEM = re.compile(r"linux-vdso|ld-linux|lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+)\.so")
# Other platforms: how the library is called there, and the tag of the wheel.
PLATFORMS = {
    "linux-arm64": ("libfacebaker.so", "manylinux_2_{}_aarch64"),
    "windows-x64": ("facebaker.dll", "win_amd64"),
    "macos": ("libfacebaker.dylib", "macosx_11_0_universal2"),
}
DATE = (1980, 1, 1, 0, 0, 0)  # of all files, so that the same tree gives the same bytes


class UnsupportedOperation(Exception):
    """What there is no hook for."""


def get_requires_for_build_wheel(config_settings=None):
    return []


def build_sdist(sdist_directory, config_settings=None):
    raise UnsupportedOperation("the package is built from a clone: its libraries are those of the whole tree")


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    folder = pathlib.Path(metadata_directory, f"facebaker-{version()}.dist-info")
    folder.mkdir()
    (folder / "METADATA").write_text(metadata(), encoding="utf-8")
    return folder.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Writes the wheel into a folder and gives its name."""
    files = {f"facebaker/{path.name}": path.read_bytes() for path in sorted((HERE / "facebaker").glob("*.py"))}
    files["facebaker/py.typed"] = b""
    information = f"facebaker-{version()}.dist-info"
    settings = config_settings or {}
    binaries, notices = foreign_library(settings) if settings.get("platform") else shared_libraries(settings)
    files.update({f"facebaker/{name}": data for name, data in binaries.items()})
    tag = f"py3-none-{platform_tag(binaries.values(), settings.get('platform'))}"
    files[f"{information}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files.update({f"{information}/{name}": text for name, text in notices.items()})
    files[f"{information}/METADATA"] = metadata().encode()
    files[
        f"{information}/WHEEL"
    ] = f"Wheel-Version: 1.0\nGenerator: facebaker_wheel\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[f"{information}/RECORD"] = record_of(files, information).encode()
    name = f"facebaker-{version()}-{tag}.whl"
    whole = pathlib.Path(wheel_directory, name)
    partial = whole.with_suffix(".partial")
    with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, DATE)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
    partial.replace(whole)
    return name


def version():
    return (ROOT / "VERSION").read_text().strip()


def metadata():
    project = tomllib.loads((HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = [
        "Metadata-Version: 2.1",
        f"Name: {project['name']}",
        f"Version: {version()}",
        f"Summary: {project['description']}",
        f"License: {project['license']['text']}",
        "License-File: LICENSE",
        f"Requires-Python: {project['requires-python']}",
        *(f"Classifier: {classifier}" for classifier in project["classifiers"]),
        *(f"Requires-Dist: {dependency}" for dependency in project["dependencies"]),
    ]
    for extra, dependencies in project["optional-dependencies"].items():
        lines.append(f"Provides-Extra: {extra}")
        lines += [f'Requires-Dist: {dependency} ; extra == "{extra}"' for dependency in dependencies]
    lines.append("Description-Content-Type: text/markdown")
    return "\n".join(lines) + "\n\n" + (HERE / project["readme"]).read_text(encoding="utf-8")


def record_of(files, information):
    """The list of all files with their hashes, but for its own."""
    lines = []
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        lines.append(f"{path},sha256={digest},{len(data)}\n")
    return "".join(lines) + f"{information}/RECORD,,\n"


def shared_libraries(settings):
    """The libraries and those they need that not every system has, by their names in the package; and the notices of the
    latter and of what is linked into the former."""
    folder = library_folder(settings)
    files, notices = {}, {}
    for name in LIBRARIES:
        path = folder / f"lib{name}.so"
        files[path.name] = path.read_bytes()
        for needed in needed_libraries(path):
            files[f"carried/{needed.name}"] = needed.read_bytes()
            notices.update(notices_of(needed))
    notices.update(notices_of_linked([folder / f"lib{name}.so" for name in LIBRARIES]))
    built = ctypes.CDLL(str(folder / "libfacebaker.so"))
    built.fb_version_string.restype = ctypes.c_char_p
    if built.fb_version_string().decode() != version():
        raise SystemExit(f"{folder}: libraries of version {built.fb_version_string().decode()}, not {version()}")
    return files, notices


def foreign_library(settings):
    """The library of another platform, by its name in the package, and the notices of what is linked into it."""
    platform = settings["platform"]
    if platform not in PLATFORMS:
        raise SystemExit(f"platform is one of {', '.join(PLATFORMS)}, and not {platform}")
    path = pathlib.Path(settings.get("libraries") or ".", PLATFORMS[platform][0])
    if not path.is_file():
        raise SystemExit(f"there is no {path}")
    data = path.read_bytes()
    if version().encode() + b"\0" not in data:
        raise SystemExit(f"{path}: is not of version {version()}")
    return {path.name: data}, notices_of_linked([path])


def library_folder(settings):
    named = settings.get("libraries") or os.environ.get("FACEBAKER_LIBRARIES")
    folder = pathlib.Path(named) if named else ROOT / "build" / "release" / "lib"
    missing = [name for name in LIBRARIES if not (folder / f"lib{name}.so").exists()]
    if missing and named:
        raise SystemExit(f"{folder}: there is no lib{missing[0]}.so")
    return build_libraries(ROOT / "build" / "wheel") if missing else folder


def build_libraries(build):
    """Has CMake build them; see CONTRIBUTING.md for what it needs."""
    subprocess.run(["cmake", "-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DFB_TESTS=OFF"], check=True)
    targets = [f"lib{name}" for name in LIBRARIES]
    subprocess.run(["cmake", "--build", build, "--parallel", str(os.cpu_count() or 1), "--target", *targets], check=True)
    return build / "lib"


def needed_libraries(path):
    listed = subprocess.run(["ldd", path], check=True, capture_output=True, text=True).stdout
    missing = re.findall(r"(\S+) => not found", listed)
    if missing:
        raise SystemExit(f"{path}: needs {missing[0]}, which is not on this machine")
    found = re.findall(r"(\S+) => (\S+) \(", listed)
    return [pathlib.Path(place) for name, place in found if not OF_THE_SYSTEM.match(name)]


def notices_of(path):
    """The copyright file of the Debian package that a library is of; none elsewhere."""
    try:
        owner = subprocess.run(["dpkg-query", "-S", path.resolve()], capture_output=True, text=True).stdout.split(":")[
            0
        ]
    except OSError:
        return {}
    notice = pathlib.Path("/usr/share/doc", owner, "copyright")
    return {f"licenses/{owner}.txt": notice.read_bytes()} if owner and notice.is_file() else {}


def notices_of_linked(libraries):
    """What is linked into the libraries: licences for people, and a bill of materials where PEP 770 has it."""
    place = importlib.util.spec_from_file_location("notices", ROOT / "packager" / "packages" / "notices.py")
    notices = importlib.util.module_from_spec(place)
    place.loader.exec_module(notices)
    texts = notices.notices(version(), libraries)
    folders = {"THIRD-PARTY.txt": "licenses", "facebaker.spdx.json": "sboms"}
    return {f"{folders[name]}/{name}": text.encode() for name, text in texts.items()}


def platform_tag(binaries, platform=None):
    """manylinux with the version of glibc that the libraries need: pip refuses the wheel on older systems."""
    machine = sysconfig.get_platform().rpartition("-")[2]
    used = [int(minor) for data in binaries for minor in re.findall(rb"GLIBC_2\.(\d+)\0", data)]
    if platform:
        return PLATFORMS[platform][1].format(max(used, default=17))  # AArch64 has been in glibc since 2.17
    return f"manylinux_2_{max(used)}_{machine}" if used else f"linux_{machine}"
