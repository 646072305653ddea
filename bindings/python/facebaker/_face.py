"""Loaded faces: what is in them, and posing them."""

from __future__ import annotations

import collections.abc
import ctypes
import os
from ctypes import POINTER, byref, c_float, c_void_p
from typing import IO, Any, Callable, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._arrays import ArrayLike, Controls, Floats, Indices, check_output
from ._choices import Chosen, choice, control_indices, index_of
from ._face_contents import FaceContents
from ._interop import fb_batch_desc, fb_load_desc, fb_log, fb_row_block
from ._library import assign, check, library
from ._solutions import Solution
from ._solver import Solver


class ExpectedError(NamedTuple):
    """What to expect of a pose.

    face: the root mean square distance of the face's vertices from where the rig has them, in units. regions: the same of
    each of error_regions. outside: how many controls are outside of what was trained."""

    face: Any
    regions: Floats
    outside: Any


def load(
    source: "Union[str, os.PathLike[str], bytes, bytearray, memoryview, IO[bytes]]",
    *,
    max_file_bytes: int = 4 << 30,
    max_model_bytes: int = 4 << 30,
    max_name_bytes: int = 16 << 20,
    max_vertices: int = 4 << 20,
    max_polygons: int = 8 << 20,
    max_features: int = 1 << 20,
    threads: int = 1,
    note: Optional[Callable[[str], Any]] = None,
) -> "Face":
    """Loads a face from a path, from the bytes of an archive, or from an open file, which is read to its end.

    Files from strangers are safe; what is larger than a limit is refused with LimitError, see fb_load_desc. threads: that
    decode the basis, at most; 0: as many as OpenMP would use. note: called
    with sentences about what is odd but no error. Raises NotFoundError, FileError, NotAnArchiveError, CorruptError,
    UnsupportedError, LimitError or OutOfMemoryError."""
    desc = library.filled(fb_load_desc)
    assign(desc, max_file_bytes=max_file_bytes, max_model_bytes=max_model_bytes, max_name_bytes=max_name_bytes)
    assign(desc, max_vertices=max_vertices, max_polygons=max_polygons, max_features=max_features, threads=threads)
    notes: List[str] = []
    desc.log = fb_log(lambda _, sentence: notes.append(sentence.decode("utf-8", "replace")))
    handle = c_void_p()
    if hasattr(source, "read"):
        source = source.read()
    if isinstance(source, (bytes, bytearray, memoryview)):
        data: Union[bytes, str] = bytes(source)
        check(library.fb_load_memory(data, len(data), desc, byref(handle)))
    else:
        data = os.path.abspath(os.fspath(source))
        check(library.fb_load(os.fsencode(source), desc, byref(handle)))
    face = Face(handle, data)
    if note is not None:
        for sentence in notes:
            note(sentence)
    return face


class Face(FaceContents):
    """A loaded face, which never changes. Any number of threads may evaluate one face at once.

    Its arrays are read-only views of the model, without copies, which they keep alive. It can be pickled: a face that was
    loaded from a path by that path, one that was loaded from bytes by these bytes, which it keeps. It is a context
    manager, which closes it."""

    def __enter__(self) -> "Face":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __reduce__(self) -> Tuple[Any, ...]:
        return load, (self.source,)

    # Poses

    @property
    def clamped_count(self) -> int:
        """The number of control values that this thread's last evaluation clamped to their ranges."""
        return self._scratches.clamped_count

    def find(self, name: str) -> int:
        """The index of a control by its name, its ARKit name or its FACS name; the error names the closest there is."""
        return self._found(library.fb_find_control, name)

    def find_hash(self, name_hash: int) -> int:
        """The index of a control by the hash of its name, as `facebaker header` writes it. Raises NotFoundError."""
        index = ctypes.c_uint32()
        check(library.fb_find_control_hash(self._handle, name_hash, byref(index)))
        return index.value

    def blend(self, first: Controls, other: Optional[Controls], share: float) -> Floats:
        """(controls,), float32: between two poses as controls, the first at share 0 and the other at 1, clamped to their
        ranges. other: None is the mirror of the first. Raises ValueError on NaN."""
        begin = self._one_pose(first)
        end = None if other is None else self._one_pose(other)
        blended = np.empty_like(self.rest_controls)
        to = None if end is None else end.ctypes.data
        check(library.fb_blend_controls(self._handle, begin.ctypes.data, to, share, blended.ctypes.data))
        return blended

    def find_controls(self, chosen: Chosen) -> Indices:
        """(chosen,), uint32: indices of controls by names of controls, as find() takes them, names of control groups and
        indices, or by a mask, (controls,); in the order in which they are chosen, each once. What is the name of a
        control and of a group is both. Raises ValueError on what there is not."""
        return control_indices(self, chosen, "chosen")

    def find_mesh(self, name: str) -> int:
        """The index of a mesh; the error names those there are. So do find_socket, find_channel, find_joint
        and find_driven_joint."""
        return self._found(library.fb_find_mesh, name)

    def find_socket(self, name: str) -> int:
        return self._found(library.fb_find_socket, name)

    def find_channel(self, name: str) -> int:
        return self._found(library.fb_find_channel, name)

    def find_joint(self, name: str) -> int:
        return self._found(library.fb_find_joint, name)

    def find_driven_joint(self, name: str) -> int:
        return self._found(library.fb_find_driven_joint, name)

    def find_region(self, name: str) -> int:
        """The index of a region. Raises ValueError, with the closest name there is."""
        return index_of(name, self.regions, "region")

    def pose(self, values: Mapping[str, float]) -> Floats:
        """(controls,), float32: the rest pose with the controls in `values`, a dictionary from names to values."""
        controls = self.rest_controls.copy()
        for name, value in values.items():
            controls[self.find(name)] = value
        return controls

    def evaluate(self, controls: Controls, out: Optional[Floats] = None) -> Floats:
        """One pose, on the calling thread: (controls,), or a dictionary as for pose() -> positions, (vertices, 3), float32,
        in units. out: a contiguous float32 array of that shape to write them to."""
        values = self._one_pose(controls)
        if out is None:
            out = np.empty((self.vertex_count, 3), np.float32)
        else:
            check_output("out", out, (self.vertex_count, 3), np.dtype(np.float32))
        with self._scratches.borrow() as scratch:
            check(library.fb_evaluate(self._handle, scratch, values.ctypes.data, out.ctypes.data))
        return out

    def evaluate_batch(
        self,
        controls: ArrayLike,
        threads: int = 0,
        out: Optional[npt.NDArray[Any]] = None,
        *,
        normals: Optional[npt.NDArray[Any]] = None,
        tangents: Optional[npt.NDArray[Any]] = None,
        sockets: Optional[Floats] = None,
        channels: Optional[Floats] = None,
        bounds: Optional[Floats] = None,
        joints: Optional[Floats] = None,
        expected_errors: Optional[Floats] = None,
        outside: Optional[Indices] = None,
        baked_order: bool = False,
        regions: Optional[Sequence[Union[str, int]]] = None,
        meshes: Optional[Sequence[Union[str, int]]] = None,
        dtype: npt.DTypeLike = np.float32,
        lod: float = 0.0,
        displacements: bool = False,
        unskinned: bool = False,
        level_only: bool = False,
    ) -> npt.NDArray[Any]:
        """Many poses: (poses, controls) -> positions, (poses, vertices, 3), with the same bits as evaluate.

        threads: 0 is all cores. dtype: float32 or float16, of positions, normals and tangents. Outputs are contiguous
        arrays that are written: out, normals and tangents of the result's shape and dtype, unit normals and unit tangents
        (those need texture coordinates); sockets, (poses, sockets, 3, 4), frames; channels, (poses, channels); bounds,
        (poses, 2, 3), the least and the largest coordinates; joints, (poses, driven_joints, 3, 4), frames; expected_errors, (poses, 1 + error_regions); all float32;
        outside, (poses,), uint32, as of ExpectedError.
        baked_order: vertices in the order of vertex_order. regions: the names or indices of the regions whose networks
        run; the others keep their values at rest. meshes: names or indices of the meshes that are posed; vertices of the
        others are not written. lod: level of detail, 0 (the whole) to level_count - 1 or between two of them.
        displacements: from rest, in place of positions. unskinned: positions, normals and tangents before driven joints
        move the vertices, as displacements always are. level_only: only the vertices of the level that lod is rounded down
        to, which needs baked_order; results then have levels[...].vertices vertices."""
        values, kind = self._poses(controls), np.dtype(dtype)
        if kind not in (np.float32, np.float16):
            raise ValueError(f"dtype is {kind}, neither float32 nor float16")
        vertices = self._level_vertices(lod) if level_only else self.vertex_count
        shape = (len(values), vertices, 3)
        if out is None:
            # What of meshes that are not posed is not written stays 0.
            out = np.empty(shape, kind) if meshes is None else np.zeros(shape, kind)
        desc = library.filled(fb_batch_desc)
        if threads < 0:
            raise ValueError(f"{threads} threads")
        workers = min(threads or os.cpu_count() or 1, max(len(values), 1))
        assign(desc, threads=min(threads, workers))
        set_controls(desc, values)
        desc.pose_stride = desc.normal_pose_stride = desc.tangent_pose_stride = 3 * vertices
        desc.vertex_order, desc.format = int(baked_order), int(kind == np.float16)
        desc.lod, desc.displacements, desc.level_only = lod, int(displacements), int(level_only)
        desc.unskinned = int(unskinned)
        set_output(desc, "positions", out, shape, kind, "position_floats")
        set_output(desc, "normals", normals, shape, kind, "normal_numbers")
        set_output(desc, "tangents", tangents, shape, kind, "tangent_numbers")
        self._set_other_outputs(desc, sockets, channels, bounds, joints, expected_errors, outside)
        if regions is not None:
            desc.regions, desc.region_count = choice(regions, self.regions, "region")
        if meshes is not None:
            desc.meshes, desc.mesh_count = choice(meshes, [mesh.name for mesh in self.meshes], "mesh")
        with self._scratches.borrow(workers, several=len(values) > 1) as scratch:
            check(library.fb_evaluate_batch(self._handle, scratch, desc))
        return out

    def _set_other_outputs(
        self, desc: fb_batch_desc, sockets: Any, channels: Any, bounds: Any, joints: Any, errors: Any, outside: Any
    ) -> None:
        """The outputs of evaluate_batch whose format does not depend on its dtype."""
        poses: int = desc.poses
        for name, array, shape, count in (
            ("sockets", sockets, (len(self.sockets), 3, 4), "socket_floats"),
            ("channels", channels, (len(self.channels),), "channel_floats"),
            ("bounds", bounds, (2, 3), "bounds_floats"),
            ("joints", joints, (len(self.driven_joints), 3, 4), "joint_floats"),
            ("expected_errors", errors, (1 + len(self.error_regions),), "expected_error_floats"),
        ):
            set_output(desc, name, array, (poses, *shape), np.dtype(np.float32), count)
        set_output(desc, "outside", outside, (poses,), np.dtype(np.uint32))

    def coefficients(self, controls: Controls) -> Floats:
        """(controls,), or a dictionary as for pose() -> (coefficients,), float32: the weights of basis()'s columns."""
        values = self._one_pose(controls)
        coefficients = np.empty(self.coefficient_count, np.float32)
        with self._scratches.borrow() as scratch:
            check(library.fb_evaluate_coefficients(self._handle, scratch, values.ctypes.data, coefficients.ctypes.data))
        return coefficients

    def expected_error(self, controls: Controls) -> ExpectedError:
        """(controls,), or a dictionary as for pose() -> ExpectedError, for little of the time that evaluate() takes. (poses,
        controls) -> one of arrays with one row a pose. Fails if error_regions is empty."""
        if isinstance(controls, collections.abc.Mapping):
            controls = self.pose(controls)
        single = np.ndim(controls) == 1
        poses = self._poses(np.asarray(controls, np.float32)[None] if single else controls)
        errors = np.empty((len(poses), 1 + len(self.error_regions)), np.float32)
        outside = np.empty(len(poses), np.uint32)
        with self._scratches.borrow() as scratch:
            for pose in range(len(poses)):
                arrays = (poses[pose], errors[pose], outside[pose:])
                check(library.fb_expected_error(self._handle, scratch, *(array.ctypes.data for array in arrays)))
        if single:
            return ExpectedError(float(errors[0, 0]), errors[0, 1:], int(outside[0]))
        return ExpectedError(errors[:, 0], errors[:, 1:], outside)

    def jacobian(
        self,
        controls: Controls,
        points: Optional[ArrayLike] = None,
        chosen: Optional[Chosen] = None,
        *,
        vertex_weights: Optional[ArrayLike] = None,
        sockets: Sequence[Union[str, int]] = (),
        joints: Sequence[Union[str, int]] = (),
        lod: float = 0.0,
        downwards: Optional[Chosen] = None,
    ) -> Floats:
        """How points move with the controls: (controls,), or a dictionary as for pose() -> derivatives, (rows, chosen), float32,
        in units a unit of the control; rows are 3 a point, then 12 a frame of sockets and joints.

        points, vertex_weights, sockets, joints, lod: as of Solver; chosen, downwards: as of Solver.jacobian. It makes a Solver
        for this call: for many poses make one. Raises what these do."""
        with Solver(self, points, vertex_weights=vertex_weights, sockets=sockets, joints=joints, lod=lod) as solver:
            return solver.jacobian(controls, chosen, downwards=downwards)

    def solve(
        self,
        targets: ArrayLike,
        points: Optional[ArrayLike] = None,
        *,
        vertex_weights: Optional[ArrayLike] = None,
        lod: float = 0.0,
        **options: Any,
    ) -> Solution:
        """Finds controls for targets, (points, 3), in units. points, vertex_weights, lod: as of Solver, which it makes for this
        call: for many poses make one. options: those of Solver.solve. Raises what these do."""
        with Solver(self, points, vertex_weights=vertex_weights, lod=lod) as solver:
            return solver.solve(targets, **options)

    def basis(self) -> Iterator[Tuple[slice, Indices, Floats]]:
        """Yields the row blocks of the basis: (rows, columns, values). rows: a slice of the 3 x vertices coordinates in baked
        order; columns: the coefficients that displace them; values: (columns, rows), the displacements for one unit."""
        for index in range(library.fb_row_block_count(self._handle)):
            block = library.filled(fb_row_block)
            check(library.fb_row_block_at(self._handle, index, block))
            columns = np.empty(block.column_count, np.uint32)
            values = np.empty((block.column_count, block.row_count), np.float32)
            check(library.fb_row_block_values(self._handle, index, columns.ctypes.data, values.ctypes.data))
            yield slice(block.first_row, block.first_row + block.row_count), columns, values

    def _found(self, find: Any, name: str) -> int:
        index = ctypes.c_uint32()
        check(find(self._handle, name.encode(), byref(index)))
        return index.value

    def _level_vertices(self, lod: float) -> int:
        """Vertices of the level that lod is rounded down to."""
        return self.levels[min(max(int(lod), 0), self.level_count - 1)].vertices

    def _one_pose(self, controls: Controls) -> Floats:
        if isinstance(controls, collections.abc.Mapping):
            return self.pose(controls)
        values = np.ascontiguousarray(controls, np.float32)
        if values.shape != (self.control_count,):
            raise ValueError(f"controls have shape {values.shape}, not {(self.control_count,)}")
        return values

    def _poses(self, controls: ArrayLike) -> Floats:
        values = np.ascontiguousarray(controls, np.float32)
        if values.ndim != 2 or values.shape[1] != self.control_count:
            raise ValueError(f"controls have shape {values.shape}, not {('poses', self.control_count)}")
        return values


def set_controls(desc: fb_batch_desc, values: Floats) -> None:
    """Has a batch pose these controls, (poses, controls), which the caller keeps."""
    desc.poses, desc.control_floats = len(values), values.size
    desc.controls = values.ctypes.data_as(POINTER(c_float))


def set_output(
    desc: fb_batch_desc, field: str, array: Any, shape: Tuple[int, ...], kind: "np.dtype[Any]", count: str = ""
) -> None:
    """Has a field of a batch point to an array, if there is one, after checking it; count: the field of its size."""
    if array is None:
        return
    check_output("out" if field == "positions" else field, array, shape, kind)
    setattr(desc, field, array.ctypes.data)
    if count:
        setattr(desc, count, array.size)
