"""Distances as colours. Without Blender."""

from __future__ import annotations

from typing import Any

import numpy as np

# Where on the scale each colour is, and what it is: grey-blue (none) over green and yellow to red (the scale's end).
_STOPS = (0.0, 0.25, 0.5, 0.75, 1.0)
_COLOURS = ((0.25, 0.3, 0.5), (0.1, 0.5, 0.75), (0.2, 0.75, 0.3), (0.95, 0.85, 0.15), (0.9, 0.1, 0.1))


def error_colours(distances: Any, scale: float) -> Any:
    """(vertices,) distances -> (vertices, 4), float32: red, green, blue and 1. Distances of `scale` and more are red."""
    share = np.clip(np.asarray(distances, np.float64) / max(scale, 1e-30), 0, 1)
    colours = np.ones((len(share), 4), np.float32)
    for channel in range(3):
        colours[:, channel] = np.interp(share, _STOPS, [colour[channel] for colour in _COLOURS])
    return colours
