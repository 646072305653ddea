"""Small scenes for the tests of the add-on, made in Blender: what they deform is simple enough to be said in NumPy."""

import math

import bpy
import numpy as np


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def grid(name="face", size=8):
    """A grid of size x size vertices from -1 to 1, with texture coordinates."""
    side = np.linspace(-1, 1, size)
    points = [(x, 0.0, z) for z in side for x in side]
    quads = [
        (r * size + c, r * size + c + 1, (r + 1) * size + c + 1, (r + 1) * size + c)
        for r in range(size - 1)
        for c in range(size - 1)
    ]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], quads)
    layer = mesh.uv_layers.new(name="UVMap")
    for loop in mesh.loops:
        x, _, z = points[loop.vertex_index]
        layer.data[loop.index].uv = (x / 2 + 0.5, z / 2 + 0.5)
    added = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(added)
    return added


def armature(bones, name="rig"):
    """bones: (name, head, tail, parent) each."""
    data = bpy.data.armatures.new(name)
    rig = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for bone_name, head, tail, parent in bones:
        bone = data.edit_bones.new(bone_name)
        bone.head, bone.tail = head, tail
        if parent:
            bone.parent = data.edit_bones[parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def select_bone(rig, name):
    """Selects a bone for posing."""
    pose_bone = rig.pose.bones[name]
    (pose_bone if hasattr(pose_bone, "select") else pose_bone.bone).select = True  # moved in Blender 5


def drive(owner, path, target, target_path, expression="value", index=-1):
    """A driver of one variable, `value`."""
    curve = owner.driver_add(path, index) if index >= 0 else owner.driver_add(path)
    variable = curve.driver.variables.new()
    variable.name = "value"
    variable.targets[0].id, variable.targets[0].data_path = target, target_path
    curve.driver.expression = expression
    return curve


def shape_key_scene():
    """A grid with keys: `smile.L` and `smile.R` are controls; `crease` is driven by their product, `jaw` by a property of
    the object, `turn` by the turn of a bone."""
    empty_scene()
    face = grid()
    face.shape_key_add(name="Basis")
    offsets = {
        "smile.L": lambda x, z: (0.2 * max(x, 0), 0, 0.3 * max(x, 0)),
        "smile.R": lambda x, z: (0.2 * min(x, 0), 0, 0.3 * max(-x, 0)),
        "crease": lambda x, z: (0, -0.2 * (1 - abs(x)), 0),
        "jaw": lambda x, z: (0, 0, -0.5 * (z < 0) * z * z),
        "turn": lambda x, z: (0, 0.1 * x, 0),
    }
    for name, offset in offsets.items():
        key = face.shape_key_add(name=name)
        key.value = 0  # from Blender 5 on it is 1
        for vertex, point in zip(face.data.vertices, key.data):
            point.co = vertex.co + _vector(offset(vertex.co.x, vertex.co.z))
    keys = face.data.shape_keys
    keys.key_blocks["smile.L"].slider_max = 1.5
    rig = armature([("head", (0, 0, 0), (0, 0, 1), "")])
    rig.pose.bones["head"].rotation_mode = "XYZ"
    face["jaw_open"] = 0.0
    face.id_properties_ui("jaw_open").update(min=0.0, max=2.0, soft_min=0.0, soft_max=1.0, default=0.0)
    crease = keys.key_blocks["crease"].driver_add("value")
    for name in ("L", "R"):
        variable = crease.driver.variables.new()
        variable.name = name
        variable.targets[0].id_type = "KEY"
        variable.targets[0].id, variable.targets[0].data_path = keys, f'key_blocks["smile.{name}"].value'
    crease.driver.expression = "L * R"
    drive(keys, 'key_blocks["jaw"].value', face, '["jaw_open"]', "value * value")
    drive(keys, 'key_blocks["turn"].value', rig, 'pose.bones["head"].rotation_euler[2]', "sin(value)")
    keys.key_blocks["turn"].slider_min = -1
    bpy.context.view_layer.update()
    return face, rig


def shape_key_positions(rest, left, right, jaw, turn):
    """Where shape_key_scene() has its vertices. Blender holds driven keys within their range, too."""
    crease = min(left * right, 1)
    x, z = rest[:, 0], rest[:, 2]
    result = rest.astype(np.float64)
    result[:, 0] += 0.2 * left * np.maximum(x, 0) + 0.2 * right * np.minimum(x, 0)
    result[:, 1] += -0.2 * crease * (1 - abs(x)) + 0.1 * math.sin(turn) * x
    result[:, 2] += 0.3 * left * np.maximum(x, 0) + 0.3 * right * np.maximum(-x, 0) - 0.5 * jaw * jaw * (z < 0) * z * z
    return result


def constraint_scene():
    """A grid in a lattice. The lattice hangs on `jaw`, which is limited and copies half of the turn of `lead`; `lead` and
    `free` have channels that are locked, driven or limited; `free` carries a second mesh."""
    empty_scene()
    face, brow = grid(), grid("brow", 3)
    rig = armature([
        ("root", (0, 0, -2), (0, 0, -1), ""),
        ("jaw", (0, 0, -1), (0, 0, 0), "root"),
        ("lead", (1, 0, 0), (1, 0, 1), "root"),
        ("free", (-1, 0, 0), (-1, 0, 1), "root"),
        ("tip", (-1, 0, 1), (-1, 0, 1.5), "free"),
    ])  # fmt: skip
    lattice_data = bpy.data.lattices.new("cage")
    lattice_data.points_u, lattice_data.points_v, lattice_data.points_w = 3, 2, 3
    cage = bpy.data.objects.new("cage", lattice_data)
    bpy.context.collection.objects.link(cage)
    cage.scale = (2.4, 0.5, 2.4)
    bpy.context.view_layer.update()
    cage.parent, cage.parent_type, cage.parent_bone = rig, "BONE", "jaw"
    bpy.context.view_layer.update()
    cage.matrix_world = ((2.4, 0, 0, 0), (0, 0.5, 0, 0), (0, 0, 2.4, 0), (0, 0, 0, 1))
    modifier = face.modifiers.new("Lattice", "LATTICE")
    modifier.object = cage
    brow.parent, brow.parent_type, brow.parent_bone = rig, "BONE", "free"
    bones = rig.pose.bones
    bones["jaw"].rotation_mode = "XYZ"
    _limit(bones["jaw"], "LIMIT_ROTATION", use_limit_x=True, min_x=-0.1, max_x=0.5)
    _limit(bones["jaw"], "LIMIT_LOCATION", use_min_z=True, use_max_z=True, min_z=-0.2, max_z=0.3)
    copy = bones["jaw"].constraints.new("COPY_ROTATION")
    copy.target, copy.subtarget, copy.influence, copy.mix_mode = rig, "lead", 0.5, "ADD"
    copy.owner_space = copy.target_space = "LOCAL"
    bones["jaw"].lock_location[1] = True
    bones["lead"].lock_location = (True, True, True)
    bones["free"].rotation_mode = "AXIS_ANGLE"
    _limit(bones["free"], "LIMIT_SCALE", use_min_x=True, use_max_x=True, min_x=0.5, max_x=2.0)
    # Limits in the world's space say nothing about channels, muted ones nothing at all.
    _limit(bones["free"], "LIMIT_LOCATION", "WORLD", use_max_x=True, max_x=0.01)
    _limit(bones["free"], "LIMIT_LOCATION", mute=True, use_max_x=True, max_x=0.01)
    _limit(bones["free"], "LIMIT_LOCATION", use_min_y=True, use_max_y=True, min_y=0.0, max_y=0.0)
    drive(rig, 'pose.bones["free"].location', rig, 'pose.bones["lead"].rotation_quaternion[1]', index=2)
    bpy.context.view_layer.update()
    return face, brow, rig


def _limit(bone, kind, space="LOCAL", **settings):
    constraint = bone.constraints.new(kind)
    constraint.owner_space = space
    for name, value in settings.items():
        setattr(constraint, name, value)


def chain_scene():
    """A grid that a chain of the bones `base` and `tip` bends, between which and `still`, which has no controls, its
    weights are blended. Shape key `puff` moves its upper half along y. A second mesh hangs on `copy`, which turns as
    `lead` does."""
    empty_scene()
    face, ball = grid(), grid("ball", 3)
    rig = armature([
        ("root", (0, 0, -2), (0, 0, -1), ""),
        ("still", (0, 0, -1), (0, 0, -0.5), "root"),
        ("base", (0, 0, -0.5), (0, 0, 0.25), "root"),
        ("tip", (0, 0, 0.25), (0, 0, 1), "base"),
        ("lead", (2, 0, 0), (2, 0, 1), "root"),
        ("copy", (0, 0.5, 0), (0, 0.5, 1), "root"),
    ])  # fmt: skip
    face.shape_key_add(name="Basis")
    puff = face.shape_key_add(name="puff")
    puff.value = 0
    groups = {name: face.vertex_groups.new(name=name) for name in ("still", "base", "tip")}
    for vertex, point in zip(face.data.vertices, puff.data):
        height = vertex.co.z
        point.co = vertex.co + _vector((0, 0.1 * (height > 0), 0))
        tip, still = min(max(2 * height, 0), 1), min(max(-2 * height - 0.5, 0), 1)
        for name, weight in (("tip", tip), ("still", still), ("base", max(1 - tip - still, 0))):
            groups[name].add([vertex.index], weight, "REPLACE")
    face.modifiers.new("Armature", "ARMATURE").object = rig
    bones = rig.pose.bones
    for bone in bones:
        bone.rotation_mode, bone.lock_location = "XYZ", (True, True, True)
        bone.lock_rotation = (bone.name not in ("base", "tip", "lead"),) * 3
    bones["lead"].lock_rotation = (False, True, True)
    for name in "base", "tip", "lead":
        for axis in "xyz":
            span = {f"use_limit_{axis}": True, f"min_{axis}": -0.6, f"max_{axis}": 0.6}
            _limit(bones[name], "LIMIT_ROTATION", **span)
    ball.parent, ball.parent_type, ball.parent_bone = rig, "BONE", "copy"
    drive(rig, 'pose.bones["copy"].rotation_euler', rig, 'pose.bones["lead"].rotation_euler[0]', index=0)
    bpy.context.view_layer.update()
    return face, rig


def two_rigs():
    """Two armatures with a bone "jaw" each, on which a grid each hangs: ann, bob and ann face, bob face."""
    empty_scene()
    rigs = []
    for place, name in enumerate(("ann", "bob")):
        rig = armature([("jaw", (0, 0, -1), (0, 0, 0), "")], name)
        face = grid(f"{name} face", 4)
        face.parent, face.parent_type, face.parent_bone = rig, "BONE", "jaw"
        rig.pose.bones["jaw"].rotation_mode = "XYZ"
        rig.location.x = 3 * place
        rigs.append(rig)
    bpy.context.view_layer.update()
    return rigs


def geometry_nodes(scene_object, build, name="Nodes"):
    """A modifier with a node tree; build(tree, geometry) gives the geometry of its output from that of its input."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    if hasattr(tree, "interface"):
        for way in "INPUT", "OUTPUT":
            tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    else:  # before Blender 4
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    tree.links.new(build(tree, start.outputs[0]), end.inputs[0])
    if scene_object is not None:
        modifier = scene_object.modifiers.new(name, "NODES")
        modifier.node_group = tree
    return tree


def _vector(values):
    import mathutils

    return mathutils.Vector(values)
