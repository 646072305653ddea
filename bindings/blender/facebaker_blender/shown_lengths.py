"""Lengths for people, in millimetres. Without Blender."""

from __future__ import annotations

from typing import Optional

_MILLIMETRES = {"m": 1000.0, "dm": 100.0, "cm": 10.0, "mm": 1.0, "in": 25.4, "inch": 25.4, "ft": 304.8}  # of a unit

_LEAST = 1e-3  # millimetres, that are worth telling


def millimetres_of(units: str) -> Optional[float]:
    """How many millimetres a unit has, None if it is not known."""
    return _MILLIMETRES.get(units)


def length_text(length: float, units: str) -> str:
    """A length of so many units: in millimetres where these are known."""
    millimetres = millimetres_of(units)
    shown, unit = length * (millimetres or 1), "mm" if millimetres else units or "units"
    if millimetres and 0 < shown < _LEAST:
        return f"less than {_LEAST:g} {unit}"
    return f"{shown:.0f} {unit}" if shown >= 100 else f"{shown:.2g} {unit}"
