"""What makes a mesh depend on time, so that controls alone do not say where its vertices are: simulations, caches, and
geometry nodes that read the time or what was before."""

from __future__ import annotations

import re
from typing import Any, Dict, Iterator, List, Optional, Set

import bpy

from .channels import SettingsError
from .node_inputs import input_values

_BEFORE, _FRAME = "the frames before", "the frame"
_MODIFIERS = {
    "CLOTH": _BEFORE, "SOFT_BODY": _BEFORE, "FLUID": _BEFORE, "DYNAMIC_PAINT": _BEFORE, "EXPLODE": _BEFORE,
    "PARTICLE_INSTANCE": _BEFORE, "OCEAN": _FRAME, "BUILD": _FRAME, "WAVE": _FRAME, "MESH_CACHE": _FRAME,
    "MESH_SEQUENCE_CACHE": _FRAME,
}  # fmt: skip
_NODES = {
    "GeometryNodeSimulationInput": _BEFORE, "GeometryNodeSimulationOutput": _BEFORE, "GeometryNodeBake": _BEFORE,
    "GeometryNodeInputSceneTime": _FRAME,
}  # fmt: skip
# The objects whose shape a modifier takes; of others it takes the place alone.
_SHAPES = {
    "LATTICE": ("object",), "MESH_DEFORM": ("object",), "CURVE": ("object",), "BOOLEAN": ("object",),
    "DATA_TRANSFER": ("object",), "SURFACE_DEFORM": ("target",), "VERTEX_WEIGHT_PROXIMITY": ("target",),
    "SHRINKWRAP": ("target", "auxiliary_target"), "ARRAY": ("curve", "start_cap", "end_cap"),
}  # fmt: skip


def refuse_time_dependence(mesh_object: Any) -> None:
    """Raises SettingsError if the mesh, as the viewport shows it, depends on time; it names the modifier and the node."""
    found = _dependence(mesh_object, set())
    if found:
        raise SettingsError(
            f"{found}, so that controls alone do not say where vertices are; switch it off in the viewport"
        )


def _dependence(scene_object: Any, seen: Set[str]) -> str:
    """What depends on time, as a sentence; "" if nothing does. seen: names of objects that were looked at."""
    if scene_object.name in seen:
        return ""
    seen.add(scene_object.name)
    for modifier in scene_object.modifiers:
        if not modifier.show_viewport:
            continue
        what = f'"{scene_object.name}": modifier "{modifier.name}"'
        if modifier.type in _MODIFIERS:
            return f"{what} ({modifier.type}) depends on {_MODIFIERS[modifier.type]}"
        others = [getattr(modifier, name, None) for name in _SHAPES.get(modifier.type, ())]
        if modifier.type == "NODES" and modifier.node_group:
            trees = _trees(modifier.node_group)
            for tree, nodes in trees.items():
                for node in nodes:
                    if node.bl_idname in _NODES and not node.mute:
                        place = f'node "{node.label or node.name}" of "{tree.name}"'
                        return f"{what}: {place} depends on {_NODES[node.bl_idname]}"
            others += [o for value in input_values(modifier).values() for o in _objects_in(value)]
            others += [o for nodes in trees.values() for o in _socket_objects(nodes)]
        for other in others:
            found = _dependence(other, seen) if other is not None else ""
            if found:
                return f"{what} takes the shape of another object: {found}"
    return ""


def _trees(tree: Any, found: "Optional[Dict[Any, List[Any]]]" = None) -> "Dict[Any, List[Any]]":
    """The node tree and the groups within it, each with the nodes that its output depends on."""
    found = {} if found is None else found
    if tree is None or tree in found:
        return found
    found[tree] = _used_nodes(tree)
    for node in found[tree]:
        if not node.mute:
            _trees(getattr(node, "node_tree", None), found)
    return found


def _used_nodes(tree: Any) -> List[Any]:
    """The nodes that links lead from to the tree's output."""
    sources: Dict[str, List[Any]] = {}
    for link in tree.links:
        if not getattr(link, "is_muted", False):
            sources.setdefault(link.to_node.name, []).append(link.from_node)
    for node in tree.nodes:  # of zones: the output needs the input
        paired = getattr(node, "paired_output", None)
        if paired is not None:
            sources.setdefault(paired.name, []).append(node)
    waiting = [node for node in tree.nodes if node.bl_idname == "NodeGroupOutput" and node.is_active_output]
    used: Dict[str, Any] = {}
    while waiting:
        node = waiting.pop()
        if node.name not in used:
            used[node.name] = node
            waiting += sources.get(node.name, [])
    return list(used.values())


def _socket_objects(nodes: List[Any]) -> Iterator[Any]:
    for node in nodes:
        for socket in node.inputs:
            yield from _objects_in(getattr(socket, "default_value", None))


def _objects_in(value: Any) -> Iterator[Any]:
    if isinstance(value, bpy.types.Object):
        yield value
    elif isinstance(value, bpy.types.Collection):
        yield from value.all_objects


def frame_drivers(blocks: List[Any]) -> List[str]:
    """Notes about drivers of these data-blocks that read the frame."""
    notes = []
    for block in blocks:
        animation = getattr(block, "animation_data", None)
        for curve in animation.drivers if animation else ():
            if _reads_frame(curve.driver):
                what = f'"{block.name}": the driver of {curve.data_path} reads the frame'
                notes.append(f"{what}; it is baked as in frame {bpy.context.scene.frame_current}")
    return notes


def _reads_frame(driver: Any) -> bool:
    if driver.type == "SCRIPTED" and re.search(r"\bframe\b", driver.expression):
        return not any(variable.name == "frame" for variable in driver.variables) or _targets_frame(driver)
    return _targets_frame(driver)


def _targets_frame(driver: Any) -> bool:
    targets = [target for variable in driver.variables for target in variable.targets]
    return any(target.data_path.startswith(("frame_current", "frame_float")) for target in targets)
