"""The baked face beside its rig: in renders, the viewport, after undo and reopening, with modifiers switched off;
in_blender.py runs it."""

import pathlib

import bpy
import numpy as np
from addon_support import BakingTest, found

import facebaker
from facebaker_blender import face_preview
from facebaker_blender.action_shots import shot_values
from facebaker_blender.bake_job import BakeJob
from facebaker_blender.bake_settings import BakeOptions, BakeSettings, Shot
from facebaker_blender.baked_state import baked_meshes
from facebaker_blender.bone_choice import FindOptions
from facebaker_blender.scene_channels import SceneChannels
from facebaker_blender.scene_evaluator import SceneEvaluator
from facebaker_blender.tool_command import find_tool

FRAMES = 1, 11, 21


class PreviewTest(BakingTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        face = bpy.data.objects["face"]
        for name in "Smooth surface", "Hidden":
            face.modifiers.new(name, "SUBSURF").render_levels = 3
        face.modifiers["Hidden"].show_viewport = False
        face.data.shape_keys.animation_data.drivers.remove(
            next(d for d in face.data.shape_keys.animation_data.drivers if "crease" in d.data_path)
        )
        bpy.ops.wm.save_as_mainfile(filepath=str(cls.scene))
        settings, _ = found(FindOptions(), "face")
        shots = Shot("nod", 1, 21),
        bake = BakeOptions("linear", rig_budget=300, workers=1)
        cls.settings = BakeSettings("face", settings.meshes, settings.controls, "face", shots, "off", bake)
        job = BakeJob(cls.folder / "face.fbk")
        job.start(cls.settings, find_tool())
        assert job.process.wait(300) and job.process.document is not None, job.process.log.read_text()
        cls.archive = str(job.archive)
        cls.face = facebaker.load(cls.archive)

    def setUp(self):
        bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        face_preview.add_handlers()

    def tearDown(self):
        face_preview.remove_handlers()

    def preview(self, colours=False):
        return face_preview.add_preview(bpy.context, self.archive, self.settings, 1, colours)

    def expect(self, preview, controls):
        shown = np.array([vertex.co for vertex in preview.data.vertices])
        np.testing.assert_allclose(shown, self.face.evaluate(controls), atol=1e-6)

    def animate(self):
        bpy.data.objects["rig"].animation_data_create().action = bpy.data.actions["nod"]
        if hasattr(bpy.data.actions["nod"], "slots"):
            bpy.data.objects["rig"].animation_data.action_slot = bpy.data.actions["nod"].slots[0]
        return shot_values(self.settings, self.settings.shots[0])

    def render(self, preview, name, watch=None):
        """Renders FRAMES; what the preview's mesh was in each, or what watch() gives, with a window that stays in the
        first."""
        scene = bpy.context.scene
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(camera)
        camera.location, camera.rotation_euler = (preview.location.x, -6, 0.2), (np.pi / 2, 0, 0.2)
        scene.camera = camera
        bpy.data.objects["face"].hide_render = True
        scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 1, "CPU"
        scene.cycles.use_denoising, scene.cycles.max_bounces = False, 0
        scene.render.resolution_x = scene.render.resolution_y = 48
        scene.world = scene.world or bpy.data.worlds.new("world")
        scene.frame_start, scene.frame_end, scene.frame_step = FRAMES[0], FRAMES[-1], FRAMES[1] - FRAMES[0]
        scene.render.filepath = str(self.folder / name)
        meshes = {}

        def note(*_):
            points = [vertex.co for vertex in preview.data.vertices]
            meshes[scene.frame_current] = watch() if watch else np.array(points)

        bpy.app.handlers.render_post.append(note)
        try:
            bpy.ops.render.render(animation=True)
        finally:
            bpy.app.handlers.render_post.remove(note)
        return meshes

    def test_it_follows_a_rendered_animation(self):
        values = self.animate()
        preview = self.preview()
        meshes = self.render(preview, "frame")
        self.assertEqual(tuple(meshes), FRAMES)
        for frame in FRAMES:
            np.testing.assert_allclose(meshes[frame], self.face.evaluate(values[frame - 1]), atol=1e-6)
        pictures = [pathlib.Path(self.folder, f"frame{frame:04}.png").read_bytes() for frame in FRAMES]
        self.assertEqual(len(set(pictures)), 3)

    def test_a_render_shows_what_the_window_hides(self):
        values = self.animate()
        preview = self.preview()
        preview.hide_set(True)
        meshes = self.render(preview, "hidden")
        np.testing.assert_allclose(meshes[11], self.face.evaluate(values[10]), atol=1e-6)

    def test_it_follows_the_window(self):
        values = self.animate()
        preview = self.preview()
        for frame in FRAMES[::-1]:
            bpy.context.scene.frame_set(frame)
            self.expect(preview, values[frame - 1])
        keys = bpy.data.objects["face"].data.shape_keys.key_blocks
        keys["smile.L"].value = 0.7
        bpy.context.view_layer.update()
        pose = SceneChannels(self.settings.controls).read()
        self.assertIn(np.float32(0.7), pose)
        self.expect(preview, pose)

    def test_undo_and_redo(self):
        name = self.preview().name
        keys = bpy.data.objects["face"].data.shape_keys.key_blocks
        rest = SceneChannels(self.settings.controls).read()
        for value, message in ((0.0, "rest"), (0.8, "smile"), (0.8, "something else"), (0.2, "less")):
            keys["smile.L"].value = value
            bpy.ops.ed.undo_push(message=message)  # as Blender does, before the handler runs
            bpy.context.view_layer.update()
        for expected in 0.8, 0.8, 0.0:
            bpy.ops.ed.undo()
            pose = SceneChannels(self.settings.controls).read()
            self.assertAlmostEqual(float(pose.max()), expected, 5)
            self.expect(bpy.data.objects[name], pose)
        np.testing.assert_array_equal(pose, rest)
        bpy.ops.ed.redo()
        self.expect(bpy.data.objects[name], SceneChannels(self.settings.controls).read())

    def test_a_saved_file(self):
        values = self.animate()
        name = self.preview(True).name
        bpy.context.scene.frame_set(11)
        saved = self.folder / "saved.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(saved))
        stale = bpy.data.objects[name].data
        stale.vertices.foreach_set("co", np.zeros(3 * len(stale.vertices), np.float32))
        face_preview.remove_handlers()
        bpy.ops.wm.save_as_mainfile(filepath=str(saved))
        face_preview.add_handlers()
        bpy.ops.wm.open_mainfile(filepath=str(saved))
        self.expect(bpy.data.objects[name], values[10])
        bpy.context.scene.frame_set(21)
        self.expect(bpy.data.objects[name], values[20])
        self.assertEqual(len(baked_meshes(bpy.data.objects[name])), 1)

    def colours(self, preview):
        colours = np.empty(4 * self.face.vertex_count, np.float32)
        preview.data.color_attributes[face_preview.ATTRIBUTE].data.foreach_get("color", colours)
        return colours.reshape(-1, 4)

    def test_errors_are_those_of_the_rig_as_it_was_baked(self):
        face = bpy.data.objects["face"]
        graph = bpy.context.evaluated_depsgraph_get()
        self.assertEqual(len(face.evaluated_get(graph).data.vertices), 225)
        preview = self.preview(True)
        state = face_preview.preview_of(preview)
        keys = face.data.shape_keys.key_blocks
        bpy.data.objects["rig"].pose.bones["head"].rotation_euler[2] = 0.34
        keys["smile.L"].value = 0.5
        face["jaw_open"] = 0.5
        face.update_tag()
        bpy.context.view_layer.update()
        pose = SceneChannels(self.settings.controls).read()
        shown, error = self.colours(preview), state.max_error
        with SceneEvaluator(self.settings) as evaluator:
            truth = evaluator.evaluate(pose[None])[0]
        expected = np.linalg.norm(self.face.evaluate(pose) - truth, axis=1).max() / self.face.diagonal
        self.assertGreater(expected, 0.01)  # linear shapes do not square the jaw
        self.assertEqual(state.problem, "")
        self.assertAlmostEqual(error, expected, delta=1e-3 * expected)
        self.assertGreater(len(np.unique(shown, axis=0)), 5)
        # A rig that is hidden, or shown otherwise, is measured all the same.
        face.hide_set(True)
        keys["smile.L"].value = 0.6
        bpy.context.view_layer.update()
        self.assertEqual(state.problem, "")
        self.assertAlmostEqual(state.max_error, expected, delta=1e-2 * expected)

    def test_errors_in_renders(self):
        values = self.animate()
        preview = self.preview(True)
        state = face_preview.preview_of(preview)
        bpy.data.objects["face"].data.shape_keys.key_blocks["smile.R"].value = 0.3
        errors = self.render(preview, "coloured", lambda: (state.max_error, self.colours(preview), state.problem))
        with SceneEvaluator(self.settings) as evaluator:
            for frame in FRAMES:
                pose = np.where([c.name == "smile.R" for c in self.settings.controls], np.float32(0.3), values[frame - 1])
                away = np.linalg.norm(self.face.evaluate(pose) - evaluator.evaluate(pose[None])[0], axis=1)
                error, colours, problem = errors[frame]
                self.assertEqual(problem, "")
                self.assertAlmostEqual(error, away.max() / self.face.diagonal, delta=2e-7)
        self.assertGreater(np.abs(errors[21][1] - errors[1][1]).max(), 1e-3)

    def test_it_keeps_a_subdivision(self):
        preview = self.preview()
        self.assertEqual([(m.name, m.type, m.render_levels) for m in preview.modifiers], [("Smooth surface", "SUBSURF", 3)])
        graph = bpy.context.evaluated_depsgraph_get()
        self.assertEqual(len(preview.data.vertices), 64)
        self.assertEqual(len(preview.evaluated_get(graph).data.vertices), 225)
        # Before the armature it would be another face.
        rig, face = bpy.data.objects["rig"], bpy.data.objects["face"]
        face.modifiers.new("Armature", "ARMATURE").object = rig
        self.assertEqual(len(self.preview().modifiers), 0)

    def test_edges_keep_their_creases(self):
        from blender_scenes import grid
        from facebaker_blender.baked_state import keep_modifiers

        face, plain = bpy.data.objects["face"], grid("plain", 3)
        settings = BakeSettings("face", ("face", "plain"), self.settings.controls, "face", modifiers="off")
        both = grid("both", 8)
        points = [vertex.co[:] for mesh in (face, plain) for vertex in mesh.data.vertices]
        quads = [tuple(p.vertices) for p in face.data.polygons]
        quads += [tuple(64 + vertex for vertex in p.vertices) for p in plain.data.polygons]
        both.data.clear_geometry()
        both.data.from_pydata(points, [], quads)
        keep_modifiers(bpy.context, settings, both)
        moved = np.array([v.co for v in both.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices])
        # The plain mesh keeps its corners, the other one has them rounded.
        np.testing.assert_allclose(moved[64], (-1, 0, -1), atol=1e-6)
        self.assertGreater(float(np.abs(moved[0] - (-1, 0, -1)).max()), 0.01)
