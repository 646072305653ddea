"""What a bake of a scene needs on the disk: a copy of the scene and the settings, in a folder beside the archive; and what
the rig answered before it was edited."""

from __future__ import annotations

import hashlib
import json
import os
import pathlib
import shutil
import sys
from dataclasses import replace
from typing import Any, Dict, List, Optional

import bpy

from .bake_check import check_before_bake
from .bake_process import BakeProcess
from .bake_settings import BakeSettings, Path, save_settings
from .channels import SettingsError
from .kept_answers import worth_keeping
from .tool_command import BlenderCommand, bake_words, source_text, tool_environment


_EVALUATIONS = "rig.evaluations"  # in a work folder: what the rig answered


class BakeJob:
    """The bake of one archive. Its folder is NAME.blender beside the archive NAME.fbk. In it, `work` is the work folder of
    the rig as it is, and `earlier`, until the bake is complete, holds what the rig answered before it was edited."""

    def __init__(self, archive: Path) -> None:
        self.archive = pathlib.Path(archive).resolve()
        if self.archive.suffix != ".fbk":
            raise SettingsError(f"{self.archive}: an archive's name ends in .fbk")
        self.folder = self.archive.with_suffix(".blender")
        self.scene, self.settings = self.folder / "scene.blend", self.folder / "settings.json"
        self.work, self.earlier = self.folder / "work", self.folder / "earlier"
        self.report_page = self.folder / "report" / "index.html"
        self.process = BakeProcess(self.folder)

    def prepare(self, settings: BakeSettings, session: Optional[str] = None) -> None:
        """Saves a copy of the open file, and the settings. The copy of an earlier bake is used again if the file on disk is
        as it was then and has no changes that are not saved: so the same command goes on with an interrupted bake. session:
        a digest of what was done since the file was read, from who knows; None: ask Blender whether there are changes,
        which without a window it says of any file from 4.2 on. Raises OSError, SettingsError."""
        if self.process.running:
            raise SettingsError(f"a bake of {self.archive.name} is running")
        self.folder.mkdir(parents=True, exist_ok=True)
        stamp, stamp_file = _file_stamp(session), self.folder / "settings.version"
        if not (stamp and self.scene.is_file() and _text(stamp_file) == stamp):
            stamp_file.unlink(missing_ok=True)
            bpy.ops.wm.save_as_mainfile(filepath=str(self.scene), copy=True, relative_remap=True, check_existing=False)
            stamp_file.write_text(stamp or hashlib.sha256(self.scene.read_bytes()).hexdigest()[:16])
        save_settings(settings, self.settings)
        self._set_aside(f"{settings.deformation} {settings.sampling} {_text(stamp_file)} {self._source()}")

    def _source(self) -> str:
        return source_text(this_blender(), self.scene, self.settings)

    def _set_aside(self, rig: str) -> None:
        """Moves what another rig answered out of the work folder, so that this one's bake takes over what still holds; of
        two such files the larger is kept, as an edit may be taken back. rig: a text that is another for another rig, and for
        other poses to ask it, as the tool takes no others in a work folder."""
        known = self.folder / "work.version"
        if _text(known) != rig:
            answers, kept = self.work / _EVALUATIONS, self.earlier / _EVALUATIONS
            if answers.is_file() and not (kept.is_file() and kept.stat().st_size > answers.stat().st_size):
                self.earlier.mkdir(exist_ok=True)
                os.replace(answers, kept)
            if self.work.is_dir():
                shutil.rmtree(self.work)
            known.write_text(rig)

    def words(self, settings: BakeSettings, tool: str) -> List[str]:
        """The command line of the bake."""
        options = settings.bake
        named = options.reuse and pathlib.Path(options.reuse).resolve()
        if not named or named == self.work:
            options = replace(options, reuse=str(self.earlier) if self.earlier.is_dir() else "")
        report = [] if "--report" in options.extra else ["--report", str(self.report_page.parent)]
        return [*bake_words(tool, self._source(), self.archive, self.work, options), *report, "--json"]

    def start(self, settings: BakeSettings, tool: str, session: Optional[str] = None) -> None:
        """Prepares and starts the bake in the background. Raises OSError, SettingsError, also of what would fail after it."""
        check_before_bake(self.archive, self.folder, tool)
        self.prepare(settings, session)
        self.process.start(self.words(settings, tool), tool_environment(tool))

    def tidy(self) -> None:
        """Removes, once a bake is complete, what the rig answered before it was edited; and what it answered now, where
        that is large and quickly asked again."""
        document = self.process.document
        if document is None or self.process.running:
            return
        if self.earlier.is_dir():
            shutil.rmtree(self.earlier)
        answers = self.work / _EVALUATIONS
        if answers.is_file() and not worth_keeping(answers.stat().st_size, document["bytes"], document["asked_by_stage"]):
            answers.unlink()

    def go_on(self) -> None:
        """Goes on with a bake that was interrupted, from the copy of the scene that it had. Raises SettingsError."""
        if not self.process.unfinished:
            raise SettingsError(f"there is no bake of {self.archive.name} to go on with")
        words = self.process.command
        self.process.start(words, tool_environment(words[0]))


def _text(path: pathlib.Path) -> str:
    return path.read_text().strip() if path.is_file() else ""


def _file_stamp(session: Optional[str]) -> str:
    """A digest of the open file as it lies on disk, and of the files it links; "" if it has changes that are not saved."""
    if session is None and bpy.data.is_dirty or not bpy.data.filepath:
        return ""
    digest = hashlib.sha256(f"{bpy.app.version_string} {session or ''}".encode())
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


def save_json(document: Dict[str, Any], path: Path) -> None:
    """Writes a document, complete or not at all."""
    target = pathlib.Path(path)
    partial = target.with_name(target.name + ".facebaker-partial")
    partial.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    partial.replace(target)
