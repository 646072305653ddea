"""Types of arrays, and what is checked of those that come from outside."""

from __future__ import annotations

from typing import Any, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]
Indices = npt.NDArray[np.uint32]
ArrayLike = npt.ArrayLike
Controls = Union[ArrayLike, Mapping[str, float]]  # values, or a dictionary from names to them


def floats(values: ArrayLike, shape: Sequence[Optional[int]], what: str) -> Floats:
    """A contiguous float32 array, without a copy if `values` is one. Raises ValueError unless it has the shape, in which
    None is any length."""
    array = np.ascontiguousarray(values, np.float32)
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape)):
        wanted = ", ".join("any" if length is None else str(length) for length in shape)
        raise ValueError(f"{what}: shape {array.shape}, not ({wanted})")
    return array


def indices(values: ArrayLike, what: str) -> Indices:
    """A contiguous uint32 array of any shape. Raises ValueError on what is no whole number from 0 to 2^32 - 1."""
    array = np.asarray(values)
    if array.size == 0:
        return np.zeros(array.shape, np.uint32)
    if not np.issubdtype(array.dtype, np.integer) or array.min() < 0 or array.max() > 0xFFFFFFFF:
        raise ValueError(f"{what}: not all are whole numbers from 0 to 4294967295")
    return np.ascontiguousarray(array, np.uint32)


def check_output(name: str, array: npt.NDArray[Any], shape: Tuple[int, ...], kind: "np.dtype[Any]") -> None:
    """Raises ValueError unless it can be written to as it is."""
    flags = array.flags
    if array.shape != shape or array.dtype != kind or not flags.c_contiguous or not flags.writeable:
        raise ValueError(f"{name} must be a writable contiguous {kind} array of shape {shape}")


def polygon_lists(polygons: Any, what: str) -> Tuple[Indices, Indices]:
    """Sizes of polygons, and all their corners one after the other, of (polygons, corners) with -1 behind the last corner
    of those that have fewer, or of a sequence of sequences."""
    if not isinstance(polygons, np.ndarray):
        rows = [list(polygon) for polygon in polygons]
        width = max(map(len, rows), default=0)
        polygons = np.array([row + [-1] * (width - len(row)) for row in rows], np.int64).reshape(len(rows), width)
    if polygons.ndim != 2:
        raise ValueError(f"{what}: shape {polygons.shape}, not (polygons, corners)")
    used = polygons >= 0
    if not (used[:, :-1] | ~used[:, 1:]).all():
        raise ValueError(f"{what}: polygon {int((~used[:, :-1] & used[:, 1:]).any(1).argmax())} goes on after a -1")
    return used.sum(1).astype(np.uint32), indices(polygons[used], what)


def padded_polygons(sizes: Indices, corners: Indices) -> npt.NDArray[np.int32]:
    """The other way round: (polygons, corners), int32, with -1 behind the last corner."""
    used = np.arange(int(sizes.max(initial=3)))[None, :] < sizes[:, None]
    polygons = np.full(used.shape, -1, np.int32)
    polygons[used] = corners
    return polygons


def fan_corners(sizes: Indices) -> npt.NDArray[Any]:
    """(triangles, 3): every polygon as a fan around its first corner, as indices into the list of all corners."""
    counts = np.maximum(sizes.astype(np.int64) - 2, 0)
    first = np.repeat(np.cumsum(sizes, dtype=np.int64) - sizes, counts)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    corners: npt.NDArray[Any] = np.stack([first, first + step + 1, first + step + 2], 1)
    return corners.astype(np.uint32)
