"""What a control moves in a scene, and which controls there are; without Blender, so that any Python can read a settings
file."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, replace
from typing import Any, Dict, Iterable, List, Tuple

KINDS = ("location", "rotation", "scale", "property", "shape_key")
AXES = "xyz"


class SettingsError(ValueError):
    """Something in a settings file, a scene or the options that cannot be baked; the message names it."""


NAMED = 12  # names in a message, at most


def there_are(names: Iterable[Any], like: str = "") -> str:
    """What there is, for a message about a name that is not there: 'there are "brow", "jaw" and 20 more'. like: the name
    that was given, to have those first that are spelt most like it."""
    known = [str(name) for name in names]
    if not known:
        return "there are none"
    if like and len(known) > 1:
        known.sort(key=lambda name: -difflib.SequenceMatcher(None, like.lower(), name.lower()).ratio())
    more = f" and {len(known) - NAMED} more" if len(known) > NAMED else ""
    return "there are " + ", ".join(f'"{name}"' for name in known[:NAMED]) + more


@dataclass(frozen=True)
class Channel:
    """One number of a scene.

    kind: "location", "rotation", "scale" (of a pose bone, one axis), "property" (a custom property) or "shape_key".
    object: the object's name. bone: the pose bone's, or "". axis: 0 to 2, of the first three kinds. key: the name of the
    property or shape key. on_data: the property is the object's data's. whole: the property holds an integer.

    A rotation is an Euler angle in radians for bones whose mode is one, in their own order. For quaternion and axis-angle
    bones it is a component of the rotation vector, the axis times the angle in radians, which has no jumps within half
    a turn and says the same as the Euler angle where only one axis turns."""

    kind: str
    object: str
    bone: str = ""
    axis: int = -1
    key: str = ""
    on_data: bool = False
    whole: bool = False

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise SettingsError(f'a channel of kind "{self.kind}", which is none of {", ".join(KINDS)}')
        if not self.object:
            raise SettingsError(f"a channel of kind {self.kind} without an object")
        if self.of_bone and (not self.bone or self.axis not in (0, 1, 2)):
            raise SettingsError(f'a {self.kind} of "{self.object}" needs a bone and an axis 0 to 2')
        if not self.of_bone and not self.key:
            raise SettingsError(f'a {self.kind} of "{self.object}" without a key')

    @property
    def of_bone(self) -> bool:
        return self.kind in ("location", "rotation", "scale")

    @property
    def short_name(self) -> str:
        """As controls are named unless two would be called the same: "jaw.rot_x", "jaw.mouth_lock", "smile"."""
        if self.of_bone:
            word = {"location": "loc", "rotation": "rot", "scale": "scale"}[self.kind]
            return f"{self.bone}.{word}_{AXES[self.axis]}"
        return f"{self.bone}.{self.key}" if self.bone else self.key

    @property
    def neutral(self) -> float:
        """Its value where the pose is cleared."""
        return 1.0 if self.kind == "scale" else 0.0

    @property
    def unit(self) -> str:
        return "radians" if self.kind == "rotation" else ""


@dataclass(frozen=True)
class SceneControl:
    """A control of the baked face and the channel it is. minimum <= rest <= maximum, minimum < maximum."""

    name: str
    channel: Channel
    minimum: float
    maximum: float
    rest: float
    group: str = ""
    mirror: str = ""

    def __post_init__(self) -> None:
        if not self.name:
            raise SettingsError(f"a control without a name, of {self.channel}")
        if not -1e6 <= self.minimum < self.maximum <= 1e6:
            raise SettingsError(f'control "{self.name}": a range from {self.minimum} to {self.maximum}')
        if not self.minimum <= self.rest <= self.maximum:
            raise SettingsError(
                f'control "{self.name}": rests at {self.rest}, outside {self.minimum} to {self.maximum}'
            )

    @property
    def span(self) -> float:
        return self.maximum - self.minimum


def named_apart(controls: Iterable[SceneControl]) -> List[SceneControl]:
    """The controls, with the object's name before those that would be called the same, and a number if that is not
    enough. Mirror partners keep naming each other."""
    controls = list(controls)
    counts: Dict[str, int] = {}
    for control in controls:
        counts[control.name] = counts.get(control.name, 0) + 1
    taken: Dict[str, int] = {}
    result = []
    for control in controls:
        if counts[control.name] > 1:
            owner = control.channel.object
            mirror = f"{owner}.{control.mirror}" if control.mirror else ""
            control = replace(control, name=f"{owner}.{control.name}", mirror=mirror)
        taken[control.name] = taken.get(control.name, 0) + 1
        if taken[control.name] > 1:
            control = replace(control, name=f"{control.name} {taken[control.name]}", mirror="")
        result.append(control)
    names = {control.name: control for control in result}
    return [
        control
        if control.mirror in names and names[control.mirror].mirror == control.name
        else replace(control, mirror="")
        for control in result
    ]


def channel_fields(channel: Channel) -> Dict[str, Any]:
    """As JSON, without what is as usual."""
    fields: Dict[str, Any] = {"kind": channel.kind, "object": channel.object}
    if channel.bone:
        fields["bone"] = channel.bone
    if channel.axis >= 0:
        fields["axis"] = channel.axis
    if channel.key:
        fields["key"] = channel.key
    if channel.on_data:
        fields["on_data"] = True
    if channel.whole:
        fields["whole"] = True
    return fields


def bones_of(controls: Iterable[SceneControl]) -> List[Tuple[str, str]]:
    """(object, bone) of all controls that are of bones, each once, in order."""
    return list(dict.fromkeys((c.channel.object, c.channel.bone) for c in controls if c.channel.bone))
