# mypy: disable-error-code="valid-type"
"""What went wrong, in the panel: all of it, until the same button succeeds."""

from __future__ import annotations

import sys
import traceback
from typing import Any, Dict, Set

import bpy

from .channels import SettingsError
from .window_text import draw_text

_problems: Dict[str, str] = {}  # {part of the window: message}


def problem_of(part: str) -> str:
    """What the last button of a part of the window ("rig", "bake", "face", "solve") failed with, "" if it did not."""
    return _problems.get(part, "")


def set_problem(part: str, text: str) -> None:
    """"": there is none."""
    _problems[part] = text


class Failing:
    """An operator whose failures are shown to the user; `part` says where in the window."""

    part = ""

    def execute(self: Any, context: Any) -> Set[str]:
        set_problem(self.part, "")
        try:
            self.work(context)
        except Exception as error:
            return fail(self, context, error)
        return {"FINISHED"}


def fail(operator: Any, context: Any, error: Exception) -> Set[str]:
    """Shows why an operator with a `part` has failed; what it returns."""
    text = message_of(error)
    set_problem(operator.part, text)
    if context.area:
        context.area.tag_redraw()
    operator.report({"ERROR"}, text)
    return {"CANCELLED"}


def message_of(error: Exception) -> str:
    """For people; what should not have happened is printed as well."""
    package = sys.modules.get("facebaker")
    expected = (SettingsError, OSError, RuntimeError, ValueError, *([package.Error] if package else []))
    if isinstance(error, expected):
        return str(error)
    traceback.print_exception(type(error), error, error.__traceback__)
    return f"failed, which it should not: {type(error).__name__}: {error}"


class FACEBAKER_OT_copy(bpy.types.Operator):
    """Copy this message, to paste it elsewhere"""

    bl_idname, bl_label, bl_options = "facebaker.copy", "Copy message", {"INTERNAL"}
    text: bpy.props.StringProperty()

    def execute(self, context: Any) -> Set[str]:
        context.window_manager.clipboard = self.text
        return {"FINISHED"}


def draw_problem(layout: Any, context: Any, text: str) -> None:
    """A message, none of it cut, with a button that copies it; nothing for ""."""
    if not text:
        return
    box = layout.box()
    box.alert = True
    draw_text(box, context, text[:1].upper() + text[1:], "ERROR", boxed=True)
    box.operator("facebaker.copy", icon="COPYDOWN").text = text


CLASSES = (FACEBAKER_OT_copy,)
