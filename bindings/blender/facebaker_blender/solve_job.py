"""The controls of a rig for shapes: frames are read from the scene, the tool solves for them in the background, and what it
finds becomes keys."""

from __future__ import annotations

import contextlib
import pathlib
import tempfile
import time
from typing import TYPE_CHECKING, Any, Generator, List

import bpy
import numpy as np

from .bake_process import BakeProcess
from .bake_settings import BakeSettings, load_settings
from .channels import SettingsError
from .control_keys import key_controls
from .scene_channels import SceneChannels
from .solve_request import SolveRequest, listed, solve_lines, solve_words
from .solve_shapes import SolveShapes
from .tool_command import tool_environment

if TYPE_CHECKING:
    import facebaker

_AWAY = 0.01  # of a control's range, from rest
_END_SECONDS = 10  # that an interrupted tool has to end


class SolveJob:
    """One solve. Call advance() until it is True, then finish(); close() in any case. Its files are in a folder that close()
    removes. Attributes: reading, whether frames are still read from the scene; stopped, whether it was told to stop."""

    def __init__(
        self, context: Any, archive: pathlib.Path, settings: pathlib.Path, request: SolveRequest, tool: str
    ) -> None:
        """Raises SettingsError, facebaker.Error, OSError."""
        import facebaker

        self.archive, self.request, self._tool = archive, request, tool
        self.settings = rig_settings(settings)
        face = facebaker.load(str(archive))
        _check_controls(face, self.settings, archive)
        SceneChannels(self.settings.controls)  # all are there
        self._locked = request.locked_controls(self.settings.controls)
        now = int(context.scene.frame_current)
        ends = request.frames or (now, now)
        self.first, self.last = ends
        if self.last < self.first:
            raise SettingsError(f"frames {self.first} to {self.last}: the last is before the first")
        self.reading, self.stopped, self._read = True, False, 0
        self.missing: List[str] = []
        self._temporary = tempfile.TemporaryDirectory(prefix="facebaker-solve-", dir=bpy.app.tempdir or None)
        self._folder = pathlib.Path(self._temporary.name)
        self.process = BakeProcess(self._folder, "solve")
        self._frames = self._read_frames(context, face)
        try:
            next(self._frames)
        except BaseException:
            self.close()
            raise

    def _read_frames(self, context: Any, face: "facebaker.Face") -> Generator[int, None, None]:
        """Writes the target, frame by frame; gives how many are done, 0 once it is known that there are shapes."""
        shape = (self.last - self.first + 1, face.vertex_count, 3)
        with SolveShapes(context, self.settings, face, self.request.in_world) as shapes:
            self.missing = shapes.missing
            memmap: Any = np.lib.format.open_memmap
            target = memmap(str(self._target), "w+", np.dtype("<f4"), shape)
            yield 0
            with contextlib.closing(shapes.frames(self.request.frames)) as frames:
                for index, positions in enumerate(frames):
                    target[index] = positions
                    yield index + 1
            target.flush()

    @property
    def lines(self) -> List[str]:
        """How far it is, for the panel."""
        if self.stopped:
            return ["Stopping"]
        if self.reading:
            return [f"Reading frames: {self._read} of {self.last - self.first + 1}", "Esc stops"]
        return self.process.progress.lines

    def advance(self, seconds: float) -> bool:
        """Goes on, for about so long where frames are read; whether controls were found, or it has stopped. Raises
        SettingsError on what the scene or the tool fail with."""
        if self.reading and self.stopped:
            return True
        if self.reading:
            end = time.monotonic() + seconds
            for self._read in self._frames:
                if time.monotonic() >= end:
                    return False
            self.reading = False
            words = solve_words(self._tool, self.archive, self._target, self._out, self.request)
            self.process.start(words, tool_environment(self._tool))
        if self.process.poll():
            return False
        if self.process.document is None and not self.stopped:
            # Without the name of a log that close() removes.
            raise SettingsError(self.process.failure.replace(f"{self.process.log} ", "its log "))
        return True

    def stop(self) -> None:
        """Has it end without keys; advance() tells when."""
        self.stopped = True
        self.process.stop()

    def finish(self, context: Any) -> List[str]:
        """Writes the keys; lines on what was found, for people."""
        values, controls = np.load(self._out), self.settings.controls
        name = f"{self.settings.name} solved" if self.request.new_action else ""
        actions = key_controls(context, controls, values, self.first, self._locked, name)
        lines = solve_lines(self.process.document or {}, self.first, self._locked, self.missing)
        away = zip(controls, SceneChannels(controls).read().tolist())
        moved = [c.name for c, value in away if c.name in self._locked and abs(value - c.rest) > _AWAY * c.span]
        if moved:
            lines.append(f"Not at rest in this frame, though the others were found as if they were: {listed(moved)}")
        return [*lines, f"Keys are in {listed(actions)}"]

    def close(self) -> None:
        """Ends what runs, and restores the scene but for keys."""
        if self.process.running:
            self.process.stop()
            self.process.wait(_END_SECONDS)
        self._frames.close()
        self._temporary.cleanup()

    @property
    def _target(self) -> pathlib.Path:
        return self._folder / "target.npy"

    @property
    def _out(self) -> pathlib.Path:
        return self._folder / "controls.npy"


def rig_settings(path: pathlib.Path) -> BakeSettings:
    """What a face's controls are in the scene. Raises SettingsError."""
    if not path.is_file():
        raise SettingsError(
            f"{path}: is not there, so nobody knows which channels of the scene the face's controls are; put the settings "
            "file of its bake there, or bake it again"
        )
    settings = load_settings(path)
    if not settings.controls:
        raise SettingsError(f"{path}: it has no controls")
    return settings


def _check_controls(face: "facebaker.Face", settings: BakeSettings, archive: pathlib.Path) -> None:
    names, theirs = [control.name for control in settings.controls], [control.name for control in face.controls]
    if names != theirs:
        other = sorted(set(names) ^ set(theirs))
        what = f'"{other[0]}" is not in both' if other else "they are in another order"
        raise SettingsError(f"{archive}: has other controls than its settings: {what}")
