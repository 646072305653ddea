"""From a face back to its controls: derivatives of points by controls, and controls for points. facebaker_solve.h says what
everything means."""

from __future__ import annotations

import contextlib
import weakref
from ctypes import POINTER, Structure, byref, c_float, c_uint8, c_uint32, c_void_p
from typing import TYPE_CHECKING, Any, Iterator, List, Literal, NamedTuple, Optional, Sequence, Tuple, Union, overload

import numpy as np
import numpy.typing as npt

from . import _interop as abi
from ._arrays import ArrayLike, Controls, Floats, Indices, check_output, floats, indices
from ._choices import Chosen, choice, control_indices, control_mask
from ._clip_solving import FRAME, ClipSweep, ClipTargets
from ._library import assign, check, library
from ._solutions import ClipSolution, Solution, clip_solution

if TYPE_CHECKING:
    from ._face import Face

FLOATS = np.dtype(np.float32)
# The C type of the elements of an array, by its NumPy type.
C_TYPES: "dict[Any, Any]" = {FLOATS: c_float, np.dtype(np.uint32): c_uint32, np.dtype(np.uint8): c_uint8}


class SparseColumns(NamedTuple):
    """Derivatives by columns, what scipy.sparse.csc_matrix takes: data, (entries,), float32; indices, (entries,), int32, the
    row of each, ascending in a column; indptr, (chosen + 1,), int64, where the entries of each column begin."""

    data: Floats
    indices: npt.NDArray[np.int32]
    indptr: npt.NDArray[np.int64]


class _Memory:
    """An fb_solver, freed with this object; it keeps the model itself."""

    def __init__(self, model: c_void_p, desc: abi.fb_solver_desc) -> None:
        self.handle = c_void_p()
        check(library.fb_solver_create(model, desc, byref(self.handle)))
        weakref.finalize(self, library.fb_solver_destroy, self.handle)


class Solver:
    """Follows points, sockets and joints of a face, for derivatives and for solving many poses.

    face: whose. point_count, pair_count: of what it follows. row_count: the numbers that it follows, 3 a point, then 12 a
    frame, of sockets and then of joints. Any number of threads may use one solver at once: each call at a time has working
    memory of its own, which is made when it is first needed, in some milliseconds, or a tenth of a second for all vertices
    of a large face, and kept. It can be pickled, and is a context manager, which closes it."""

    def __init__(
        self,
        face: Face,
        points: Optional[ArrayLike] = None,
        *,
        vertex_weights: Optional[ArrayLike] = None,
        pairs: Optional[ArrayLike] = None,
        sockets: Sequence[Union[str, int]] = (),
        joints: Sequence[Union[str, int]] = (),
        lod: float = 0.0,
    ) -> None:
        """points: (points,), each the index of a vertex, or (points, 3), each a sum of three vertices times
        vertex_weights, (points, 3), such as barycentric coordinates; None: every vertex is a point. pairs: (pairs, 2),
        indices of points, whose distance may have a target. sockets, joints: names or indices of sockets and of driven
        joints, whose frames are followed. lod: level of detail, as evaluate_batch has it. Raises InvalidArgumentError on
        vertices, points, sockets and joints that there are not, and on weights that are not finite."""
        self.face = face
        # Copies, as memory for more threads is made of them later.
        points, vertex_weights, pairs = (
            None if array is None else np.array(array) for array in (points, vertex_weights, pairs)
        )
        self._made_of = (points, vertex_weights, pairs, tuple(sockets), tuple(joints), lod)
        self._desc = desc = library.filled(abi.fb_solver_desc)
        vertices, weights = _read_points(points, vertex_weights)
        if vertices is not None:
            assign(desc, point_count=len(vertices))
            _point(desc, "point_vertices", vertices)
            if weights is not None:
                _point(desc, "point_weights", weights)
        if pairs is not None:
            ends = indices(pairs, "pairs")
            if ends.ndim != 2 or ends.shape[1] != 2:
                raise ValueError(f"pairs: shape {ends.shape}, not (any, 2)")
            assign(desc, pair_count=len(ends))
            _point(desc, "pairs", ends)
        desc.sockets, desc.socket_count = choice(sockets, [socket.name for socket in face.sockets], "socket")
        desc.joints, desc.joint_count = choice(joints, [joint.name for joint in face.driven_joints], "driven joint")
        desc.lod = lod
        self._free: List[_Memory] = [_Memory(face._handle, desc)]
        self._entries = 0  # that the last sparse output had
        self.point_count: int = library.fb_solver_point_count(self._free[0].handle)
        self.row_count: int = library.fb_solver_row_count(self._free[0].handle)
        self.pair_count: int = desc.pair_count
        self.frame_count: int = desc.socket_count + desc.joint_count

    def __repr__(self) -> str:
        counts = f"{self.point_count} points, {self.pair_count} pairs, {self.frame_count} frames"
        return f"<facebaker.Solver of {self.face.name!r}: {counts}>"

    def __reduce__(self) -> Tuple[Any, ...]:
        return _remade, (self.face, *self._made_of)

    def __enter__(self) -> Solver:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        """Frees its memory but for what calls are using, which is freed after these. A further call makes it anew.
        Nobody needs to call this: a solver that nothing refers to is freed as well."""
        self._free = []

    # Derivatives

    @overload
    def jacobian(
        self,
        controls: Controls,
        chosen: Optional[Chosen] = None,
        *,
        downwards: Optional[Chosen] = None,
        sparse: Literal[False] = False,
        out: Optional[Floats] = None,
        values: Optional[Floats] = None,
    ) -> Floats: ...

    @overload
    def jacobian(
        self,
        controls: Controls,
        chosen: Optional[Chosen] = None,
        *,
        downwards: Optional[Chosen] = None,
        sparse: Literal[True],
        values: Optional[Floats] = None,
    ) -> SparseColumns: ...

    def jacobian(
        self,
        controls: Controls,
        chosen: Optional[Chosen] = None,
        *,
        downwards: Optional[Chosen] = None,
        sparse: bool = False,
        out: Optional[Floats] = None,
        values: Optional[Floats] = None,
    ) -> Union[Floats, SparseColumns]:
        """How what is followed moves with the controls: (controls,), or a dictionary as for Face.pose() -> derivatives,
        (rows, chosen), float32, in units a unit of the control.

        chosen: names of controls and of control groups, indices, or a mask, (controls,); columns come in this order, as of
        Face.find_controls; None: all controls. downwards: controls, likewise, of which, where the pose bends, as at rest or
        where a corrective begins, the derivative is that of moving them down; of others it is that of moving up, but down at
        their maximum. sparse: returns SparseColumns. out: a contiguous float32 array of the result's shape that is written.
        values: one of (rows,), to which the numbers are written that are followed. Raises NotFiniteError, naming the
        control, on NaN, and ValueError on what is not to be chosen."""
        pose = self.face._one_pose(controls)
        columns = np.arange(self.face.control_count, dtype=np.uint32)
        if chosen is not None:
            columns = control_indices(self.face, chosen, "chosen")
        ascending = np.sort(columns)
        desc = library.filled(abi.fb_jacobian_desc)
        assign(desc, chosen_count=len(ascending))
        _point(desc, "controls", pose)
        _point(desc, "chosen", ascending)
        if downwards is not None:
            _point(desc, "downwards", control_mask(self.face, downwards, "downwards"))
        if values is not None:
            check_output("values", values, (self.row_count,), FLOATS)
            desc.values = values.ctypes.data
        # Places in `ascending`, where columns are to come in another order.
        order = None if np.array_equal(columns, ascending) else np.searchsorted(ascending, columns)
        if sparse:
            if out is not None:
                raise ValueError("out is for derivatives that are not sparse")
            found = self._run_sparse(desc)
            return found if order is None else _reordered(found, order)
        return self._run_dense(desc, order, out)

    def _run_dense(
        self, desc: abi.fb_jacobian_desc, order: Optional[npt.NDArray[np.intp]], out: Optional[Floats]
    ) -> Floats:
        shape = (self.row_count, int(desc.chosen_count))
        if out is not None:
            check_output("out", out, shape, FLOATS)
        dense = np.empty(shape, np.float32) if out is None or order is not None else out
        if dense.size > 0:
            desc.derivatives, desc.derivative_floats = dense.ctypes.data, dense.size
        with self._borrow() as handle:
            check(library.fb_jacobian(handle, desc))
        if order is None:
            return dense
        # mode: with the default, "raise", a copy of out would be made.
        return np.take(dense, order, 1, out=out, mode="clip")

    def _run_sparse(self, desc: abi.fb_jacobian_desc) -> SparseColumns:
        starts = np.empty(desc.chosen_count + 1, np.uint64)
        desc.column_starts = starts.ctypes.data
        room = min(self._entries, self.row_count * desc.chosen_count)
        with self._borrow() as handle:
            while True:
                rows, values = np.empty(room, np.uint32), np.empty(room, np.float32)
                desc.column_rows = rows.ctypes.data if room else None
                desc.column_values, desc.column_entries = values.ctypes.data, room
                status = library.fb_jacobian(handle, desc)
                if status != abi.FB_ERROR_LIMIT:
                    check(status)
                count = int(starts[-1])
                if count <= room:
                    break
                room = count
        self._entries = count + count // 8  # the next pose has about as many
        return SparseColumns(values[:count], rows[:count].view(np.int32), starts.view(np.int64))

    # Solving

    def solve(
        self,
        targets: Optional[ArrayLike] = None,
        *,
        distances: Optional[ArrayLike] = None,
        frames: Optional[ArrayLike] = None,
        weights: Optional[ArrayLike] = None,
        distance_weights: Optional[ArrayLike] = None,
        frame_weights: Optional[ArrayLike] = None,
        relative: bool = False,
        to_face: Optional[ArrayLike] = None,
        find_motion: bool = False,
        motion: Optional[ArrayLike] = None,
        start: Optional[Controls] = None,
        near: Optional[Controls] = None,
        before: Optional[Controls] = None,
        movable: Optional[Chosen] = None,
        locked: Optional[Chosen] = None,
        noise: Optional[float] = None,
        nearness: float = 0.1,
        sparsity: float = 0.1,
        smoothness: float = 0.0,
        symmetry: float = 0.0,
        tolerance: float = 0.01,
        max_iterations: int = 20,
        decided: bool = False,
    ) -> Solution:
        """Finds controls for targets, and how near they come.

        targets: (points, 3), where points should be; with relative, how far from where they are at rest. distances: (pairs,),
        in units. frames: (frames, 3, 4), of sockets and then of joints. A target that has a NaN was not measured, and does not
        count. weights: (points,), distance_weights: (pairs,) and frame_weights: (frames,), 0 or more; None: 1. to_face: (3, 4),
        takes targets of points and frames to the space and units of the face; turns, mirrors and scales alike in all
        directions. find_motion: where the head is, is found too, from motion, (3, 4), or the identity.

        start: controls, (controls,) or a dictionary, where it starts; None: before, or else rest. near: what nearness draws
        to; None: rest. before: of the pose before, for smoothness. movable: the controls that may move, by names of controls
        and of control groups, indices or a mask, (controls,); None: all. locked: those that may not, likewise; they stay where
        they start. noise: what a point's target is off by itself, in units; None: half a millimetre, or a thousandth of
        diagonal where the unit is not known. nearness, sparsity, smoothness, symmetry: what is added to the sum of
        (difference / noise)^2 / 2, with controls in units of their ranges: nearness x (control - near)^2 / 2, sparsity x
        |control - rest|, smoothness x (control - before)^2 / 2, symmetry x (control - its mirror's)^2 / 2. tolerance: it ends
        where an iteration lowers the sum by less than this share, or after max_iterations. decided: finds Solution.decided,
        which takes some time.

        Raises ValueError on arrays of wrong shapes and names that there are not, NotFiniteError on infinite targets and NaN in
        controls, InvalidArgumentError on weights and preferences that are negative or not finite, targets farther than 10^6
        of diagonal, and a to_face that does not scale alike in all directions."""
        if motion is not None and not find_motion:
            raise ValueError("motion is where find_motion starts, which is off")
        desc = library.filled(abi.fb_solve_desc)
        points, pairs, count = self.point_count, self.pair_count, self.frame_count
        for field, array, shape, name in (
            ("points", targets, (points, 3), "targets"),
            ("distances", distances, (pairs,), "distances"),
            ("frames", frames, (count, *FRAME), "frames"),
            ("point_weights", weights, (points,), "weights"),
            ("distance_weights", distance_weights, (pairs,), "distance_weights"),
            ("frame_weights", frame_weights, (count,), "frame_weights"),
        ):
            if array is not None:
                _point(desc, field, floats(array, shape, name))
        for field, controls in ("near_controls", near), ("before", before):
            if controls is not None:
                _point(desc, field, self.face._one_pose(controls))
        if movable is not None or locked is not None:
            _point(desc, "movable", self._moving(movable, locked))
        if to_face is not None:
            desc.to_face[:] = floats(to_face, FRAME, "to_face").ravel().tolist()
        if noise is not None and not noise > 0:
            raise ValueError(f"noise is {noise}, and has to be above 0")
        desc.noise, desc.nearness, desc.sparsity = noise or 0, nearness, sparsity
        desc.smoothness, desc.symmetry, desc.tolerance = smoothness, symmetry, tolerance
        assign(desc, max_iterations=max_iterations, relative=int(relative), find_motion=int(find_motion))
        first = start if start is not None else before if before is not None else self.face.rest_controls
        found = np.array(self.face._one_pose(first))
        frame = None
        if find_motion:
            frame = np.zeros(FRAME, np.float32) if motion is None else np.array(floats(motion, FRAME, "motion"))
        return self._run(desc, found, frame, decided)

    def _run(self, desc: abi.fb_solve_desc, controls: Floats, motion: Optional[Floats], find_decided: bool) -> Solution:
        shares = np.empty(len(controls), np.float32) if find_decided else None
        differences = np.empty(self.point_count, np.float32)
        desc.controls, desc.point_differences = controls.ctypes.data, differences.ctypes.data
        desc.motion = None if motion is None else motion.ctypes.data
        desc.decided = None if shares is None else shares.ctypes.data
        result = library.filled(abi.fb_solve_result)
        with self._borrow() as handle:
            check(library.fb_solve(handle, desc, result))
        return Solution(
            controls=controls,
            motion=motion,
            rms_difference=result.rms_difference,
            max_difference=result.max_difference,
            worst_point=result.worst_point if result.point_count else None,
            point_count=result.point_count,
            point_differences=differences,
            iterations=result.iterations,
            converged=bool(result.converged),
            objective=result.objective,
            decided=shares,
        )

    def solve_clip(
        self,
        targets: Optional[ArrayLike] = None,
        *,
        distances: Optional[ArrayLike] = None,
        frames: Optional[ArrayLike] = None,
        weights: Optional[ArrayLike] = None,
        start: Optional[Controls] = None,
        before: Optional[Controls] = None,
        motion: Optional[ArrayLike] = None,
        movable: Optional[Chosen] = None,
        locked: Optional[Chosen] = None,
        smoothness: float = 0.0,
        backwards: bool = False,
        **options: Any,
    ) -> ClipSolution:
        """Finds controls for the poses of a clip, one after the other, each from that before it.

        targets: (poses, points, 3). distances: (poses, pairs). frames: (poses, frames, 3, 4). weights: (points,), or (poses,
        points). start, motion: where the first pose starts. before: what smoothness holds the first pose to; None: nothing.
        backwards: with smoothness, goes through the clip once more from its end, each pose between its two neighbours, as
        otherwise it lags behind the motion. The controls are those of the command `facebaker solve` for these targets and
        options. options: the others of solve(), for all poses, with 0.001 as tolerance and 40 as max_iterations by default.
        Raises what solve() does, with a message that begins with "pose I: " where the library refuses it."""
        options.setdefault("tolerance", 1e-3)
        options.setdefault("max_iterations", 40)
        if movable is not None or locked is not None:
            options["movable"] = self._moving(movable, locked).astype(np.bool_)
        sweep = ClipSweep(self, ClipTargets(self, targets, distances, frames, weights), smoothness, before, options)
        sweep.go_forwards(start, motion)
        if backwards and smoothness > 0:
            sweep.go_backwards()
        return clip_solution(sweep.found, self.face.control_count, self.point_count)

    def _moving(self, movable: Optional[Chosen], locked: Optional[Chosen]) -> npt.NDArray[np.uint8]:
        mask = np.ones(self.face.control_count, np.uint8)
        if movable is not None:
            mask = control_mask(self.face, movable, "movable")
        if locked is not None:
            mask[control_indices(self.face, locked, "locked")] = 0
        return mask

    @contextlib.contextmanager
    def _borrow(self) -> Iterator[c_void_p]:
        """Working memory, the caller's within the context."""
        model = self.face._handle  # refuses a face that is closed
        try:
            memory = self._free.pop()
        except IndexError:
            memory = _Memory(model, self._desc)
        try:
            yield memory.handle
        finally:
            self._free.append(memory)


def _point(struct: Structure, field: str, array: npt.NDArray[Any]) -> None:
    """Has a field point to an array, which the struct keeps alive."""
    kept = array if array.size else np.zeros(1, array.dtype)  # an address for an array without elements, too
    setattr(struct, f"_{field}_array", kept)
    setattr(struct, field, kept.ctypes.data_as(POINTER(C_TYPES[array.dtype])))


def _read_points(points: Any, weights: Any) -> Tuple[Optional[Indices], Optional[Floats]]:
    """Vertices of points, (points, 3), and their weights."""
    if points is None:
        if weights is not None:
            raise ValueError("vertex_weights are of points, which are not given")
        return None, None
    vertices = indices(points, "points")
    if weights is not None:
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise ValueError(f"points: shape {vertices.shape}, not (any, 3), as with vertex_weights")
        return vertices, floats(weights, vertices.shape, "vertex_weights")
    if vertices.ndim != 1:
        raise ValueError(f"points: shape {vertices.shape}, not (any,), as without vertex_weights")
    return np.repeat(vertices[:, None], 3, 1), None


def _reordered(columns: SparseColumns, order: npt.NDArray[np.intp]) -> SparseColumns:
    """Column k becomes that of order[k]."""
    parts = [slice(columns.indptr[column], columns.indptr[column + 1]) for column in order.tolist()]
    indptr = np.zeros(len(parts) + 1, np.int64)
    np.cumsum(np.diff(columns.indptr)[order], out=indptr[1:])
    data, rows = (np.concatenate([array[part] for part in parts]) for array in columns[:2])
    return SparseColumns(data, rows, indptr)


def _remade(face: Face, points: Any, weights: Any, pairs: Any, sockets: Any, joints: Any, lod: float) -> Solver:
    return Solver(face, points, vertex_weights=weights, pairs=pairs, sockets=sockets, joints=joints, lod=lod)
