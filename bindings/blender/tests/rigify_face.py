"""Makes the scene that the add-on is tested on: Rigify's human, fitted to the sample face, which is skinned to it.

    blender -b --factory-startup -P rigify_face.py -- SAMPLE OUT.blend

SAMPLE is a dataset folder of the sample face, as `facebaker sample sample --poses 20 --out SAMPLE` writes it. Eyes and
teeth are objects that hang on bones; skin and tongue follow their nearest deforming bones. Two actions animate the face
controls: "talk" and "play"."""

import pathlib
import sys

import bpy
import mathutils
import numpy as np

EYE_HEIGHT, EYE_DEPTH, EYE_SIDE = 0.0, 5.9, 3.4  # of the sample face, in cm
METARIG_EYES = mathutils.Vector((0.0, -0.1209, 1.8941))  # of Rigify's human, in m
FIT = mathutils.Vector((0.66, 0.65, 0.87))  # the human's face is larger than the sample's
INFLUENCES = 4


def read_face(folder):
    """Points in Blender's space, in m, quads, and the vertices of each part of the mesh, the skin first."""
    points = np.load(folder / "rest.npy").astype(np.float64)
    quads = np.load(folder / "faces.npy")
    labels = np.arange(len(points))
    while True:
        least = labels[quads].min(1)
        merged = labels.copy()
        for corner in range(quads.shape[1]):
            np.minimum.at(merged, quads[:, corner], least)
        if np.array_equal(merged, labels):
            break
        labels = merged
    x, y, z = points[:, 0], points[:, 1] - EYE_HEIGHT, points[:, 2] - EYE_DEPTH
    placed = 0.01 * np.stack([x, -z, y], 1) + np.array(METARIG_EYES)
    return placed, quads, [np.flatnonzero(labels == label) for label in np.unique(labels)]


def generate_rig():
    """Rigify's human with the bones of its face moved to where the sample face has its eyes, mouth and chin."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="rigify")
    bpy.ops.object.armature_human_metarig_add()
    metarig = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bones = metarig.data.edit_bones
    places = {bone.name: (bone.head.copy(), bone.tail.copy()) for bone in bones["face"].children_recursive}
    for name, (head, tail) in places.items():
        bones[name].head = METARIG_EYES + FIT * (head - METARIG_EYES)
        bones[name].tail = METARIG_EYES + FIT * (tail - METARIG_EYES)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.pose.rigify_generate()
    rig = bpy.context.object
    metarig.hide_viewport = True
    return rig


def add_mesh(name, points, quads, vertices):
    """An object of the quads between these vertices."""
    numbers = np.full(len(points), -1)
    numbers[vertices] = np.arange(len(vertices))
    inside = numbers[quads]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points[vertices].tolist(), [], inside[(inside >= 0).all(1)].tolist())
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    added = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(added)
    return added


def skin_to_nearest(mesh, rig):
    """Weights by the inverse fourth power of the distance to the nearest deforming bones of head and neck."""
    bones = [bone for bone in rig.data.bones if bone.use_deform and bone.tail_local.z > METARIG_EYES.z - 0.25]
    points = np.array([vertex.co for vertex in mesh.data.vertices])
    distances = np.stack([_distance(points, np.array(b.head_local), np.array(b.tail_local)) for b in bones], 1)
    nearest = np.argsort(distances, 1)[:, :INFLUENCES]
    weights = 1 / (np.take_along_axis(distances, nearest, 1) + 2e-3) ** 4
    weights /= weights.sum(1, keepdims=True)
    groups = [mesh.vertex_groups.new(name=bone.name) for bone in bones]
    for vertex in range(len(points)):
        for bone, weight in zip(nearest[vertex], weights[vertex]):
            groups[bone].add([vertex], float(weight), "REPLACE")
    modifier = mesh.modifiers.new("Armature", "ARMATURE")
    modifier.object = rig
    mesh.parent = rig


def _distance(points, head, tail):
    along = tail - head
    share = np.clip((points - head) @ along / max(along @ along, 1e-12), 0, 1)
    return np.linalg.norm(points - head - share[:, None] * along, axis=1)


def hang_on_bone(mesh, rig, bone):
    """Parents an object to a bone where it is."""
    mesh.parent, mesh.parent_type, mesh.parent_bone = rig, "BONE", bone
    bpy.context.view_layer.update()
    mesh.matrix_world = mathutils.Matrix.Identity(4)


def face_collections(rig):
    """Where Rigify puts the bones of a face: the main controls, then finer ones. Before Blender 4, numbers of layers."""
    return ("0", "1", "2") if hasattr(rig.data, "layers") else ("Face", "Face (Primary)", "Face (Secondary)")


def bones_in(rig, collection):
    if hasattr(rig.data, "layers"):
        return [bone.name for bone in rig.data.bones if bone.layers[int(collection)]]
    return [bone.name for bone in rig.data.bones if collection in bone.collections]


def add_action(rig, name, frames, seed, strength):
    """Eyes look, lids blink, brows and lips move, the jaw opens: smooth random curves with keys every 6 frames."""
    rig.animation_data.action = action = bpy.data.actions.new(name)
    action.use_fake_user = True
    random = np.random.default_rng(seed)
    face = bones_in(rig, face_collections(rig)[1])
    for frame in range(1, frames + 1, 6):
        opened = strength * random.beta(1, 1.5)
        keyed = {("jaw_master", "rotation_quaternion"): mathutils.Euler((0.35 * opened, 0, 0.05 * random.normal())).to_quaternion()}
        keyed["eyes", "location"] = 0.06 * random.uniform(-1, 1, 3) * (1, 1, 0)
        keyed["nose_master", "location"] = 0.002 * random.normal(size=3)
        keyed["tongue_master", "rotation_quaternion"] = mathutils.Euler((0.2 * random.normal(), 0, 0)).to_quaternion()
        for bone in face:
            keyed[bone, "location"] = strength * 0.003 * np.clip(random.normal(size=3), -2, 2) * (random.uniform() < 0.7)
        for (bone, attribute), value in keyed.items():
            setattr(rig.pose.bones[bone], attribute, value)
            rig.pose.bones[bone].keyframe_insert(attribute, frame=frame)
    rig.animation_data.action = None
    for bone in rig.pose.bones:
        bone.location, bone.rotation_quaternion = (0, 0, 0), (1, 0, 0, 0)


def make_scene(folder):
    """The whole scene; the rig and the meshes."""
    points, quads, parts = read_face(pathlib.Path(folder))
    rig = generate_rig()
    skin, left, right, upper, lower, tongue = parts
    face = add_mesh("face", points, quads, np.sort(np.concatenate([skin, tongue])))
    skin_to_nearest(face, rig)
    meshes = [face]
    for name, vertices, bone in (
        ("eye.L", left, "MCH-eye.L"), ("eye.R", right, "MCH-eye.R"),
        ("teeth.T", upper, "ORG-teeth.T"), ("teeth.B", lower, "ORG-teeth.B"),
    ):  # fmt: skip
        mesh = add_mesh(name, points, quads, vertices)
        hang_on_bone(mesh, rig, bone)
        meshes.append(mesh)
    add_action(rig, "talk", 120, 1, 1.0)
    add_action(rig, "play", 90, 2, 0.7)
    for material_name, colour, targets in (("skin", (0.8, 0.55, 0.45, 1), meshes[:1]), ("white", (0.9, 0.9, 0.85, 1), meshes[1:])):
        material = bpy.data.materials.new(material_name)
        material.diffuse_color = colour
        for mesh in targets:
            mesh.data.materials.append(material)
    bpy.context.view_layer.update()
    return rig, meshes


if __name__ == "__main__":
    sample, out = sys.argv[sys.argv.index("--") + 1 :]
    make_scene(sample)
    bpy.ops.wm.save_as_mainfile(filepath=str(pathlib.Path(out).resolve()))
