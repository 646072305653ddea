"""Where the poses of a bake come from: rigs, recordings, and whatever the tool takes as SOURCE."""

from __future__ import annotations

import os
import tempfile
import weakref
from ctypes import byref, c_void_p, pointer
from typing import Any, List, Optional, Sequence, Tuple, Union

import numpy as np

from ._arrays import ArrayLike, Floats, Indices, floats
from ._calls import Call, Note, c_strings, path_bytes
from ._character import Control
from ._dataset import save_dataset
from ._from_structs import controls_of, copied
from ._interop import FB_SOURCE_LIVE, fb_clip, fb_control, fb_source_desc, fb_source_info
from ._library import assign
from ._library import bake_library as library
from ._progress import Progress
from ._rig import KINDS, SPLITS, Clip, Rig
from ._rig_struct import HostRig

Place = Union[str, "os.PathLike[str]"]
AnySource = Union["Source", Rig, Place, Sequence[Place]]

JOINTS = ("auto", "ignore", "controls")


class Source:
    """An opened rig or recording. A context manager: close() ends its processes.

    source: a Rig; or what the tool takes as SOURCE: a dataset folder, a rig plugin (.so), a .glb, .gltf or .vrm
    file, "exec:COMMAND", "sample"; or several of these that are one character. workers: child processes, at most 256, that run
    rigs other than a Rig at once, by the program `host` (default: facebaker, found in PATH); 0: in this process, a command
    in one child. pose_seconds: a pose that takes a child longer hangs. clip_budget: frames of a live rig's own clips that
    are used at most, of each split; 0: all. joints: of a glTF file: "ignore", the skeleton that carries the face;
    "controls", controls of it, by names such as "Jaw.rx", and positions are after skinning; "auto", the latter where the
    file has no morph targets. control_joints: names of the joints that are controls, instead of all that the file's
    animations move. skip_broken: meshes and animations of a glTF file that cannot be read are left out, each with a note,
    instead of raising. test_poses: poses that are drawn to measure on, as clips of split test, where a live source has no
    clips. progress, note: as for bake.

    Attributes: name, units, up_axis; diagonal, of the rest mesh's bounding box, in units, by which errors are divided;
    live, whether new poses can be evaluated; controls, of class Control; rest_positions, (vertices, 3); polygon_sizes
    and polygon_corners; clips, without positions, which read() gives; notes, what was found while opening.

    Calls that evaluate one source run one at a time. Raises the exceptions of facebaker.Error."""

    def __init__(
        self,
        source: Union[Rig, Place, Sequence[Place]],
        *,
        workers: int = 0,
        host: Optional[Place] = None,
        pose_seconds: float = 60.0,
        clip_budget: int = 0,
        joints: str = "auto",
        control_joints: Sequence[str] = (),
        skip_broken: bool = False,
        test_poses: int = 0,
        progress: Progress = None,
        note: Note = None,
    ) -> None:
        if joints not in JOINTS:
            raise ValueError(f'joints is "{joints}", none of {", ".join(JOINTS)}')
        desc = library.filled(fb_source_desc)
        assign(desc, workers=workers, pose_seconds=pose_seconds, clip_budget=clip_budget, joints=JOINTS.index(joints))
        desc.test_poses, desc.skip_broken = test_poses, int(skip_broken)
        desc.control_joints, desc.control_joint_count = c_strings([name.encode() for name in control_joints])
        desc.host = None if host is None else path_bytes(host)
        self._rig: Optional[HostRig] = None
        self._folder: Optional[tempfile.TemporaryDirectory[str]] = None
        if isinstance(source, Rig) and source.evaluate is None:
            self._folder = tempfile.TemporaryDirectory(prefix="facebaker-")
            save_dataset(source, self._folder.name)
            source = self._folder.name
        if isinstance(source, Rig):
            self._rig = HostRig(source)
            desc.rig = pointer(self._rig.struct)
        else:
            places: List[Place] = [source] if isinstance(source, (str, os.PathLike)) else list(source)
            desc.paths, desc.path_count = c_strings([path_bytes(place) for place in places])
        handle = c_void_p()
        self._closer = weakref.finalize(self, _close, handle, self._rig, self._folder)
        with Call(progress, note) as call:
            desc.callbacks = call.callbacks
            call.run(library.fb_source_open, desc, byref(handle), rig=self._rig)
        self._handle: Optional[c_void_p] = handle
        self.notes: Tuple[str, ...] = tuple(call.notes)
        self._describe()

    def __enter__(self) -> "Source":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __repr__(self) -> str:
        kind = "live" if self.live else "recording"
        counts = f"{len(self.controls)} controls, {len(self.rest_positions)} vertices, {len(self.clips)} clips"
        return f"<facebaker.Source {self.name!r}: {kind}, {counts}{'' if self._handle else ', closed'}>"

    def close(self) -> None:
        """Ends the source's processes and frees it; no call may be using it. Further calls raise ValueError."""
        self._handle = None
        self._closer()

    @property
    def handle(self) -> c_void_p:
        """The fb_source. Raises ValueError if it is closed."""
        if self._handle is None:
            raise ValueError(f"the source {self.name!r} is closed")
        return self._handle

    @property
    def host_rig(self) -> Optional[HostRig]:
        """The Rig behind it, if it is one."""
        return self._rig

    def evaluate(self, controls: ArrayLike, threads: int = 0) -> Floats:
        """Positions of new poses of a live source: (poses, controls), all within their ranges -> (poses, vertices, 3), in
        units. threads: of a source that is thread-safe; 0: all cores."""
        poses = floats(controls, (None, len(self.controls)), "controls")
        positions = np.empty((len(poses), *self.rest_positions.shape), np.float32)
        if len(poses) == 0:
            return positions
        with Call() as call:
            call.run(
                library.fb_source_evaluate, self.handle, poses.ctypes.data, len(poses), threads, positions.ctypes.data,
                positions.size, rig=self._rig,
            )  # fmt: skip
        return positions

    def read(self, clip: Union[int, str], first: int = 0, count: Optional[int] = None) -> Floats:
        """Positions of frames of a clip, which is given by name or index: (frames, vertices, 3), in units. Recorded frames
        are read, a live rig's are evaluated. count: None: all from `first` on."""
        names = [known.name for known in self.clips]
        if isinstance(clip, str):
            if clip not in names:
                raise ValueError(f'there is no clip "{clip}"; there are {", ".join(names) or "none"}')
            clip = names.index(clip)
        frames = len(np.asarray(self.clips[clip].controls))
        count = frames - first if count is None else count
        if first < 0 or count < 0 or first + count > frames:
            raise ValueError(f"frames {first} to {first + count} of a clip that has {frames}")
        positions = np.empty((count, *self.rest_positions.shape), np.float32)
        with Call() as call:
            call.run(
                library.fb_source_read, self.handle, clip, first, count, positions.ctypes.data, positions.size,
                rig=self._rig,
            )  # fmt: skip
        return positions

    def _describe(self) -> None:
        info = library.filled(fb_source_info)
        library.check(library.fb_source_describe(self.handle, info))
        self.name: str = info.name.decode()
        self.units: str = info.units.decode()
        self.up_axis: str = info.up_axis.decode()
        self.diagonal: float = info.diagonal
        self.live = bool(info.flags & FB_SOURCE_LIVE)
        self.rest_positions: Floats = copied(info.rest_positions, 3 * info.vertex_count).reshape(-1, 3)
        self.polygon_sizes: Indices = copied(info.polygon_sizes, info.polygon_count)
        self.polygon_corners: Indices = copied(info.polygon_corners, info.polygon_corner_count)
        structs = [library.filled(fb_control) for _ in range(info.control_count)]
        for index, struct in enumerate(structs):
            library.check(library.fb_source_control_at(self.handle, index, struct))
        self.controls: Tuple[Control, ...] = controls_of(structs)
        self.clips: Tuple[Clip, ...] = tuple(self._clip(index) for index in range(info.clip_count))

    def _clip(self, index: int) -> Clip:
        struct = library.filled(fb_clip)
        library.check(library.fb_source_clip_at(self.handle, index, struct))
        controls = copied(struct.controls, struct.frames * len(self.controls)).reshape(struct.frames, -1)
        return Clip(struct.name.decode(), controls, KINDS[struct.kind], SPLITS[struct.split], struct.fps)


def _close(handle: c_void_p, rig: Optional[HostRig], folder: "Optional[tempfile.TemporaryDirectory[str]]") -> None:
    """Keeps what the source uses until it is closed."""
    library.fb_source_close(handle)
    if folder is not None:
        folder.cleanup()
    del rig
