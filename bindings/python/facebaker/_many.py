"""Poses of different faces in one call."""

from __future__ import annotations

import contextlib
import ctypes
from ctypes import POINTER, pointer
from typing import List, Optional, Sequence, Tuple

import numpy as np

from ._arrays import ArrayLike, Floats
from ._face import Face, set_controls, set_output
from ._interop import fb_batch_desc, fb_many_desc, fb_many_item
from ._library import assign, check, library


def evaluate_many(
    items: Sequence[Tuple[Face, ArrayLike]], threads: int = 0, out: Optional[Sequence[Floats]] = None
) -> List[Floats]:
    """Poses many faces: pairs of a face and its controls, (poses, controls) -> the positions of each, (poses, vertices, 3),
    float32, with the same bits as Face.evaluate_batch. A face may come several times.

    threads: 0 is all cores. Threads take items in their order: those that take longest are best first. out: contiguous
    float32 arrays of the results' shapes that are written. Raises what Face.evaluate_batch does, with a message that begins
    with "item I: ", for the first item that fails; where it is a control that is NaN, the others are posed. Thread-safe."""
    if threads < 0:
        raise ValueError(f"{threads} threads")
    if out is not None and len(out) != len(items):
        raise ValueError(f"out has {len(out)} arrays for {len(items)} items")
    structs = (fb_many_item * max(len(items), 1))()
    kept, results = [], []  # what the structs point to
    with contextlib.ExitStack() as scratches:
        for index, (face, controls) in enumerate(items):
            batch = library.filled(fb_batch_desc)
            try:
                values = face._poses(controls)
                shape = (len(values), face.vertex_count, 3)
                positions = np.empty(shape, np.float32) if out is None else out[index]
                set_controls(batch, values)
                set_output(batch, "positions", positions, shape, np.dtype(np.float32), "position_floats")
            except ValueError as error:
                raise ValueError(f"item {index}: {error}") from None
            scratch = scratches.enter_context(face._scratches.borrow(1))
            structs[index] = fb_many_item(face._handle, scratch, pointer(batch))
            kept.append((values, batch))
            results.append(positions)
        desc = library.filled(fb_many_desc)
        assign(desc, threads=threads, item_count=len(items))
        desc.items = ctypes.cast(structs, POINTER(fb_many_item))
        check(library.fb_evaluate_many(desc, None))
    return results
