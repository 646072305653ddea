"""What a caller chose by names, groups, indices or a mask, as indices."""

from __future__ import annotations

import ctypes
import difflib
from typing import TYPE_CHECKING, Any, List, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._arrays import Indices
from ._errors import NotFoundError

if TYPE_CHECKING:
    from ._face import Face

# One name; names and indices; a mask.
Chosen = Union[str, Sequence[Union[str, int]], npt.NDArray[Any]]


def index_of(name: str, names: Sequence[str], what: str) -> int:
    """Raises ValueError, with the closest name there is."""
    if name in names:
        return list(names).index(name)
    close = difflib.get_close_matches(name, names, 1, 0)
    hint = f'; the closest is "{close[0]}"' if close else "; there are none"
    raise ValueError(f'there is no {what} "{name}"{hint}')


def choice(chosen: Sequence[Union[str, int]], names: Sequence[str], what: str) -> Tuple[Any, int]:
    """Indices of names, for the library; a list of none is one, too."""
    indices = [index_of(item, names, what) if isinstance(item, str) else item for item in chosen]
    return (ctypes.c_uint32 * max(len(indices), 1))(*indices), len(indices)


def control_indices(face: Face, chosen: Chosen, what: str) -> Indices:
    """Controls in the order in which they are chosen, each once. chosen: names of controls as Face.find takes them, names
    of control groups and indices, or one name; or a mask, (controls,), of bool. What is the name of a control and of a
    group is both. Raises ValueError on what there is not."""
    if isinstance(chosen, str):
        chosen = [chosen]
    given = np.asarray(chosen, object) if isinstance(chosen, (list, tuple)) else np.asarray(chosen)
    if given.ndim != 1:
        raise ValueError(f"{what}: {given.ndim} dimensions, not one")
    items = given.tolist()
    if len(items) > 0 and all(isinstance(item, (bool, np.bool_)) for item in items):
        if len(items) != face.control_count:
            raise ValueError(f"{what}: a mask of {len(items)} for {face.control_count} controls")
        return np.flatnonzero(items).astype(np.uint32)
    found: List[int] = []
    for item in items:
        if isinstance(item, str):
            found += _controls_named(face, item, what)
        elif isinstance(item, (int, np.integer)) and not isinstance(item, bool) and 0 <= item < face.control_count:
            found.append(int(item))
        else:
            raise ValueError(f"{what}: {item!r} is no name, and no index of the {face.control_count} controls")
    return np.array(list(dict.fromkeys(found)), np.uint32)


def control_mask(face: Face, chosen: Chosen, what: str) -> npt.NDArray[np.uint8]:
    """The same as (controls,), 1 where one is chosen."""
    mask = np.zeros(face.control_count, np.uint8)
    mask[control_indices(face, chosen, what)] = 1
    return mask


def _controls_named(face: Face, name: str, what: str) -> List[int]:
    found = [index for index, control in enumerate(face.controls) if name and name in (control.name, control.group)]
    if found:
        return found
    try:
        return [face.find(name)]  # by its other names
    except NotFoundError:
        groups = {control.group: None for control in face.controls if control.group}
    try:
        return [index_of(name, [*face.names, *groups], "control or control group")]
    except ValueError as error:
        raise ValueError(f"{what}: {error}") from None
