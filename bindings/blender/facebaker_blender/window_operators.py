# mypy: disable-error-code="valid-type"
"""What the buttons of the rig and the bake do."""

from __future__ import annotations

from typing import Any

import bpy

from .action_shots import find_shots
from .bake_settings import BakeSettings
from .bone_choice import FindOptions
from .channels import SettingsError
from .find_controls import find_controls, still_controls
from .scene_choice import chosen_armatures, chosen_meshes
from .scene_evaluator import SceneEvaluator
from .tool_command import find_tool
from .window_errors import Failing
from .window_jobs import chosen_tool, job_of, offer_package, start_watching


class FACEBAKER_OT_choose(Failing, bpy.types.Operator):
    """Take the selected meshes and armatures; without a selection all meshes that are shown, and their armatures"""

    bl_idname, bl_label, bl_options = "facebaker.choose", "Choose objects", {"UNDO"}
    part = "rig"

    def work(self, context: Any) -> None:
        chosen = context.scene.facebaker
        selected = [item.name for item in context.selected_objects if item.type == "MESH"]
        bones = [item.name for item in context.selected_objects if item.type == "ARMATURE"]
        meshes = chosen_meshes(context, selected)
        armatures = chosen_armatures(meshes, bones)
        chosen.meshes.clear()
        chosen.armatures.clear()
        for mesh in meshes:
            chosen.meshes.add().object = mesh
        for armature in armatures:
            chosen.armatures.add().object = armature
        chosen.character = meshes[0].name


class FACEBAKER_OT_find(Failing, bpy.types.Operator):
    """Find the channels that move the meshes: of bones, shape keys and custom properties"""

    bl_idname, bl_label, bl_options = "facebaker.find", "Find controls", {"UNDO"}
    part = "rig"

    def work(self, context: Any) -> None:
        chosen = context.scene.facebaker
        meshes = [item.object for item in chosen.meshes if item.object]
        armatures = [item.object for item in chosen.armatures if item.object]
        kinds = ("location", "rotation") + (("scale",) if chosen.scales else ())
        collections = tuple(name.strip() for name in chosen.collections.split(",") if name.strip())
        options = FindOptions(tuple(chosen.bones.split()), collections, chosen.selected, kinds)
        controls, notes = find_controls(armatures, meshes, options)
        if not controls:
            raise SettingsError("no controls were found")
        reference = armatures[0].name if armatures else ""
        names = tuple(mesh.name for mesh in meshes)
        settings = BakeSettings(chosen.character, names, tuple(controls), reference, modifiers=chosen.modifiers)
        context.window_manager.progress_begin(0, len(controls))
        try:
            with SceneEvaluator(settings, context) as evaluator:
                still = set(still_controls(evaluator, step=context.window_manager.progress_update))
        finally:
            context.window_manager.progress_end()
        chosen.controls.clear()
        for control in controls:
            if control.name not in still:
                chosen.controls.add().take(control)
        chosen.take_shots(find_shots([control for control in controls if control.name not in still]))
        left_out = [f"{len(still)} more channels move nothing; they are left out"] if still else []
        chosen.found = "\n".join([*left_out, *notes])


class FACEBAKER_OT_bake(Failing, bpy.types.Operator):
    """Bake in the background, on a copy of the scene"""

    bl_idname, bl_label = "facebaker.bake", "Bake"
    part = "bake"
    go_on: bpy.props.BoolProperty(description="With the bake that was interrupted, from the scene as it was then")

    def work(self, context: Any) -> None:
        job = job_of(context)
        if job is None:
            raise SettingsError("name an archive that ends in .fbk; save the file first if its path begins with //")
        if self.go_on:
            job.go_on()
        else:
            tool = find_tool(chosen_tool(context))
            offer_package(context)
            job.start(context.scene.facebaker.settings(), tool)
        start_watching()


class FACEBAKER_OT_stop(Failing, bpy.types.Operator):
    """Interrupt the bake; what is done is kept"""

    bl_idname, bl_label = "facebaker.stop", "Stop"
    part = "bake"

    def work(self, context: Any) -> None:
        job = job_of(context)
        if job is not None:
            job.process.stop()


CLASSES = (FACEBAKER_OT_choose, FACEBAKER_OT_find, FACEBAKER_OT_bake, FACEBAKER_OT_stop)
