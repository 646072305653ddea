"""Controls as the panel lists them: by group. Without Blender."""

from __future__ import annotations

import json
from typing import Any, Dict, Iterable, List, Set

UNGROUPED = "Other"  # the heading of controls that have no group


def shown_controls(controls: Iterable[Any], search: str) -> List[Any]:
    """Those whose names contain what is searched for, whatever the case; all, if nothing is."""
    return [control for control in controls if search.lower() in control.name.lower()]


def grouped_controls(controls: Iterable[Any]) -> Dict[str, List[Any]]:
    """{group: its controls}, in the order in which they come; those without a group come last."""
    groups: Dict[str, List[Any]] = {}
    for control in controls:
        groups.setdefault(control.group, []).append(control)
    if "" in groups:
        groups[""] = groups.pop("")
    return groups


def opened_groups(text: str) -> Set[str]:
    """The groups that are unfolded, from the text that keeps them."""
    return set(json.loads(text)) if text else set()


def opened_text(groups: Iterable[str]) -> str:
    return json.dumps(sorted(groups))
