"""Whether what a rig answered is kept once a bake is complete, for a bake after an edit. Without Blender."""

from __future__ import annotations

from typing import Any, Dict, List

_SMALL = 16 << 20  # bytes that nobody misses
_TIMES_ARCHIVE = 10
_LONG = 60  # seconds


def worth_keeping(size: int, archive_bytes: int, stages: List[Dict[str, Any]]) -> bool:
    """Whether a file of so many bytes is small, by itself or beside its archive, or has answers that took a minute.
    stages: `asked_by_stage` of the bake's document."""
    if size <= max(_SMALL, _TIMES_ARCHIVE * archive_bytes):
        return True
    asked = sum(stage["asked"] for stage in stages)
    evaluated = sum(stage["evaluated"] for stage in stages)
    seconds = sum(stage["seconds"] for stage in stages)
    # What was taken over of an earlier bake would take as long again as what was not.
    return evaluated == 0 or bool(seconds / evaluated * max(asked, evaluated) >= _LONG)
