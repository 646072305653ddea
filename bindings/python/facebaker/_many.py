"""Poses of different faces in one call."""

from __future__ import annotations

import contextlib
import ctypes
import os
from ctypes import POINTER, c_void_p
from typing import Any, Dict, List, Optional, Sequence, Tuple, Type

import numpy as np
import numpy.typing as npt

from ._arrays import ArrayLike, Floats, check_output
from ._face import Face
from ._interop import fb_batch_desc, fb_many_desc, fb_many_item
from ._library import assign, check, library

FLOAT = np.dtype(np.float32)


def _columns(struct: Type[ctypes.Structure], **formats: Any) -> "np.dtype[Any]":
    """Some fields of a struct as columns of an array of these structs: filled in one step each, they take a third of the
    time that ctypes takes."""
    offsets = [getattr(struct, name).offset for name in formats]
    fields: Any = {"names": list(formats), "formats": list(formats.values()), "offsets": offsets}
    fields["itemsize"] = ctypes.sizeof(struct)
    made: "np.dtype[Any]" = np.dtype(fields)
    return made


BATCHES = _columns(
    fb_batch_desc,
    poses=np.uint64,
    controls=np.uintp,
    control_floats=np.uint64,
    pose_stride=np.uint64,
    normal_pose_stride=np.uint64,
    lod=np.float32,
    positions=np.uintp,
    position_floats=np.uint64,
    normals=np.uintp,
    normal_numbers=np.uint64,
)
ITEMS = _columns(fb_many_item, model=np.uintp, scratch=np.uintp, batch=np.uintp)


def evaluate_many(
    items: Sequence[Tuple[Face, ArrayLike]],
    threads: int = 0,
    out: Optional[Sequence[Floats]] = None,
    *,
    normals: Optional[Sequence[Optional[Floats]]] = None,
    lods: Optional[Sequence[float]] = None,
    level_only: bool = False,
) -> List[Floats]:
    """Poses many faces: pairs of a face and its controls, (poses, controls) -> the positions of each, (poses, vertices, 3),
    float32, with the same bits as Face.evaluate_batch. A face may come several times: its items share the working memory
    of the threads, and need none of their own but their outputs.

    threads: 0 is all cores. Threads take items in their order: those that take longest are best first. out, normals:
    contiguous float32 arrays of the results' shapes that are written, one an item; None among normals: none of that one.
    lods: a level of detail for each item, as of Face.evaluate_batch; level_only: vertices in baked order, and only those of
    the level that each is rounded down to. Raises what Face.evaluate_batch does, with a message that begins
    with "item I: ", for the first item that fails; where it is a control that is NaN, the others are posed. Thread-safe.
    """
    if threads < 0:
        raise ValueError(f"{threads} threads")
    for name, given in ("out", out), ("normals", normals), ("lods", lods):
        if given is not None and len(given) != len(items):
            raise ValueError(f"{name}: {len(given)} for {len(items)} items")
    if len(items) == 0:
        return []
    rows: List[Tuple[Any, ...]] = []  # of batches
    kept, results = [], []  # controls that they point to; positions
    several: Dict[Face, bool] = {}  # of each face, whether an item has several poses
    for index, (face, controls) in enumerate(items):
        lod = 0 if lods is None else lods[index]
        try:
            values = face._poses(controls)
            vertices = face._level_vertices(lod) if level_only else face.vertex_count
            shape = (len(values), vertices, 3)
            positions = np.empty(shape, FLOAT) if out is None else out[index]
            written = _output("out", positions, shape)
            shaded = _output("normals", None if normals is None else normals[index], shape)
        except ValueError as error:
            raise ValueError(f"item {index}: {error}") from None
        several[face] = several.get(face, False) or len(values) > 1
        stride = 3 * vertices
        rows.append((len(values), values.ctypes.data, values.size, stride, stride, lod, *written, *shaded))
        kept.append(values)
        results.append(positions)
    _evaluate([face._handle.value for face, _ in items], _batches(rows, level_only), threads, several)
    return results


def _output(name: str, array: Optional[Floats], shape: Tuple[int, ...]) -> Tuple[int, int]:
    """Where an output is written, and its size."""
    if array is None:
        return 0, 0
    check_output(name, array, shape, FLOAT)
    return array.ctypes.data, array.size


def _batches(rows: List[Tuple[Any, ...]], level_only: bool) -> npt.NDArray[Any]:
    """An fb_batch_desc of each row."""
    filled = library.filled(fb_batch_desc)
    filled.vertex_order = filled.level_only = int(level_only)
    batches = np.frombuffer(bytearray(bytes(filled) * len(rows)), BATCHES)
    for name, column in zip(BATCHES.names or (), zip(*rows)):
        batches[name] = column
    return batches


def _evaluate(models: List[Any], batches: npt.NDArray[Any], threads: int, several: Dict[Face, bool]) -> None:
    """With a scratch of each face, a worker a thread."""
    count = len(models)
    workers = min(threads or os.cpu_count() or 1, count)
    structs = np.zeros(count, ITEMS)
    structs["model"] = models
    structs["batch"] = batches.ctypes.data + BATCHES.itemsize * np.arange(count, dtype=np.uintp)
    desc = library.filled(fb_many_desc)
    assign(desc, threads=min(threads, workers), item_count=count, scratch_count=len(several))
    desc.items = structs.ctypes.data_as(POINTER(fb_many_item))
    with contextlib.ExitStack() as borrowed:
        handles = [borrowed.enter_context(f._scratches.borrow(workers, s)) for f, s in several.items()]
        desc.scratches = (c_void_p * len(handles))(*handles)
        check(library.fb_evaluate_many(desc, None))
