"""Where FaceBaker's tool, package and library are, and the command line that bakes a scene. Without Blender."""

from __future__ import annotations

import importlib.util
import os
import pathlib
import shlex
import shutil
import sys
from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence

from .bake_settings import BakeOptions, Path
from .channels import SettingsError

HERE = pathlib.Path(__file__).resolve().parent
_TREE = HERE.parents[2]  # of FaceBaker's own source, if the add-on lies in it


def add_package_path(chosen: str = "") -> None:
    """Makes `import facebaker` work in this interpreter. It is looked for in `chosen`, a folder that holds the package; in
    FACEBAKER_PYTHON of the environment; beside this add-on, where its zip has it; among installed packages; and in
    FaceBaker's source. Raises SettingsError if there is none."""
    places = [chosen, os.environ.get("FACEBAKER_PYTHON", ""), str(HERE / "carried")]
    if "facebaker" not in sys.modules and not any(_offer(place) for place in places if place):
        if importlib.util.find_spec("facebaker") is None and not _offer(str(_TREE / "bindings" / "python")):
            raise SettingsError(
                "the Python package facebaker was not found; name the folder that holds it in the add-on's preferences "
                "or in FACEBAKER_PYTHON"
            )
    _offer_libraries()


def _offer(folder: str) -> bool:
    if not (pathlib.Path(folder) / "facebaker" / "__init__.py").is_file():
        return False
    if folder not in sys.path:
        sys.path.insert(0, folder)
    return True


def _offer_libraries() -> None:
    """Where the environment names no library and the package carries none: that of the program which the environment
    names, of a build of the tree, or of the program in PATH."""
    if os.environ.get("FACEBAKER_LIBRARY") or (HERE / "carried").is_dir():
        return
    found = (
        library_of(os.environ.get("FACEBAKER_TOOL")) or _built("lib/libfacebaker.so")
        or library_of(shutil.which("facebaker"))
    )  # fmt: skip
    if found:
        os.environ["FACEBAKER_LIBRARY"] = str(found)


def library_of(tool: Optional[str]) -> Optional[pathlib.Path]:
    """The library that was built or installed with a program: in lib beside its bin, or in a folder of lib for a kind of
    processor."""
    if not tool:
        return None
    folder = pathlib.Path(tool).resolve().parent.parent / "lib"
    libraries = sorted([*folder.glob("libfacebaker.so*"), *folder.glob("*/libfacebaker.so*")])
    return libraries[0] if libraries else None


def _built(path: str) -> Optional[pathlib.Path]:
    built = _TREE / "build" / "release" / path
    return built if built.is_file() else None


def find_tool(chosen: str = "") -> str:
    """The program facebaker: `chosen`, FACEBAKER_TOOL of the environment, the one beside this add-on, in PATH, or in the
    build of FaceBaker's source. Raises SettingsError if there is none, or a named one is not there."""
    for named in chosen, os.environ.get("FACEBAKER_TOOL", ""):
        if named:
            if not os.access(named, os.X_OK):
                raise SettingsError(f"{named}: is no program")
            return os.path.abspath(named)
    found = _carried_tool() or shutil.which("facebaker") or _built("bin/facebaker")
    if not found:
        raise SettingsError(
            "the program facebaker was not found; name it in the add-on's preferences or in FACEBAKER_TOOL"
        )
    return str(found)


def _carried_tool() -> Optional[str]:
    """The program in the add-on's zip. Blender unpacks that, and the viewer's, without the permission to run them."""
    carried = HERE / "carried" / "bin" / "facebaker"
    if not carried.is_file():
        return None
    for program in carried.parent.iterdir():
        if not os.access(program, os.X_OK):
            program.chmod(program.stat().st_mode | 0o111)
    return str(carried)


def tool_environment(tool: str) -> Dict[str, str]:
    """The environment in which the program runs: one that lies in the add-on's zip finds its libraries beside it."""
    environment = dict(os.environ)
    libraries = pathlib.Path(tool).parents[1] / "lib"
    if pathlib.Path(tool).parent.parent == HERE / "carried":
        paths = [str(libraries), *filter(None, [environment.get("LD_LIBRARY_PATH")])]
        environment["LD_LIBRARY_PATH"] = os.pathsep.join(paths)
    return environment


@dataclass(frozen=True)
class BlenderCommand:
    """How to start this Blender again without its window. options: of Blender, before the file."""

    program: str
    options: Sequence[str] = ()

    def words(self, blend: Path, script: Path, arguments: Sequence[str]) -> List[str]:
        scene = os.path.abspath(os.fspath(blend))
        # One thread: several such processes share the machine, and a face's dependency graph is no faster with more.
        start = [self.program, "--background", "--threads", "1", *self.options, scene]
        return [*start, "--python-exit-code", "1", "--python", os.fspath(script), "--", *arguments]


def source_text(blender: BlenderCommand, blend: Path, settings: Path) -> str:
    """The SOURCE of the tool that is a scene and a settings file."""
    words = blender.words(blend, HERE / "rig_child.py", [os.path.abspath(os.fspath(settings))])
    return "exec:" + shlex.join(words)


def bake_words(tool: str, source: str, out: Path, work: Path, options: BakeOptions) -> List[str]:
    """The command line of a bake."""
    words = [tool, "bake", source, "--out", os.path.abspath(os.fspath(out)), "--work", os.path.abspath(os.fspath(work))]
    words += ["--recipe", options.recipe, "--use", options.use, "--seed", str(options.seed)]
    for option, number in (
        ("--rig-budget", options.rig_budget),
        ("--poses", options.poses),
        ("--workers", options.workers),
        ("--epochs", options.epochs),
        ("--threads", options.threads),
    ):
        if number:
            words += [option, str(number)]
    if options.reuse:
        words += ["--reuse", os.path.abspath(options.reuse)]
    return [*words, *options.extra]
