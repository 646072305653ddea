"""What holds the channels of a pose bone: locks, drivers and limit constraints."""

from __future__ import annotations

from typing import Any, Dict, Optional, Set, Tuple

from .channels import AXES
from .ranges import Range, tighter

_LIMITS = {"location": "LIMIT_LOCATION", "rotation": "LIMIT_ROTATION", "scale": "LIMIT_SCALE"}
_LOCKS = {"location": "lock_location", "rotation": "lock_rotation", "scale": "lock_scale"}


def is_locked(bone: Any, kind: str, axis: int) -> bool:
    """Whether the artist can move this channel. A bone that is connected to its parent has no location of its own."""
    if kind == "location" and bone.bone.use_connect:
        return True
    return bool(getattr(bone, _LOCKS[kind])[axis])


def limits_of(bone: Any, kind: str, axis: int) -> Range:
    """The limits of a channel by constraints in the bone's own space. Those in other spaces limit where a bone ends up,
    not what its channels may be."""
    found: Range = (None, None)
    for constraint in bone.constraints:
        if constraint.type != _LIMITS[kind] or constraint.mute or constraint.influence < 1:
            continue
        if constraint.owner_space != "LOCAL":
            continue
        found = tighter(found, _limit(constraint, kind, AXES[axis]))
    return found


def _limit(constraint: Any, kind: str, axis: str) -> Range:
    if kind == "rotation":
        used = getattr(constraint, f"use_limit_{axis}")
        return (getattr(constraint, f"min_{axis}"), getattr(constraint, f"max_{axis}")) if used else (None, None)
    low = getattr(constraint, f"min_{axis}") if getattr(constraint, f"use_min_{axis}") else None
    high = getattr(constraint, f"max_{axis}") if getattr(constraint, f"use_max_{axis}") else None
    return low, high


def driven_paths(block: Any) -> Set[Tuple[str, int]]:
    """(data path, index) of everything that drivers of an ID set; the index is 0 where there is none."""
    animation = getattr(block, "animation_data", None)
    return {(curve.data_path, curve.array_index) for curve in animation.drivers} if animation else set()


def bone_path(bone_name: str, attribute: str) -> str:
    """The data path of an attribute of a pose bone, as F-curves have it."""
    return f'pose.bones["{escaped(bone_name)}"].{attribute}'


def escaped(name: str) -> str:
    """A name as it stands within a data path."""
    return name.replace("\\", "\\\\").replace('"', '\\"')


def rotation_attribute(bone: Any) -> str:
    """The attribute that turns the bone in its mode."""
    known: Dict[str, str] = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}
    return known.get(bone.rotation_mode, "rotation_euler")


def property_range(owner: Any, key: str) -> Optional[Tuple[float, float, float]]:
    """Minimum, maximum and default that a custom property shows in the window, None if it has no end. The ends that
    sliders stop at come before those that typing is held to."""
    shown = owner.id_properties_ui(key).as_dict()
    low = shown.get("soft_min", shown.get("min"))
    high = shown.get("soft_max", shown.get("max"))
    if low is None or high is None or not -1e6 < low < high < 1e6:
        return None
    default = shown.get("default", owner[key])
    return float(low), float(high), min(max(float(default), low), high)
