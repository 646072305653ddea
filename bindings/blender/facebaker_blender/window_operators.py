# mypy: disable-error-code="valid-type"
"""What the window's buttons do."""

from __future__ import annotations

import pathlib
from typing import Any, Optional, Set

import bpy

from .action_shots import find_shots
from .bake_job import BakeJob, bake_figures
from .bake_settings import BakeSettings
from .bone_choice import FindOptions
from .channels import SettingsError
from .find_controls import find_controls, still_controls
from .scene_choice import chosen_armatures, chosen_meshes
from .scene_evaluator import SceneEvaluator
from .tool_command import add_package_path, find_tool
from .window_properties import preferences

FAILURES = (SettingsError, OSError, RuntimeError, ValueError)
_jobs: "dict[str, BakeJob]" = {}


def offer_package(context: Any) -> None:
    """Makes the package facebaker importable, from where the preferences say. Raises SettingsError."""
    chosen = preferences(context)
    add_package_path(bpy.path.abspath(chosen.package) if chosen else "")


def job_of(context: Any) -> Optional[BakeJob]:
    """The bake of the archive that the window names, None if the name is none."""
    path = bpy.path.abspath(context.scene.facebaker.out)
    if not path or not pathlib.Path(path).is_absolute():
        return None
    if path not in _jobs:
        try:
            _jobs[path] = BakeJob(path)
        except SettingsError:
            return None
    return _jobs[path]


class _Failing:
    """An operator whose failures are shown to the user."""

    def execute(self: Any, context: Any) -> Set[str]:
        try:
            self.work(context)
        except FAILURES as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class FACEBAKER_OT_choose(_Failing, bpy.types.Operator):
    """Take the selected meshes and armatures; without a selection all meshes that are shown, and their armatures"""

    bl_idname, bl_label, bl_options = "facebaker.choose", "Choose objects", {"UNDO"}

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


class FACEBAKER_OT_find(_Failing, bpy.types.Operator):
    """Find the channels that move the meshes: of bones, shape keys and custom properties"""

    bl_idname, bl_label, bl_options = "facebaker.find", "Find controls", {"UNDO"}

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
        for note in notes:
            self.report({"WARNING"}, note)
        self.report({"INFO"}, f"{len(controls) - len(still)} controls; {len(still)} channels move nothing")


class FACEBAKER_OT_bake(_Failing, bpy.types.Operator):
    """Bake in the background, on a copy of the scene"""

    bl_idname, bl_label = "facebaker.bake", "Bake"
    go_on: bpy.props.BoolProperty(description="With the bake that was interrupted, from the scene as it was then")

    def work(self, context: Any) -> None:
        job = job_of(context)
        if job is None:
            raise SettingsError("name an archive that ends in .fbk; save the file first if its path begins with //")
        if self.go_on:
            job.go_on()
        else:
            chosen = preferences(context)
            tool = find_tool(bpy.path.abspath(chosen.tool) if chosen else "")
            offer_package(context)
            job.start(context.scene.facebaker.settings(), tool)
        start_watching()


class FACEBAKER_OT_stop(_Failing, bpy.types.Operator):
    """Interrupt the bake; what is done is kept"""

    bl_idname, bl_label = "facebaker.stop", "Stop"

    def work(self, context: Any) -> None:
        job = job_of(context)
        if job is not None:
            job.process.stop()


class FACEBAKER_OT_show(_Failing, bpy.types.Operator):
    """Show the baked face beside the rig; it follows the same controls"""

    bl_idname, bl_label, bl_options = "facebaker.show", "Show baked face", {"UNDO"}

    def work(self, context: Any) -> None:
        offer_package(context)
        from .bake_settings import load_settings
        from .face_measure import measure_face
        from .face_preview import add_preview

        job, chosen = job_of(context), context.scene.facebaker
        if job is None or not job.archive.is_file():
            raise SettingsError("there is no such archive yet; bake it first")
        settings = load_settings(job.settings)
        preview = add_preview(context, str(job.archive), settings, 1, chosen.colours, chosen.scale)
        from .face_preview import preview_of

        state = preview_of(preview)
        if state is not None:
            with SceneEvaluator(settings, context) as evaluator:
                measure = measure_face(state.face, evaluator, drawn=20, linear=False)
            chosen.measured = "\n".join(measure.short_lines())


class FACEBAKER_OT_colours(_Failing, bpy.types.Operator):
    """Show or hide the distance of each vertex of the baked face from the rig's"""

    bl_idname, bl_label, bl_options = "facebaker.colours", "Update colours", {"UNDO"}

    def work(self, context: Any) -> None:
        offer_package(context)
        from .face_preview import ARCHIVE, show_colours, update_previews

        chosen = context.scene.facebaker
        for scene_object in context.scene.objects:
            if ARCHIVE in scene_object.keys():
                show_colours(context, scene_object, chosen.colours, chosen.scale)
        context.view_layer.update()
        update_previews(context.scene, context.evaluated_depsgraph_get(), again=True)
        for area in context.screen.areas if context.screen else ():
            if area.type == "VIEW_3D" and chosen.colours:
                area.spaces.active.shading.color_type = "VERTEX"


def start_watching() -> None:
    """Has Blender call watch() until no bake runs; also for one that an earlier session started."""
    if not bpy.app.timers.is_registered(watch):
        bpy.app.timers.register(watch, first_interval=0.5)


def watch() -> Optional[float]:
    """Called by Blender while bakes run: reads how far they have come and has the panel drawn again."""
    running = [job for job in _jobs.values() if job.process.poll()]
    for job in _jobs.values():
        job.tidy()
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
    return 0.5 if running else None


def result_lines(job: BakeJob) -> "list[str]":
    """What the last bake of this archive came to."""
    document = job.process.document
    if document is None:
        return [job.process.progress.error] if job.process.progress.error else []
    figures = bake_figures(document)
    reused = [f"{figures['reused']} answers taken over"] if figures["reused"] else []
    return [
        f"{figures['bytes'] / 1e6:.2f} MB, {figures['poses']} poses",
        f"{figures['rig_calls']} rig calls",
        *reused,
        f"unseen poses: mse {figures['mse']:.1e}",
    ]


CLASSES = (
    FACEBAKER_OT_choose,
    FACEBAKER_OT_find,
    FACEBAKER_OT_bake,
    FACEBAKER_OT_stop,
    FACEBAKER_OT_show,
    FACEBAKER_OT_colours,
)
