"""A rig as Python describes it: for facebaker.bake and its siblings, in this process, and for facebaker.serve."""

from __future__ import annotations

import os
import traceback
from dataclasses import dataclass
from typing import Any, Callable, Dict, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from ._arrays import ArrayLike, Floats, floats, indices, polygon_lists
from ._character import RIG_NUMBERS, About, Channel, Control, Image, Joint, Material, Mesh, Skin, Socket

# Takes two axes exactly, so that a function for arrays of any shape, and one for those of two axes, are both accepted.
Evaluate = Callable[["np.ndarray[Tuple[int, int], np.dtype[np.float32]]"], Any]

KINDS = ("shot", "excitation", "regional", "calisthenics", "dense")
SPLITS = ("train", "validation", "test")


@dataclass(frozen=True, eq=False)
class Clip:
    """Controls over time, and of a recording what they gave.

    name: unique. controls: (frames, controls), float32. kind: "shot" (consecutive frames), "excitation" (one control at
    a time), "regional", "calisthenics" or "dense". split: "train", "validation" (choices during training) or "test"
    (measuring; never trained on). fps: frames a second. positions: (frames, vertices, 3), object space, in units.
    channels: (frames, channels)."""

    name: str
    controls: ArrayLike
    kind: str = "shot"
    split: str = "train"
    fps: float = 30.0
    positions: Optional[ArrayLike] = None
    channels: Optional[ArrayLike] = None


class Evaluated(NamedTuple):
    """What evaluate gave, checked and contiguous: (poses, vertices, 3), (poses, channels) and (poses, joints, 3, 4), of
    which a rig that has none has no columns."""

    positions: Floats
    channels: Floats
    frames: Floats


class Rig:
    """A rig: which controls it has, what its rest mesh is, and where the vertices are in a pose.

    controls: of class Control, or names of controls that go from 0 to 1 and rest at 0; in the order of every pose.

    evaluate: a callable that is given controls, (poses, controls), float32, within their ranges, and returns positions,
    (poses, vertices, 3), before skinning, in units. With channels and skinned it returns a tuple of positions, of
    (poses, channels) if there are channels, and of (poses, joints, 3, 4) if it is skinned. The same controls give the
    same result whenever they are asked for. Its argument is valid during the call only. Without evaluate the rig is a
    recording: every clip has positions.

    skinned: positions, also those at rest, are after skinning, and evaluate says where each joint is, in the space of
    positions: Joint.numbers are then taken out as driven joints, and what others do is left to a host. Not of
    recordings.

    rest_positions: (vertices, 3), what evaluate gives at rest to 1e-5 of the diagonal; None: it is asked.
    polygons: (polygons, corners), vertex indices, -1 behind the last corner of those that have fewer, or a sequence of
    sequences; None: a set of points. uvs: (texture coordinates, 2), v growing upwards. uv_polygons: in the form of
    polygons, indices of uvs; None: those of polygons, a pair a vertex.

    name, units ("cm", "m", ...), up_axis ("y" or "z"): of the character. meshes, materials, images, sockets, channels,
    joints, skin, about: see docs/characters.md. clips: its own animation.

    version: a text that changes when evaluate gives other positions, so that what was evaluated before is not taken for
    its answers. preferred_block: poses that a call should have, at most 4,096, for a rig that works on several at once;
    0: any number. thread_safe: evaluate may be called from several threads at once. notes: sentences for the user.

    Raises ValueError on arrays of wrong shapes; the rest is checked by the library, by name, when the rig is opened."""

    def __init__(
        self,
        controls: Sequence[Union[Control, str]],
        evaluate: Optional[Evaluate] = None,
        *,
        name: str = "rig",
        units: str = "cm",
        up_axis: str = "y",
        rest_positions: Optional[ArrayLike] = None,
        polygons: Any = None,
        uvs: Optional[ArrayLike] = None,
        uv_polygons: Any = None,
        meshes: Sequence[Mesh] = (),
        materials: Sequence[Material] = (),
        images: Sequence[Image] = (),
        sockets: Sequence[Socket] = (),
        channels: Sequence[Channel] = (),
        joints: Sequence[Joint] = (),
        skin: Optional[Skin] = None,
        about: Optional[About] = None,
        clips: Sequence[Clip] = (),
        version: str = "",
        preferred_block: int = 0,
        thread_safe: bool = False,
        skinned: bool = False,
        notes: Sequence[str] = (),
    ) -> None:
        self.controls = tuple(Control(control) if isinstance(control, str) else control for control in controls)
        self.evaluate = evaluate
        self.name, self.units, self.up_axis = name, units, up_axis
        self.meshes, self.materials, self.images = tuple(meshes), tuple(materials), tuple(images)
        self.sockets, self.channels, self.joints = tuple(sockets), tuple(channels), tuple(joints)
        self.about, self.version, self.notes = about, version, tuple(notes)
        self.preferred_block, self.thread_safe, self.skinned = preferred_block, thread_safe, skinned
        self._check_joints()
        if not 0 <= preferred_block <= 4096:
            raise ValueError(f"preferred_block is {preferred_block}, not 0 to 4096")
        self.rest_controls: Floats = np.array([control.rest for control in self.controls], np.float32)
        if rest_positions is None:
            rest_positions = self._positions_at_rest()
        self.rest_positions: Floats = floats(rest_positions, (None, 3), "rest_positions")
        self.polygon_sizes, self.polygon_corners = polygon_lists(() if polygons is None else polygons, "polygons")
        self.uvs: Floats = floats(np.zeros((0, 2)) if uvs is None else uvs, (None, 2), "uvs")
        self.uv_corners = self._uv_corners(uv_polygons)
        self.skin = None if skin is None else self._checked_skin(skin)
        self.clips = tuple(self._checked_clip(clip) for clip in clips)

    def __repr__(self) -> str:
        kind = "rig" if self.evaluate else "recording"
        return (
            f"<facebaker.Rig {self.name!r}: {kind}, {len(self.controls)} controls, {len(self.rest_positions)} vertices>"
        )

    def evaluate_poses(self, controls: Floats) -> Evaluated:
        """Of (poses, controls). Raises what evaluate does, and ValueError on arrays of another shape."""
        if self.evaluate is None:
            raise TypeError(f"{self.name!r} is a recording, which has no new poses")
        given: Any = controls
        poses, parts = len(controls), self._parts_of(self.evaluate(given))
        channels: Any = parts.get("channels", np.zeros((poses, 0)))
        frames: Any = parts.get("frames", np.zeros((poses, 0, 3, 4)))
        joints = len(self.joints) if self.skinned else 0
        return Evaluated(
            floats(parts["positions"], (poses, len(self.rest_positions), 3), "positions that evaluate gave"),
            floats(channels, (poses, len(self.channels)), "channels that evaluate gave"),
            floats(frames, (poses, joints, 3, 4), "frames that evaluate gave"),
        )

    def _parts_of(self, result: Any) -> Dict[str, Any]:
        """What evaluate returned, by what it is."""
        names = ["positions"] + ["channels"] * bool(self.channels) + ["frames"] * self.skinned
        if len(names) == 1:
            return {"positions": result}
        if not isinstance(result, tuple) or len(result) != len(names):
            raise ValueError(f"evaluate gave {type(result).__name__}, not a tuple of {' and '.join(names)}")
        return dict(zip(names, result))

    def _check_joints(self) -> None:
        if self.skinned and self.evaluate is None:
            raise ValueError("a recording is not skinned: it has no frames of joints")
        for joint in self.joints:
            for number in joint.numbers:
                if number not in RIG_NUMBERS:
                    raise ValueError(f'joint "{joint.name}": {number!r} is none of {", ".join(RIG_NUMBERS)}')
            if joint.numbers and not self.skinned:
                raise ValueError(f'joint "{joint.name}" has numbers, and the rig is not skinned')

    def _positions_at_rest(self) -> ArrayLike:
        if self.evaluate is None:
            raise ValueError("a recording needs rest_positions")
        rest: Any = self.rest_controls[None].copy()
        positions = self._parts_of(self.evaluate(rest))["positions"]
        return np.array(floats(positions, (1, None, 3), "positions that evaluate gave")[0])

    def _uv_corners(self, uv_polygons: Any) -> Any:
        if len(self.uvs) == 0:
            return np.zeros(0, np.uint32)
        if uv_polygons is None:
            if len(self.uvs) != len(self.rest_positions):
                raise ValueError(
                    f"{len(self.uvs)} uvs of {len(self.rest_positions)} vertices: uv_polygons say which corners have which"
                )
            return self.polygon_corners
        sizes, corners = polygon_lists(uv_polygons, "uv_polygons")
        if not np.array_equal(sizes, self.polygon_sizes):
            raise ValueError("uv_polygons: not as many corners as polygons have")
        return corners

    def _checked_skin(self, skin: Skin) -> Skin:
        weights = floats(skin.weights, (len(self.rest_positions), None), "weights of skin")
        joints = indices(skin.joints, "joints of skin")
        if joints.shape != weights.shape:
            raise ValueError(f"joints of skin: shape {joints.shape}, that of weights is {weights.shape}")
        if len(joints) and joints.max() >= len(self.joints):
            raise ValueError(f"joints of skin: {joints.max()}, where there are {len(self.joints)} joints")
        return Skin(joints.astype(np.uint16), weights)

    def _checked_clip(self, clip: Clip) -> Clip:
        what = f'clip "{clip.name}"'
        if clip.kind not in KINDS:
            raise ValueError(f"{what}: kind {clip.kind!r} is none of {', '.join(KINDS)}")
        if clip.split not in SPLITS:
            raise ValueError(f"{what}: split {clip.split!r} is none of {', '.join(SPLITS)}")
        controls = floats(clip.controls, (None, len(self.controls)), f"{what}: controls")
        if self.evaluate:
            if clip.positions is not None:
                raise ValueError(f"{what}: has positions, which are for rigs without evaluate")
            return Clip(clip.name, controls, clip.kind, clip.split, clip.fps)
        if clip.positions is None:
            raise ValueError(f"{what}: has no positions, and the rig no evaluate")
        positions = floats(clip.positions, (len(controls), len(self.rest_positions), 3), f"{what}: positions")
        channels = None
        if self.channels:
            given = np.zeros((0, 0)) if clip.channels is None else clip.channels
            channels = floats(given, (len(controls), len(self.channels)), f"{what}: channels")
        return Clip(clip.name, controls, clip.kind, clip.split, clip.fps, positions, channels)


def describe(error: BaseException) -> str:
    """One line: the exception's type, its text and where it was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({os.path.basename(frames[-1].filename)}, line {frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {error}{place}"
