"""What names of bones, shape keys and properties say: the side, and the part of the face. Without Blender."""

from __future__ import annotations

import re
from typing import Optional

from .channels import Channel

# A word or letter that says a side, where it stands apart: "lip.T.L.001", "browDownLeft", "eye_l", "L_brow".
_WORD = re.compile(r"(?:(?<![A-Za-z])|(?<=[a-z])(?=[LR]))(left|right|Left|Right|LEFT|RIGHT)(?![a-z])")
_LETTER = re.compile(r"(?:(?<![A-Za-z])[LRlr]|(?<=[a-z])[LR])(?![A-Za-z])")
_OTHER = {"left": "right", "Left": "Right", "LEFT": "RIGHT", "l": "r", "L": "R"}
_OTHER.update({there: here for here, there in list(_OTHER.items())})

# Parts of a face, by words that names of bones and shape keys have; the first that is found counts.
_PARTS = (
    ("brows", ("brow", "forehead", "frown")),
    ("eyes", ("eye", "lid", "blink", "squint", "pupil", "iris", "look")),
    ("nose", ("nose", "nostril", "sneer")),
    ("cheeks", ("cheek", "puff", "dimple")),
    ("tongue", ("tongue",)),
    ("jaw", ("jaw", "chin", "teeth")),
    ("mouth", ("lip", "mouth", "smile", "pucker", "funnel")),
    ("ears", ("ear",)),
    ("neck", ("neck", "throat", "head")),
)
# Within a longer word these say nothing: "ear" in "gear", "clear" or "shear", "lid" in "slide".
_SHORT = {"ear", "lid", "lip", "look", "head", "puff", "eye"}


def other_side(name: str) -> str:
    """The name on the other side of the body, or "" where it says no side: "lip.T.L" -> "lip.T.R"."""
    for pattern in _WORD, _LETTER:
        swapped = pattern.sub(lambda match: _OTHER[match.group(0)], name)
        if swapped != name:
            return swapped
    return ""


def face_part(name: str) -> str:
    """The part of the face that a name tells of: "brows", "eyes", "nose", "cheeks", "tongue", "jaw", "mouth", "ears",
    "neck"; "" if none."""
    small = re.sub(r"([a-z])([A-Z])", r"\1_\2", name).lower()
    words = re.split(r"[^a-z]+", small)
    for part, hints in _PARTS:
        for hint in hints:
            if any(_tells(word, hint) for word in words):
                return part
    return ""


def part_of_kin(name: str) -> str:
    """The part of the face that the name of what something belongs to tells of it: a bone's parent or collection, a shape
    key's mesh. "" if none, and for the head, to which all of a face belongs."""
    part = face_part(name)
    return "" if part == "neck" else part


def _tells(word: str, hint: str) -> bool:
    if hint in _SHORT:
        return word in (hint, hint + "s") or (hint in ("eye", "lip") and word.startswith(hint))
    return hint in word


def mirror_channel_name(channel: Channel) -> str:
    """The short name of the channel that does the same on the other side for the same value, "" if there is none.

    Bones of the two sides are mirrored along x, as Blender's own symmetrizing makes them: their locations along y and z,
    turns about x and scales agree in sign; locations along x and turns about y and z have the opposite sign, so those do
    not do the same."""
    if channel.kind == "location" and channel.axis == 0 or channel.kind == "rotation" and channel.axis != 0:
        return ""
    bone, key = other_side(channel.bone) if channel.bone else "", other_side(channel.key) if channel.key else ""
    if channel.of_bone:
        return _renamed(channel, bone, channel.key) if bone else ""
    if channel.bone:
        return _renamed(channel, bone or channel.bone, key or channel.key) if bone or key else ""
    return key


def _renamed(channel: Channel, bone: str, key: str) -> str:
    return Channel(channel.kind, channel.object, bone, channel.axis, key).short_name


def matches(name: str, patterns: "Optional[list[str]]") -> bool:
    """Whether a name is one of the patterns ("lip.*", with * and ?); true without patterns."""
    import fnmatch

    return not patterns or any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)
