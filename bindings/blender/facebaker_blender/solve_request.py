"""What is solved for, by which preferences, and what came of it. Without Blender."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence, Tuple

from .bake_settings import Path
from .channels import SceneControl, SettingsError, there_are
from .shown_lengths import length_text

WHOLE = -1  # in place of a mesh's index: a shape with the vertices of all meshes
_NAMED = 12  # controls in a line of the result, at most


@dataclass(frozen=True)
class SolveRequest:
    """frames: the first and the last frame of an animated mesh; None: its shape as it is. in_world: shapes are where their
    objects stand in the scene, and not where the rig's own meshes are at rest. new_action: keys go into a new action, and not
    into the current one. head_motion: where the head is, is found as well, and dropped. noise: what shapes are off by
    themselves, in millimetres. only, locked: names of controls or groups that move; that do not."""

    frames: Optional[Tuple[int, int]] = None
    in_world: bool = False
    new_action: bool = True
    head_motion: bool = False
    noise: float = 0.5
    only: Tuple[str, ...] = ()
    locked: Tuple[str, ...] = ()

    def locked_controls(self, controls: Sequence[SceneControl]) -> List[str]:
        """The names of the controls that stay at rest. Raises SettingsError on a name that is none of a control or group."""
        known = list(dict.fromkeys(name for c in controls for name in (c.name, c.group) if name))
        for name in [*self.only, *self.locked]:
            if name not in known:
                raise SettingsError(f'there is no control or group "{name}"; {there_are(known, name)}')

        def moves(control: SceneControl) -> bool:
            names = {control.name, control.group}
            return not names & set(self.locked) and (not self.only or bool(names & set(self.only)))

        locked = [control.name for control in controls if not moves(control)]
        if len(locked) == len(controls):
            raise SettingsError("all controls are locked")
        return locked


def solve_words(tool: str, archive: Path, target: Path, out: Path, request: SolveRequest) -> List[str]:
    """The command line that solves for the positions in a file, and prints its figures as JSON."""
    words = [tool, "solve", *(os.path.abspath(os.fspath(path)) for path in (archive, target))]
    words += ["--out", os.path.abspath(os.fspath(out)), "--noise", f"{request.noise:g}", "--json", "-"]
    words += ["--head-motion"] if request.head_motion else []
    for option, names in (("--only", request.only), ("--lock", request.locked)):
        for name in names:
            words += [option, name]
    return words


def matched_meshes(shapes: Sequence[Tuple[str, int]], meshes: Sequence[Tuple[str, int]]) -> List[int]:
    """Which of the face's meshes each shape is one of: an index, or WHOLE. Both are names with numbers of vertices. A shape
    is of that mesh with as many vertices which has its name, or its name before a blank; else its name but for the number
    that Blender puts behind copies; else of the only one. Raises SettingsError."""
    total = sum(count for _, count in meshes)
    if len(shapes) == 1 and shapes[0][1] == total:
        return [0 if len(meshes) == 1 else WHOLE]
    found: List[int] = []
    for name, count in shapes:
        index = _mesh_of(name, count, meshes)
        if index in found:
            first = shapes[found.index(index)][0]
            mesh = meshes[index][0]
            raise SettingsError(f'"{first}" and "{name}" are both shapes of the mesh "{mesh}"; select one of them')
        found.append(index)
    return found


def _mesh_of(name: str, count: int, meshes: Sequence[Tuple[str, int]]) -> int:
    fitting = [index for index, mesh in enumerate(meshes) if mesh[1] == count]
    if not fitting:
        raise SettingsError(f'"{name}" has {count:,} vertices, {_sizes(meshes)}; a shape has the topology of the face')
    named = [index for index in fitting if f"{name} ".startswith(f"{meshes[index][0]} ")]
    alike = [index for index in fitting if _stem(meshes[index][0]) == _stem(name)]
    for candidates in named, alike, fitting:
        if len(candidates) == 1:
            return candidates[0]
        if candidates:
            break
    names = " or ".join(f'"{meshes[index][0]}"' for index in candidates)
    raise SettingsError(
        f'"{name}" may be a shape of {names}, which have as many vertices; rename it, such as '
        f'"{meshes[candidates[-1]][0]} shape"'
    )


def _sizes(meshes: Sequence[Tuple[str, int]]) -> str:
    total = f"the face {sum(count for _, count in meshes):,}"
    if len(meshes) == 1:
        return total
    return total + ": " + ", ".join(f'"{name}" {count:,}' for name, count in meshes)


def _stem(name: str) -> str:
    """Without the number that Blender puts behind the names of copies."""
    stem, dot, number = name.rpartition(".")
    return stem if dot and len(number) == 3 and number.isdigit() else name


def solve_lines(document: Dict[str, Any], first: int, locked: Sequence[str], missing: Sequence[str]) -> List[str]:
    """Of the JSON document that `facebaker solve` prints: how far the face is off, and what the shape does not decide.
    first: the number of its first frame. missing: meshes without a shape."""
    frames, units = int(document["frames"]), str(document["units"])
    rms, most = (length_text(float(document[key]), units) for key in ("rms", "max"))
    worst = f", in frame {first + int(document['worst_frame'])}" if frames > 1 else ""
    before = f"{frames} frames: off" if frames > 1 else "Off"
    lines = [f"{before} by {rms} in the root mean square, by {most} at most{worst}"]
    moving = int(document["controls_moving"])
    lines.append("1 control moves" if moving == 1 else f"{moving} controls move")
    undecided = [str(one["control"]) for one in document["undecided"]]
    if undecided:
        lines.append(f"The shape hardly decides {listed(undecided)}: other values of these do as well")
    if locked:
        lines.append(f"Locked at rest: {listed(locked)}")
    if missing:
        lines.append(f"Without a shape: {listed(missing)}")
    return [*lines, *(f"{note[:1].upper()}{note[1:]}" for note in map(str, document.get("notes", ())))]


def listed(names: Sequence[str]) -> str:
    """Names in a line for people, not all of many."""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(f'"{name}"' for name in names[:_NAMED]) + more
