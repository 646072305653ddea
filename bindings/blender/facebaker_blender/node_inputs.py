"""What a geometry nodes modifier gives to its tree."""

from __future__ import annotations

from typing import Any, Dict

_FIELDS = ("type", "value", "attribute_name")


def _sockets(modifier: Any) -> Dict[str, Any]:
    """The inputs as Blender 5.2 has them; none before."""
    inputs = getattr(getattr(modifier, "properties", None), "inputs", None)
    names = inputs.bl_rna.properties.keys() if inputs else ()
    return {name: getattr(inputs, name) for name in names if name not in ("rna_type", "name")}


def _has_sockets(modifier: Any) -> bool:
    return hasattr(getattr(modifier, "properties", None), "inputs")


def input_values(modifier: Any) -> Dict[str, Any]:
    """Values by name of the input."""
    if not _has_sockets(modifier):
        return {key: modifier[key] for key in modifier.keys()}
    return {name: socket.value for name, socket in _sockets(modifier).items() if hasattr(socket, "value")}


def copy_inputs(modifier: Any, to: Any) -> None:
    """Gives another modifier of the same tree the same inputs."""
    if not _has_sockets(modifier):
        for key in modifier.keys():
            to[key] = modifier[key]
        return
    others = _sockets(to)
    for name, socket in _sockets(modifier).items():
        for field in _FIELDS:
            if hasattr(socket, field) and hasattr(others[name], field):
                setattr(others[name], field, getattr(socket, field))
