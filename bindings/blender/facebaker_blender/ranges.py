"""The range of a control: what limits it, what the animation uses, and what is assumed where nothing says. Without Blender."""

from __future__ import annotations

import math
from typing import Optional, Tuple

# Assumed where neither a limit nor animation says: for locations this share of the bone's length to either side, for
# rotations radians, for scales from 1 / 1.25 to 1.25. Rigs of faces give their small bones lengths of the size they work
# at; the jaw's and the head's are longer than they travel, so a share of the meshes' diagonal is the most there is.
LOCATION_SHARE = 0.5
LOCATION_MOST = 0.03
ROTATION = math.radians(20)
SCALE = 1.25
MARGIN = 0.1  # what animation uses is widened by this share of it, for shots that are still to come

Range = Tuple[Optional[float], Optional[float]]  # None: not limited on that side


def assumed_range(kind: str, bone_length: float, diagonal: float) -> Tuple[float, float]:
    """For "location" (in the scene's units, like the bone's length and the meshes' diagonal), "rotation" (radians) or
    "scale"."""
    if kind == "location":
        reach = min(LOCATION_SHARE * bone_length, LOCATION_MOST * diagonal)
        return -reach, reach
    return (-ROTATION, ROTATION) if kind == "rotation" else (1 / SCALE, SCALE)


def widened(used: Tuple[float, float], rest: float) -> Tuple[float, float]:
    """What animation uses, with rest in it and MARGIN of its size around it where it leaves rest."""
    low, high = min(used[0], rest), max(used[1], rest)
    margin = MARGIN * (high - low)
    return low - margin if low < rest else low, high + margin if high > rest else high


def control_range(
    limits: Range, used: Optional[Tuple[float, float]], assumed: Tuple[float, float], rest: float
) -> Tuple[float, float, float]:
    """Minimum, maximum and rest of a control. A side that is limited ends at its limit. Otherwise it ends where the
    animation, widened, does, and no nearer than what is assumed. Rest is moved into a range that leaves it out. The
    range is empty (minimum == maximum) for a channel that its limits hold in place."""
    wide = widened(used, rest) if used else (rest, rest)
    low = min(assumed[0], wide[0]) if limits[0] is None else limits[0]
    high = max(assumed[1], wide[1]) if limits[1] is None else limits[1]
    if low >= high:
        return (low, low, low) if limits != (None, None) else (rest, rest, rest)
    return low, high, min(max(rest, low), high)


def tighter(one: Range, other: Range) -> Range:
    """Both limits at once."""
    lows = [low for low in (one[0], other[0]) if low is not None]
    highs = [high for high in (one[1], other[1]) if high is not None]
    return max(lows) if lows else None, min(highs) if highs else None
