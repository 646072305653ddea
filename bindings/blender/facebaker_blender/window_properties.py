# mypy: disable-error-code="valid-type"
"""What the window keeps of its choices, in the scene; and the add-on's preferences."""

from __future__ import annotations

import json
from typing import Any

import bpy

from .bake_settings import BakeOptions, BakeSettings, Shot
from .channels import Channel, SceneControl, SettingsError, channel_fields
from .solve_request import SolveRequest

MODIFIERS = (
    ("refuse", "Refuse", "Name the modifiers and stop"),
    ("apply", "Apply", "Bake the mesh as they make it"),
    ("off", "Switch off", "Switch them off during the bake"),
)
JOINTS = (
    ("keep", "Keep", "Bones that the controls move become joints of the face"),
    ("none", "None", "Vertices alone learn what bones do"),
)
SPLITS = (("test", "Measure", "Errors are measured on it"), ("train", "Learn", "A bake for a backlot learns from it"))
RECIPES = (
    ("hero", "Hero", "Most exact"),
    ("compact", "Compact", "Smaller and quicker to pose"),
    ("linear", "Linear", "Blendshapes alone"),
)
USES = (("variant", "New shots", "Shots are not learnt from"), ("backlot", "These shots", "Shots are learnt from"))
SOLVE_FRAMES = (
    ("shape", "This shape", "One pose, keyed in the current frame"),
    ("frames", "All frames", "An animated mesh, from the scene's first frame to its last, or in its preview range"),
)
SOLVE_PLACES = (
    ("own", "On the rig", "The mesh is a copy of the rig's, and where it was moved to does not count"),
    ("world", "In the scene", "The mesh is over the rig, or moves as an object"),
)
SOLVE_ACTIONS = (
    ("new", "New", "Keys go into a new action"),
    ("current", "Current", "Keys go into the action that the rig uses, in place of those in these frames"),
)
# Blender 5.2 warns of a path that begins with "//", of the .blend's folder, unless its property says so; 4.3 cannot.
PATH_OPTIONS = {"ANIMATABLE"} | ({"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (5, 2, 0) else set())


def _show_colours(_: Any, context: Any) -> None:
    """Called by Blender when the choice of colours changes."""
    from .error_display import show_errors

    show_errors(context)


def _is_mesh(_: Any, scene_object: Any) -> bool:
    return bool(scene_object.type == "MESH")


class FACEBAKER_PG_mesh(bpy.types.PropertyGroup):
    object: bpy.props.PointerProperty(type=bpy.types.Object, poll=_is_mesh)


class FACEBAKER_PG_armature(bpy.types.PropertyGroup):
    object: bpy.props.PointerProperty(type=bpy.types.Object, poll=lambda _, found: found.type == "ARMATURE")


def _as_angle(name: str, of: str) -> Any:
    """A property that shows a number of radians as an angle, in degrees unless the scene's units say radians."""
    return bpy.props.FloatProperty(
        name=name, subtype="ANGLE", precision=2, step=100,
        get=lambda item: getattr(item, of), set=lambda item, value: setattr(item, of, value),
    )  # fmt: skip


class FACEBAKER_PG_control(bpy.types.PropertyGroup):
    """A control; its name is the group's. Ranges are kept as the face has them, those of rotations in radians."""

    use: bpy.props.BoolProperty(name="Bake", default=True)
    group: bpy.props.StringProperty(name="Group", description="The part of the face that it moves")
    minimum: bpy.props.FloatProperty(name="Minimum", precision=4)
    maximum: bpy.props.FloatProperty(name="Maximum", precision=4)
    rest: bpy.props.FloatProperty(name="Rest", precision=4)
    minimum_angle: _as_angle("Minimum", "minimum")
    maximum_angle: _as_angle("Maximum", "maximum")
    rest_angle: _as_angle("Rest", "rest")
    mirror: bpy.props.StringProperty()
    channel: bpy.props.StringProperty()

    @property
    def range_names(self) -> "tuple[str, str, str]":
        """The properties that show its range: as angles where it is a rotation."""
        suffix = "_angle" if json.loads(self.channel)["kind"] == "rotation" else ""
        return f"minimum{suffix}", f"rest{suffix}", f"maximum{suffix}"

    def take(self, control: SceneControl) -> None:
        self.name, self.group, self.mirror, self.use = control.name, control.group, control.mirror, True
        self.minimum, self.maximum, self.rest = control.minimum, control.maximum, control.rest
        self.channel = json.dumps(channel_fields(control.channel))

    def control(self) -> SceneControl:
        """Raises SettingsError if its minimum is not below its maximum."""
        if self.minimum >= self.maximum:
            raise SettingsError(f'control "{self.name}": its minimum is not below its maximum')
        rest = min(max(self.rest, self.minimum), self.maximum)
        channel = Channel(**json.loads(self.channel))
        return SceneControl(self.name, channel, self.minimum, self.maximum, rest, self.group, self.mirror)


class FACEBAKER_PG_shot(bpy.types.PropertyGroup):
    """A shot; its name is the action's."""

    use: bpy.props.BoolProperty(name="Use", default=True)
    first: bpy.props.IntProperty(name="First")
    last: bpy.props.IntProperty(name="Last")
    split: bpy.props.EnumProperty(name="For", items=SPLITS)


class FACEBAKER_PG_solve(bpy.types.PropertyGroup):
    """How a shape is solved to controls."""

    frames: bpy.props.EnumProperty(name="Solve", items=SOLVE_FRAMES)
    place: bpy.props.EnumProperty(name="Place", items=SOLVE_PLACES, description="Where the mesh counts as being")
    action: bpy.props.EnumProperty(name="Action", items=SOLVE_ACTIONS)
    noise: bpy.props.FloatProperty(
        name="Noise (mm)", default=0.5, min=1e-3, soft_max=5, max=1e3, precision=3, step=1,
        description="What the shape is off by itself, in millimetres; with less it is followed more closely, by more controls",
    )  # fmt: skip
    only: bpy.props.StringProperty(
        name="Only", description="Controls or groups that move, separated by commas; empty: all that are not locked"
    )
    locked: bpy.props.StringProperty(
        name="Locked", description="Controls or groups that stay at rest and get no keys, separated by commas"
    )
    head_motion: bpy.props.BoolProperty(
        name="The head moves", description="How the whole head moves and turns is found as well, and left out of the keys"
    )
    found: bpy.props.StringProperty()  # lines about what the last solve found

    def request(self, scene: Any) -> SolveRequest:
        """As the work needs it."""
        prefix = "frame_preview" if scene.use_preview_range else "frame"
        ends = int(getattr(scene, f"{prefix}_start")), int(getattr(scene, f"{prefix}_end"))
        frames = ends if self.frames == "frames" else None
        only, locked = (tuple(filter(None, map(str.strip, names.split(",")))) for names in (self.only, self.locked))
        return SolveRequest(
            frames, self.place == "world", self.action == "new", self.head_motion, self.noise, only, locked
        )


class FACEBAKER_PG_scene(bpy.types.PropertyGroup):
    """All choices of a scene."""

    character: bpy.props.StringProperty(name="Name", description="Of the character", default="face")
    meshes: bpy.props.CollectionProperty(type=FACEBAKER_PG_mesh)
    armatures: bpy.props.CollectionProperty(type=FACEBAKER_PG_armature)
    bones: bpy.props.StringProperty(name="Bones", description='Names with * and ?, separated by spaces; empty: all visible')
    collections: bpy.props.StringProperty(
        name="Collections",
        description="Bone collections, or before Blender 4 numbers of bone layers from 0 on, separated by commas",
    )
    selected: bpy.props.BoolProperty(name="Selected bones only")
    scales: bpy.props.BoolProperty(name="Scales", description="Of all bones, not only those that are limited or animated")
    modifiers: bpy.props.EnumProperty(name="Vertex count", items=MODIFIERS)
    driven_joints: bpy.props.EnumProperty(name="Driven joints", items=JOINTS, default="none")
    controls: bpy.props.CollectionProperty(type=FACEBAKER_PG_control)
    control: bpy.props.IntProperty()
    search: bpy.props.StringProperty(
        name="Search", description="Show controls whose names contain this", options={"TEXTEDIT_UPDATE"}
    )
    opened: bpy.props.StringProperty()  # groups of controls that are unfolded, a JSON list
    found: bpy.props.StringProperty()  # lines about what the last search for controls found
    shots: bpy.props.CollectionProperty(type=FACEBAKER_PG_shot)
    shot: bpy.props.IntProperty()
    out: bpy.props.StringProperty(name="Archive", subtype="FILE_PATH", options=PATH_OPTIONS, default="//face.fbk")
    recipe: bpy.props.EnumProperty(name="Recipe", items=RECIPES)
    use: bpy.props.EnumProperty(name="For", items=USES)
    rig_budget: bpy.props.IntProperty(
        name="Rig budget", default=BakeOptions().rig_budget, min=0, description="Poses that the rig is asked in order to learn"
    )
    workers: bpy.props.IntProperty(name="Workers", default=2, min=1, max=256, description="Blender processes that evaluate")
    show_warnings: bpy.props.BoolProperty(name="Warnings", description="Show what the bake warned of")
    colours: bpy.props.BoolProperty(
        name="Errors as colours", description="How far each vertex of the baked face is from the rig's", update=_show_colours
    )
    red_from: bpy.props.FloatProperty(
        name="Red from (mm)", default=0.3, min=1e-3, soft_max=10, max=1e4, precision=3, step=1, update=_show_colours,
        description="The distance in millimetres that is red",
    )  # fmt: skip
    measured: bpy.props.StringProperty()  # lines of the last measurement
    solve: bpy.props.PointerProperty(type=FACEBAKER_PG_solve)

    def settings(self) -> BakeSettings:
        """As the work needs them. Raises SettingsError."""
        meshes = [item.object.name for item in self.meshes if item.object]
        armatures = [item.object.name for item in self.armatures if item.object]
        if not self.controls:
            raise SettingsError("no controls yet; find them first")
        return BakeSettings(
            self.character,
            tuple(meshes),
            tuple(item.control() for item in self.controls if item.use),
            armatures[0] if armatures else "",
            tuple(Shot(item.name, item.first, item.last, item.split) for item in self.shots if item.use),
            self.modifiers,
            BakeOptions(self.recipe, self.use, self.rig_budget, workers=self.workers),
            self.driven_joints,
        )

    def take(self, settings: BakeSettings) -> None:
        """Shows settings, of a file for instance."""
        self.character, self.modifiers, self.driven_joints = settings.name, settings.modifiers, settings.driven_joints
        self.meshes.clear()
        for name in settings.meshes:
            self.meshes.add().object = bpy.data.objects.get(name)
        self.controls.clear()
        for control in settings.controls:
            self.controls.add().take(control)
        self.take_shots(settings.shots)
        self.recipe, self.use = settings.bake.recipe, settings.bake.use
        self.rig_budget, self.workers = settings.bake.rig_budget, settings.bake.workers

    def take_shots(self, shots: Any) -> None:
        self.shots.clear()
        for shot in shots:
            item = self.shots.add()
            item.name, item.first, item.last, item.split = shot.action, shot.first, shot.last, shot.split



class FACEBAKER_preferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    tool: bpy.props.StringProperty(name="Program facebaker", subtype="FILE_PATH", description="Empty: the one found in PATH")
    package: bpy.props.StringProperty(
        name="Python package", subtype="DIR_PATH", description="The folder that holds the package facebaker; empty: search"
    )

    def draw(self, _: Any) -> None:
        self.layout.prop(self, "tool")
        self.layout.prop(self, "package")


CLASSES = (
    FACEBAKER_PG_mesh,
    FACEBAKER_PG_armature,
    FACEBAKER_PG_control,
    FACEBAKER_PG_shot,
    FACEBAKER_PG_solve,
    FACEBAKER_PG_scene,
    FACEBAKER_preferences,
)


def preferences(context: Any) -> Any:
    """The add-on's preferences, None where it runs without being enabled."""
    addon = context.preferences.addons.get(__package__)
    return addon.preferences if addon else None
