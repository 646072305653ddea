"""What a bake of a scene needs on the disk: a copy of the scene and the settings, in a folder beside the archive."""

from __future__ import annotations

import hashlib
import json
import pathlib
import sys
from typing import Any, Dict, List

import bpy

from .bake_process import BakeProcess
from .bake_settings import BakeSettings, Path, save_settings
from .channels import SettingsError
from .tool_command import BlenderCommand, bake_words, source_text, tool_environment


class BakeJob:
    """The bake of one archive. Its folder is NAME.blender beside the archive NAME.fbk."""

    def __init__(self, archive: Path) -> None:
        self.archive = pathlib.Path(archive).resolve()
        if self.archive.suffix != ".fbk":
            raise SettingsError(f"{self.archive}: an archive's name ends in .fbk")
        self.folder = self.archive.with_suffix(".blender")
        self.scene, self.settings = self.folder / "scene.blend", self.folder / "settings.json"
        self.work = self.folder / "work"
        self.process = BakeProcess(self.folder)

    def prepare(self, settings: BakeSettings) -> None:
        """Saves a copy of the open file, and the settings. The copy of an earlier bake is used again if the file on disk is
        as it was then and has no changes that are not saved: so the same command goes on with an interrupted bake.
        Raises OSError, SettingsError."""
        if self.process.running:
            raise SettingsError(f"a bake of {self.archive.name} is running")
        self.folder.mkdir(parents=True, exist_ok=True)
        stamp, stamp_file = _file_stamp(), self.folder / "settings.version"
        if not (stamp and self.scene.is_file() and _text(stamp_file) == stamp):
            stamp_file.unlink(missing_ok=True)
            bpy.ops.wm.save_as_mainfile(filepath=str(self.scene), copy=True, relative_remap=True, check_existing=False)
            stamp_file.write_text(stamp or hashlib.sha256(self.scene.read_bytes()).hexdigest()[:16])
        save_settings(settings, self.settings)

    def words(self, settings: BakeSettings, tool: str) -> List[str]:
        """The command line of the bake."""
        source = source_text(this_blender(), self.scene, self.settings)
        return [*bake_words(tool, source, self.archive, self.work, settings.bake), "--json"]

    def start(self, settings: BakeSettings, tool: str) -> None:
        """Prepares and starts the bake in the background."""
        self.prepare(settings)
        self.process.start(self.words(settings, tool), tool_environment(tool))

    def go_on(self) -> None:
        """Goes on with a bake that was interrupted, from the copy of the scene that it had. Raises SettingsError."""
        if not self.process.unfinished:
            raise SettingsError(f"there is no bake of {self.archive.name} to go on with")
        words = self.process.command
        self.process.start(words, tool_environment(words[0]))


def _text(path: pathlib.Path) -> str:
    return path.read_text().strip() if path.is_file() else ""


def _file_stamp() -> str:
    """A digest of the open file as it lies on disk, and of the files it links; "" if it has changes that are not saved."""
    if bpy.data.is_dirty or not bpy.data.filepath:
        return ""
    digest = hashlib.sha256(bpy.app.version_string.encode())
    for path in [bpy.data.filepath, *(bpy.path.abspath(library.filepath) for library in bpy.data.libraries)]:
        if not pathlib.Path(path).is_file():
            return ""
        digest.update(pathlib.Path(path).read_bytes())
    return digest.hexdigest()[:16]


def this_blender() -> BlenderCommand:
    """How to start this Blender again. Python in files may run there if it may here: drivers and rigs can need it."""
    words = sys.argv[: sys.argv.index("--")] if "--" in sys.argv else sys.argv
    options = ["--factory-startup"] if "--factory-startup" in words else []
    allowed = bpy.context.preferences.filepaths.use_scripts_auto_execute or {"-y", "--enable-autoexec"} & set(words)
    options.append("--enable-autoexec" if allowed and not bpy.app.autoexec_fail else "--disable-autoexec")
    return BlenderCommand(bpy.app.binary_path, options)


def bake_figures(document: Dict[str, Any]) -> Dict[str, Any]:
    """Of what a bake printed, the figures that a window has room for."""
    held = document.get("held_back") or {}
    return {
        "bytes": document.get("bytes", 0),
        "poses": document.get("poses", 0),
        "rig_calls": document.get("rig_calls", 0),
        "train_seconds": document.get("train_seconds", 0.0),
        "mse": held.get("mse", 0.0),
    }


def save_json(document: Dict[str, Any], path: Path) -> None:
    """Writes a document, complete or not at all."""
    target = pathlib.Path(path)
    partial = target.with_name(target.name + ".facebaker-partial")
    partial.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    partial.replace(target)
