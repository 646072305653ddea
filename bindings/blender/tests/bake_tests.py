"""Bakes through the tool, in processes of their own; in_blender.py runs it."""

import html
import json
import os
import pathlib
import signal
import subprocess
import time
from unittest import mock

import bpy
import numpy as np
from addon_support import HEADLESS, BakingTest, found

import facebaker
from facebaker_blender import face_preview
from facebaker_blender.bake_job import BakeJob, this_blender
from facebaker_blender.bake_result import result_lines
from facebaker_blender.bake_settings import BakeOptions, BakeSettings, load_settings, save_settings
from facebaker_blender.error_display import previews_in
from facebaker_blender.scene_channels import SceneChannels
from facebaker_blender.scene_choice import chosen_meshes
from facebaker_blender.scene_evaluator import SceneEvaluator
from facebaker_blender.tool_command import find_tool


class BakeTest(BakingTest):
    def test_one_command_bakes_measures_and_shows(self):
        out = self.folder / "face.fbk"
        printed = self.headless(
            "bake", "--out", out, "--armature", "rig", "--recipe", "linear", "--rig-budget", 200, "--workers", 2,
            "--json", self.folder / "measure.json", "--preview", self.folder / "preview.blend",
            "--picture", self.folder / "beside.png",
        )  # fmt: skip
        self.assertIn("controls: ", printed)
        self.assertRegex(printed, r"nod: \d+ poses, worst vertex off by [\d.e-]+ mm, ")
        self.assertNotIn("Traceback", printed)
        self.assertTrue((self.folder / "beside.png").read_bytes().startswith(b"\x89PNG"))
        measure = json.loads((self.folder / "measure.json").read_text())
        self.assertEqual([errors["name"] for errors in measure["errors"]], ["nod", "drawn poses"])
        self.assertGreater(measure["times_faster"], 1)
        # The recipe is linear blendshapes, so its error is that of those which are measured beside it.
        drawn = measure["errors"][1]
        self.assertLess(abs(drawn["mse"] - drawn["linear_mse"]), 0.05 * drawn["linear_mse"])
        face = facebaker.load(out)
        settings = load_settings(self.folder / "face.blender" / "settings.json")
        self.assertEqual([c.name for c in face.controls], [c.name for c in settings.controls])
        self.assertEqual((face.units, face.up_axis, len(face.uvs)), ("m", "z", 64))
        self.check_preview(face, settings)
        self.check_window(settings)

    def check_preview(self, face, settings):
        """In a new file of the same scene: the baked face follows the rig, by the window's handlers, with its errors."""
        bpy.ops.wm.open_mainfile(filepath=str(self.folder / "preview.blend"))
        face_preview.add_handlers()
        previews = [o for o in bpy.context.scene.objects if face_preview.ARCHIVE in o.keys()]
        self.assertEqual(len(previews), 2)
        self.assertEqual([mesh.name for mesh in chosen_meshes(bpy.context, [])], ["face"])
        keys = bpy.data.objects["face"].data.shape_keys.key_blocks
        keys["smile.L"].value, keys["smile.R"].value = 1.0, 0.5
        bpy.context.view_layer.update()
        pose = SceneChannels(settings.controls).read()
        for preview in previews:
            shown = np.array([vertex.co for vertex in preview.data.vertices])
            np.testing.assert_allclose(shown, face.evaluate(pose), atol=1e-6)
        state = face_preview.preview_of(previews[1])
        with SceneEvaluator(settings) as evaluator:
            truth = evaluator.evaluate(pose[None])[0]
        error = np.linalg.norm(face.evaluate(pose) - truth, axis=1).max() / face.diagonal
        self.assertAlmostEqual(state.max_error, error, delta=1e-3 * error)
        self.assertGreater(error, 0.01)  # linear blendshapes have no crease
        colours = np.empty(4 * face.vertex_count, np.float32)
        previews[1].data.color_attributes[face_preview.ATTRIBUTE].data.foreach_get("color", colours)
        self.assertGreater(len(np.unique(colours.reshape(-1, 4), axis=0)), 5)
        bpy.data.objects["rig"].animation_data.action = bpy.data.actions["nod"]
        for frame in 11, 17:
            bpy.context.scene.frame_set(frame)
            shown = np.array([vertex.co for vertex in previews[0].data.vertices])
            played = face.evaluate(SceneChannels(settings.controls).read())
            np.testing.assert_allclose(shown, played, atol=1e-6)
        face_preview.remove_handlers()

    def check_window(self, settings):
        """The buttons, without a window to press them in."""
        import facebaker_blender

        bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        facebaker_blender.register()
        try:
            chosen = bpy.context.scene.facebaker
            for scene_object in bpy.context.scene.objects:
                scene_object.select_set(True)
            self.assertEqual(bpy.ops.facebaker.choose(), {"FINISHED"})
            self.assertEqual(bpy.ops.facebaker.find(), {"FINISHED"})
            self.assertEqual([item.name for item in chosen.controls], [c.name for c in settings.controls])
            chosen.out, chosen.recipe, chosen.rig_budget, chosen.workers = "//window.fbk", "linear", 100, 1
            self.assertEqual(bpy.ops.facebaker.bake(), {"FINISHED"})
            from facebaker_blender import window_errors, window_jobs

            job = window_jobs.job_of(bpy.context)
            with self.assertRaisesRegex(RuntimeError, "is running"):
                bpy.ops.facebaker.bake()
            self.assertIn("is running", window_errors.problem_of("bake"))
            self.assertTrue(job.process.wait(200))
            self.assertIsNone(window_jobs.watch())
            self.assertIsNotNone(job.process.document, job.process.log.read_text())
            self.assertTrue(job.process.progress.finished)
            self.check_result(job)
            self.assertEqual(bpy.ops.facebaker.show(), {"FINISHED"})
            self.assertIn("times faster", chosen.measured)
            self.check_replacing(chosen)
            self.check_pages(job)
            chosen.rig_budget = 120  # other poses, of the same scene
            self.assertEqual(bpy.ops.facebaker.bake(), {"FINISHED"})
            self.assertTrue(job.process.wait(200))
            self.assertEqual((job.process.failure, window_errors.problem_of("bake")), ("", ""))
        finally:
            facebaker_blender.unregister()

    def check_result(self, job):
        """The first line is the tool's verdict."""
        first, second = result_lines(job.process.document)[:2]
        self.assertEqual(first, job.process.document["verdict"])
        self.assertRegex(first, r"^Worst vertex of \d+ frames: off by [\d.e+-]+ mm")
        self.assertRegex(second, r"^\d+ kB, trained on \d+ poses$")

    def check_replacing(self, chosen):
        """A face that is shown again takes the place of the one that is shown; its errors follow at once."""
        scene = bpy.context.scene
        (shown,) = previews_in(scene)
        shown.location.x += 2
        name, place, meshes = shown.name, shown.location.copy(), len(bpy.data.meshes)
        chosen.colours = True
        copies = len([found for found in bpy.data.objects if found.name.endswith("as baked")])
        self.assertEqual(bpy.ops.facebaker.show(), {"FINISHED"})
        (shown,) = previews_in(scene)
        self.assertEqual((shown.name, shown.location), (name, place))
        self.assertEqual(len(bpy.data.meshes), meshes)
        self.assertEqual(len([found for found in bpy.data.objects if found.name.endswith("as baked")]), copies)
        self.assertEqual([slot.material.name for slot in shown.material_slots], ["FaceBaker error"])
        state = face_preview.preview_of(shown)
        chosen.red_from = 250.0
        self.assertAlmostEqual(shown[face_preview.SCALE] * state.face.diagonal, 0.25, 5)
        bpy.data.objects["face"].data.shape_keys.key_blocks["smile.L"].value = 1.0
        bpy.data.objects["face"].data.shape_keys.key_blocks["smile.R"].value = 0.9
        bpy.context.view_layer.update()
        self.assertRegex(state.max_length, r"^\d+ mm$")
        before = state.max_error
        bpy.context.view_layer.update()
        bpy.data.objects["face"].data.shape_keys.key_blocks["smile.R"].value = 0.1
        bpy.context.view_layer.update()
        self.assertLess(state.max_error, 0.5 * before)
        chosen.colours = False
        self.assertEqual([slot.material for slot in shown.material_slots], [None])

    def check_pages(self, job):
        """Report and viewer; the tool that is tested may have been built without the viewer."""
        from facebaker_blender import window_errors, window_jobs

        with mock.patch("webbrowser.open", return_value=True) as opened:
            self.assertEqual(bpy.ops.facebaker.report(), {"FINISHED"})
        opened.assert_called_once_with(job.report_page.as_uri())
        self.assertTrue(html.escape(job.process.document["verdict"]) in job.report_page.read_text())
        with mock.patch("webbrowser.open", return_value=False):
            with self.assertRaisesRegex(RuntimeError, "no browser was found; the report is /"):
                bpy.ops.facebaker.report()
        self.assertEqual(bpy.ops.facebaker.view(), {"FINISHED"})
        end = time.monotonic() + 20
        while window_jobs.viewer.running and not window_jobs.viewer.address and time.monotonic() < end:
            time.sleep(0.05)
        if window_jobs.viewer.address:
            self.assertIsNotNone(window_jobs.watch())
            self.assertEqual(bpy.ops.facebaker.end_viewer(), {"FINISHED"})
        else:
            window_jobs.watch()
            self.assertIn("no viewer: name a program", window_errors.problem_of("face"))
        self.assertFalse(window_jobs.viewer.running)

    def test_a_killed_bake_goes_on(self):
        out = self.folder / "killed.fbk"
        bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        settings, _ = found()
        options = BakeOptions("compact", rig_budget=1000, workers=1, epochs=20)
        settings = BakeSettings("face", settings.meshes, settings.controls, "rig", bake=options)
        job = BakeJob(out)
        job.start(settings, find_tool())
        while job.process.poll() and not job.process.progress.finished:
            time.sleep(0.02)
        self.assertTrue(job.process.running, job.process.log.read_text())
        os.killpg(json.loads((job.folder / "process.json").read_text())["process"], signal.SIGKILL)
        job.process.wait(20)
        later = BakeJob(out)  # another session of Blender
        self.assertTrue(later.process.unfinished)
        later.go_on()
        self.assertTrue(later.process.wait(300))
        self.assertIsNotNone(later.process.document, later.process.log.read_text())
        self.assertFalse(later.process.unfinished)
        self.assertTrue(out.is_file())

    def test_ctrl_c_ends_the_bake_too(self):
        out = self.folder / "stopped.fbk"
        words = ["bake", "--out", str(out), "--recipe", "linear", "--rig-budget", "2000"]
        command = [this_blender().program, "-b", self.scene, "--factory-startup", "-P", HEADLESS, "--", *words]
        started = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        state = self.folder / "stopped.blender" / "process.json"
        while started.poll() is None and not state.is_file():
            time.sleep(0.1)
        time.sleep(0.5)
        started.send_signal(signal.SIGINT)
        printed = started.communicate(timeout=60)[1]
        self.assertEqual(started.returncode, 1, printed)
        self.assertIn("run the same command to go on", printed)
        self.assertTrue(BakeJob(out).process.unfinished)
        copied = BakeJob(out).scene.stat().st_mtime_ns
        self.headless(*words)
        self.assertTrue(out.is_file())
        self.assertEqual(BakeJob(out).scene.stat().st_mtime_ns, copied)  # went on with the same copy

    def test_failures_are_told(self):
        printed = self.headless("bake", "--out", self.folder / "x.fbk", "--mesh", "nobody", ends=1)
        self.assertIn('no object "nobody"', printed)
        self.assertIn("ends in .fbk", self.headless("bake", "--out", self.folder / "x.txt", ends=1))
        broken = self.folder / "broken.json"
        settings, _ = found()
        save_settings(settings, broken)
        broken.write_text(broken.read_text().replace('"smile.L"', '"frown.L"'))
        printed = self.headless("bake", "--settings", broken, "--out", self.folder / "x.fbk", ends=1)
        self.assertIn('no shape key "frown.L"', printed)
        self.assertFalse((self.folder / "x.fbk").exists())
