import contextlib
import ctypes
import gc
import inspect
import os
import pathlib
import pickle
import re
import threading
import unittest

try:
    import numpy
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

import facebaker
from facebaker._interop import fb_load_desc
from facebaker._library import library

FIXTURE = pathlib.Path(os.environ["FB_FIXTURE"])


def random_poses(face, count):
    low, high = face.ranges.T
    return numpy.random.default_rng(1).uniform(low, high, (count, face.control_count)).astype(numpy.float32)


class AllocatorFigures(ctypes.Structure):
    """glibc's struct mallinfo2."""

    _fields_ = [
        (name, ctypes.c_size_t)
        for name in "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost".split()
    ]


def allocated_bytes():
    libc = ctypes.CDLL(None)
    if not hasattr(libc, "mallinfo2"):
        raise unittest.SkipTest("the C library does not say how much is allocated")
    libc.mallinfo2.restype = AllocatorFigures
    figures = libc.mallinfo2()
    return figures.uordblks + figures.hblkhd


class FaceTest(unittest.TestCase):
    def setUp(self):
        self.face = facebaker.load(FIXTURE)

    def test_what_is_in_it(self):
        face = self.face
        self.assertEqual(face.name, "tiny")
        self.assertEqual((face.units, face.up_axis), ("cm", "y"))
        self.assertEqual(face.names, ["jaw_open", "mouth_side", "brow_raise", "lid_close", "nose_wrinkle"])
        self.assertEqual(face.controls[2], ("brow_raise", "brow", 0, 1, 0.25))
        self.assertEqual(face.ranges.shape, (5, 2))
        self.assertEqual(face.ranges[3].tolist(), [0, 2])
        self.assertEqual(face.rest_controls.tolist(), [0, 0, 0.25, 0, 0])
        self.assertEqual(face.rest_positions.shape, (30, 3))
        self.assertEqual(face.polygon_sizes.sum(), len(face.polygon_corners))
        self.assertEqual(face.polygon_sizes[-2:].tolist(), [3, 5])
        self.assertEqual(face.polygon_corners[-5:].tolist(), [29, 28, 22, 16, 17])
        self.assertEqual(face.uvs.shape, (60, 2))
        self.assertEqual(face.tangent_signs.shape, (30,))
        self.assertEqual(face.uv_corners[-5:].tolist(), [59, 58, 52, 46, 47])
        self.assertEqual(face.provenance["recipe"], "tiny")
        self.assertGreater(face.diagonal, 0)
        self.assertGreater(face.runtime_bytes, 0)
        version = pathlib.Path(__file__).parents[3] / "VERSION"
        self.assertEqual(facebaker.__version__, version.read_text().strip())

    def test_an_archive_without_provenance(self):
        text = (pathlib.Path(__file__).parents[3] / "core/archive/EXAMPLE.md").read_text()
        dump = re.findall(r"^[0-9a-f]{4}((?:  ?[0-9a-f]{2})+)$", text, re.MULTILINE)
        face = facebaker.load(bytes.fromhex("".join(dump)))
        self.assertEqual(face.name, "tri")
        self.assertEqual(face.provenance, {})

    def test_rest_is_exact_and_a_control_moves_vertices(self):
        face = self.face
        self.assertTrue(numpy.array_equal(face.evaluate(face.rest_controls), face.rest_positions))
        pose = face.rest_controls.copy()
        pose[face.find("jaw_open")] = 1
        self.assertFalse(numpy.array_equal(face.evaluate(pose), face.rest_positions))

    def test_poses_are_blended_and_controls_found_by_hash(self):
        face = self.face
        self.assertEqual(face.find_hash(0x251683C4C174B423), face.find("jaw_open"))  # as `facebaker header` writes it
        with self.assertRaises(facebaker.NotFoundError):
            face.find_hash(42)
        first, other = random_poses(face, 2)
        self.assertTrue(numpy.array_equal(face.blend(first, other, 0), numpy.clip(first, *face.ranges.T)))
        half = face.blend(first, other, 0.5)
        self.assertLess(abs(half - (first + other) / 2).max(), 1e-5)
        self.assertTrue(numpy.array_equal(face.blend(first, None, 1), first))  # no control of this face has a partner
        with self.assertRaises(facebaker.NotFiniteError):
            face.blend(first * numpy.nan, None, 0.5)

    def test_other_outputs(self):
        face = self.face
        poses = random_poses(face, 6)
        positions = face.evaluate_batch(poses)
        normals = numpy.empty_like(positions)
        tangents = numpy.empty_like(positions)
        baked = face.evaluate_batch(poses, normals=normals, tangents=tangents, baked_order=True)
        self.assertTrue(numpy.array_equal(baked, positions[:, face.vertex_order]))
        self.assertTrue(numpy.allclose(numpy.linalg.norm(normals, axis=2), 1, atol=1e-6))
        self.assertTrue(numpy.allclose(numpy.linalg.norm(tangents, axis=2), 1, atol=1e-5))
        self.assertTrue(numpy.allclose((normals * tangents).sum(axis=2), 0, atol=1e-5))
        halves = face.evaluate_batch(poses, dtype=numpy.float16)
        self.assertTrue(numpy.array_equal(halves, positions.astype(numpy.float16)))
        self.assertEqual(face.regions, ("face", "brow"))
        self.assertTrue(numpy.array_equal(face.evaluate_batch(poses, regions=face.regions), positions))
        self.assertFalse(numpy.array_equal(face.evaluate_batch(poses, regions=[]), positions))
        self.assertIn(face.instruction_set, ("scalar", "sse2", "avx2", "avx-vnni", "avx512-vnni", "neon", "neon-dot"))
        for wrong in ({"dtype": numpy.float64}, {"normals": normals[0]}, {"regions": ["nose"]}):
            with self.assertRaises(ValueError):
                face.evaluate_batch(poses, **wrong)

    def test_coefficients_times_basis(self):
        face = self.face
        for pose in random_poses(face, 3):
            weights = face.coefficients(pose)
            moved = numpy.zeros(3 * face.vertex_count, numpy.float32)
            for rows, columns, values in face.basis():
                moved[rows] = weights[columns] @ values
            positions = face.evaluate(pose)[face.vertex_order]
            rest = face.rest_positions[face.vertex_order]
            self.assertTrue(numpy.allclose(rest + moved.reshape(-1, 3), positions, atol=1e-3))
        self.assertFalse(face.coefficients({}).any())

    def test_a_pose_by_names(self):
        face = self.face
        pose = face.rest_controls.copy()
        pose[face.find("mouth_side")] = -0.5
        self.assertEqual(face.pose({"mouth_side": -0.5}).tolist(), pose.tolist())
        self.assertTrue(numpy.array_equal(face.evaluate({"mouth_side": -0.5}), face.evaluate(pose)))
        self.assertTrue(numpy.array_equal(face.evaluate({}), face.rest_positions))
        with self.assertRaisesRegex(facebaker.Error, "jaw_open"):
            face.evaluate({"jaw_opem": 1})

    def test_the_program_of_the_readme(self):
        readme = (pathlib.Path(__file__).parents[3] / "README.md").read_text()
        program = readme.split("```python\n")[1].split("```")[0]
        scope = {}
        exec(program.replace("build/quickstart/sample.fbk", str(FIXTURE)), scope)
        self.assertTrue(numpy.array_equal(scope["positions"], self.face.evaluate({"jaw_open": 0.7})))

    def test_batches_equal_single_poses(self):
        face = self.face
        poses = random_poses(face, 20)
        single = numpy.stack([face.evaluate(pose) for pose in poses])
        for threads in 0, 1, 3:
            self.assertTrue(numpy.array_equal(face.evaluate_batch(poses, threads), single))
        with self.assertRaisesRegex(ValueError, "-1 threads"):
            face.evaluate_batch(poses, -1)
        out = numpy.zeros((20, 30, 3), numpy.float32)
        self.assertIs(face.evaluate_batch(poses[:, ::-1][:, ::-1].astype(float), out=out), out)
        self.assertTrue(numpy.array_equal(out, single))
        self.assertEqual(face.evaluate_batch(poses[:0]).shape, (0, 30, 3))

    def test_many_faces_in_one_call(self):
        face, other = self.face, facebaker.load(FIXTURE)
        poses = random_poses(face, 6)
        items = [(face, poses), (other, poses[:1]), (face, poses[:0]), (face, poses[2:4].tolist())]
        for threads in 0, 1, 3:
            for positions, (_, controls) in zip(facebaker.evaluate_many(items, threads), items):
                expected = face.evaluate_batch(numpy.reshape(controls, (-1, 5)))
                self.assertTrue(numpy.array_equal(positions, expected))
        self.assertEqual(facebaker.evaluate_many([]), [])
        out = [numpy.zeros((1, 30, 3), numpy.float32), numpy.zeros((1, 30, 3), numpy.float32)]
        results = facebaker.evaluate_many([(face, poses[:1]), (other, poses[1:2])], out=out)
        self.assertTrue(results[0] is out[0] and results[1] is out[1] and out[0].any() and out[1].any())
        broken = poses.copy()
        broken[4, 1] = numpy.nan
        for wrong, message in (
            ([(face, poses), (other, broken)], "item 1: .*mouth_side"),
            ([(face, poses), (other, poses[:, 1:])], "item 1: controls have shape"),
        ):
            with self.assertRaisesRegex((ValueError, facebaker.NotFiniteError), message):
                facebaker.evaluate_many(wrong)
        with self.assertRaisesRegex(ValueError, "item 0: out must be a writable"):
            facebaker.evaluate_many([(face, poses)], out=out[:1])
        with self.assertRaisesRegex(ValueError, "out: 2 for 1 items"):
            facebaker.evaluate_many([(face, poses)], out=out)
        with self.assertRaisesRegex(ValueError, "-1 threads"):
            facebaker.evaluate_many(items, -1)

    def test_many_faces_with_normals_and_levels(self):
        face, other = self.face, facebaker.load(FIXTURE.with_name("levels.fbk"))
        items = [(face, random_poses(face, 1)), (other, random_poses(other, 3)), (other, random_poses(other, 1))]
        lods = [0, 1.5, 9]
        normals = [None] + [numpy.empty((len(poses), other.vertex_count, 3), numpy.float32) for _, poses in items[1:]]
        results = facebaker.evaluate_many(items, 2, normals=normals, lods=lods)
        for (posed, poses), lod, positions, given in zip(items, lods, results, normals):
            expected = numpy.empty((len(poses), posed.vertex_count, 3), numpy.float32)
            numpy.testing.assert_array_equal(positions, posed.evaluate_batch(poses, normals=expected, lod=lod))
            if given is not None:
                numpy.testing.assert_array_equal(given, expected)
        few = facebaker.evaluate_many(items, lods=lods, level_only=True)
        for (posed, poses), lod, positions in zip(items, lods, few):
            alone = posed.evaluate_batch(poses, lod=lod, baked_order=True, level_only=True)
            numpy.testing.assert_array_equal(positions, alone)
        self.assertLess(few[2].shape[1], few[1].shape[1])
        with self.assertRaisesRegex(ValueError, "item 1: normals must be a writable"):
            facebaker.evaluate_many(items, normals=[None, normals[2], None])
        with self.assertRaisesRegex(ValueError, "lods: 2 for 3 items"):
            facebaker.evaluate_many(items, lods=lods[:2])
        self.assert_error("FB_ERROR_INVALID_ARGUMENT", "item 2: ", facebaker.evaluate_many, items, lods=[0, 0, -1])

    def test_instances_share_working_memory(self):
        """A face's memory of its own would be 4 kB each for the fixture."""
        face, count = facebaker.load(FIXTURE.with_name("levels.fbk")), 100
        items = [(face, poses[None]) for poses in random_poses(face, count)]
        arrays = numpy.empty((2, count, 1, face.vertex_count, 3), numpy.float32)
        facebaker.evaluate_many(items[:2], 2, arrays[0, :2], normals=arrays[1, :2])
        before = allocated_bytes()
        for _ in range(2):
            facebaker.evaluate_many(items, 2, arrays[0], normals=arrays[1])
        self.assertLess(allocated_bytes() - before, 64 << 10)
        single = facebaker.load(FIXTURE.with_name("levels.fbk"))
        before = allocated_bytes()
        with contextlib.ExitStack() as borrowed:
            for _ in range(count):
                borrowed.enter_context(single._scratches.borrow())
            self.assertGreater(allocated_bytes() - before, 200 << 10)  # what is measured includes it

    def test_working_memory_serves_what_needs_less(self):
        pool = self.face._scratches
        with pool.borrow() as small, pool.borrow() as other:
            self.assertNotEqual(small.value, other.value)
        with pool.borrow(3) as three:
            pass
        self.assertEqual(len(pool._free), 1)  # in place of the two
        with pool.borrow(2) as again, pool.borrow(3, several=True) as several:
            self.assertEqual(again.value, three.value)
        self.assertEqual([(scratch.workers, scratch.several) for scratch in pool._free], [(3, True), (3, False)])
        with pool.borrow(2, several=True) as again:
            self.assertEqual(again.value, several.value)

    def test_clamping_is_counted(self):
        self.face.evaluate([9, -9, 0.5, 0, 0])
        self.assertEqual(self.face.clamped_count, 2)

    def test_bytes_load_like_a_path(self):
        with FIXTURE.open("rb") as file:
            faces = [facebaker.load(source) for source in (FIXTURE.read_bytes(), bytearray(FIXTURE.read_bytes()), file)]
        for face in faces:
            self.assertTrue(numpy.array_equal(face.rest_positions, self.face.rest_positions))

    def test_views_are_read_only_and_outlive_the_face(self):
        rest = facebaker.load(FIXTURE).rest_positions
        gc.collect()
        self.assertTrue(numpy.array_equal(rest, self.face.rest_positions))
        with self.assertRaises(ValueError):
            rest[0] = 0

    def test_threads_may_share_a_face(self):
        poses = random_poses(self.face, 8)
        expected = self.face.evaluate_batch(poses)
        wrong = []

        def work(index):
            for _ in range(50):
                if not numpy.array_equal(self.face.evaluate(poses[index]), expected[index]):
                    wrong.append(index)

        threads = [threading.Thread(target=work, args=(index,)) for index in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_expected_errors(self):
        face = facebaker.load(FIXTURE.with_name("character.fbk"))
        self.assertEqual(face.error_regions, ("mouth", "brows, upper left"))
        self.assertEqual(numpy.bincount(face.error_vertex_regions).tolist(), [18, 12])
        poses = random_poses(face, 5)
        all_poses = face.expected_error(poses)
        self.assertEqual((all_poses.face.shape, all_poses.regions.shape, all_poses.outside.shape), ((5,), (5, 2), (5,)))
        for pose, controls in enumerate(poses):
            one = face.expected_error(controls)
            self.assertEqual(one.face, all_poses.face[pose])
            self.assertEqual(one.regions.tolist(), all_poses.regions[pose].tolist())
            self.assertEqual(one.outside, all_poses.outside[pose])
            self.assertAlmostEqual(one.face**2, (18 * one.regions[0] ** 2 + 12 * one.regions[1] ** 2) / 30, places=5)
        self.assertEqual(face.expected_error({}).outside, 0)
        self.assertEqual(face.expected_error({"jaw_open": 0.5, "mouth_side": 0.5}).outside, 2)
        self.assertEqual((self.face.error_regions, len(self.face.error_vertex_regions)), ((), 0))
        self.assert_error("FB_ERROR_INVALID_ARGUMENT", "no expected errors", self.face.expected_error, {})

    def assert_error(self, name, part, call, *arguments, **options):
        with self.assertRaises(facebaker.Error) as caught:
            call(*arguments, **options)
        self.assertEqual(caught.exception.status_name, name)
        self.assertIn(part, str(caught.exception))

    def test_errors_carry_a_status(self):
        self.assert_error("FB_ERROR_NOT_FOUND", "/nowhere/face.fbk", facebaker.load, "/nowhere/face.fbk")
        self.assert_error("FB_ERROR_IO", "directory", facebaker.load, "/")
        self.assert_error("FB_ERROR_NOT_AN_ARCHIVE", "", facebaker.load, b"GIF89a")
        self.assert_error("FB_ERROR_CORRUPT", "", facebaker.load, FIXTURE.read_bytes()[:-1])
        self.assert_error("FB_ERROR_NOT_FOUND", '"jaw_open"', self.face.find, "jaw_opne")
        self.assert_error("FB_ERROR_NOT_FINITE", '"brow_raise"', self.face.evaluate, [0, 0, float("nan"), 0, 0])

    def test_displacements_are_from_rest(self):
        poses = random_poses(self.face, 3)
        moved = self.face.evaluate_batch(poses, displacements=True)
        numpy.testing.assert_array_equal(moved, self.face.evaluate_batch(poses) - self.face.rest_positions)

    def test_levels_of_detail(self):
        face = facebaker.load(FIXTURE.with_name("levels.fbk"))
        self.assertEqual(self.face.level_count, 1)
        self.assertEqual(face.level_count, 3)
        poses = random_poses(face, 3)
        whole, coarsest = (face.evaluate_batch(poses, lod=lod) for lod in (0, 2))
        numpy.testing.assert_array_equal(whole[0], face.evaluate(poses[0]))
        self.assertFalse(numpy.array_equal(whole, coarsest))
        numpy.testing.assert_array_equal(coarsest, face.evaluate_batch(poses, lod=7))
        numpy.testing.assert_allclose(face.evaluate_batch(poses, lod=1.9999), coarsest, atol=1e-3 * face.diagonal)
        self.assert_error("FB_ERROR_INVALID_ARGUMENT", "level of detail", face.evaluate_batch, poses, lod=-1)
        for lod in 0, 1, 1.5, 2, 9:
            few = face.evaluate_batch(poses, lod=lod, baked_order=True, level_only=True)
            all_vertices = face.evaluate_batch(poses, lod=lod, baked_order=True)
            self.assertEqual(few.shape[1], face.levels[min(int(lod), 2)].vertices)
            numpy.testing.assert_array_equal(few, all_vertices[:, : few.shape[1]])
        self.assert_error("FB_ERROR_INVALID_ARGUMENT", "order", face.evaluate_batch, poses, lod=1, level_only=True)

    def test_limits_of_loading(self):
        for source in FIXTURE, FIXTURE.read_bytes():
            self.assert_error("FB_ERROR_LIMIT", "30 vertices", facebaker.load, source, max_vertices=29)
            self.assertEqual(facebaker.load(source, max_vertices=30, note=self.fail).vertex_count, 30)
        defaults = library.filled(fb_load_desc)
        for name, parameter in inspect.signature(facebaker.load).parameters.items():
            if name.startswith("max_"):
                self.assertEqual(parameter.default, getattr(defaults, name), name)

    def test_repr_tells(self):
        for source in FIXTURE, FIXTURE.read_bytes():
            said = repr(facebaker.load(source))
            self.assertRegex(said, r"^<facebaker.Face 'tiny' from .+: 5 controls, 30 vertices, \d+ coefficients>$")
        self.assertIn(f"{len(FIXTURE.read_bytes())} bytes", said)

    def test_pickled_faces(self):
        for source in FIXTURE, FIXTURE.read_bytes():
            face = facebaker.load(source)
            again = pickle.loads(pickle.dumps(face))
            self.assertEqual(again.source, face.source)
            self.assertTrue(numpy.array_equal(again.evaluate({"jaw_open": 1}), face.evaluate({"jaw_open": 1})))
        self.assertLess(len(pickle.dumps(self.face)), 500)
        control = facebaker.Control("a", "b", -1, 1, 0, unit="degrees", mirror="c")
        again = pickle.loads(pickle.dumps(control))
        self.assertEqual((again, again.unit, again.mirror), (control, "degrees", "c"))

    def test_closing(self):
        with facebaker.load(FIXTURE) as face:
            rest, expected = face.rest_positions, face.evaluate({})
        for call in (lambda: face.rest_positions, lambda: face.evaluate({}), lambda: face.materials):
            with self.assertRaisesRegex(ValueError, "'tiny' is closed"):
                call()
        gc.collect()
        self.assertTrue(numpy.array_equal(rest, expected))
        face.close()

    def test_triangles(self):
        face = self.face
        self.assertEqual(len(face.triangles), (face.polygon_sizes - 2).sum())
        self.assertEqual(face.triangles[-3:].tolist(), [[29, 28, 22], [29, 22, 16], [29, 16, 17]])
        self.assertTrue(numpy.array_equal(face.polygon_corners[face.triangle_corners], face.triangles))
        self.assertEqual(face.uvs[face.uv_corners[face.triangle_corners]].shape, (len(face.triangles), 3, 2))
        # The area of the polygons is that of the triangles.
        a, b, c = numpy.moveaxis(face.rest_positions[face.triangles].astype(float), 1, 0)
        normals, first = numpy.cross(b - a, c - a), 0
        for polygon, size in enumerate(face.polygon_sizes.tolist()):
            corners = face.rest_positions[face.polygon_corners[face.polygon_sizes[:polygon].sum() :][:size]].astype(
                float
            )
            whole = numpy.cross(corners, numpy.roll(corners, -1, 0)).sum(0)
            numpy.testing.assert_allclose(normals[first : first + size - 2].sum(0), whole, atol=1e-4)
            first += size - 2
        with self.assertRaises(ValueError):
            face.triangles[0] = 0

    def test_a_character(self):
        face = facebaker.load(FIXTURE.with_name("character.fbk"))
        document = facebaker.inspect(face).document
        self.assertEqual([mesh.name for mesh in face.meshes], [mesh["name"] for mesh in document["meshes"]])
        self.assertEqual(sum(mesh.vertices for mesh in face.meshes), face.vertex_count)
        self.assertEqual([m.polygons for m in face.meshes], [sum(r.polygons for r in m.materials) for m in face.meshes])
        self.assertGreater(len(face.materials), 0)
        self.assertTrue(all(t.image < len(face.images) for m in face.materials for t in m.textures))
        self.assertEqual(face.certificate, document["certificate"] or {})
        self.assertEqual(face.licence, document["licence"])
        self.assertEqual(self.face.thumbnail, None)
        mesh = face.meshes[1]
        self.assertEqual(face.find_mesh(mesh.name), 1)
        self.assert_error("FB_ERROR_NOT_FOUND", mesh.name, face.find_mesh, "nose ring")
        poses = random_poses(face, 4)
        both, one = face.evaluate_batch(poses), face.evaluate_batch(poses, meshes=[mesh.name])
        self.assertTrue(numpy.array_equal(one[:, mesh.vertex_slice], both[:, mesh.vertex_slice]))
        self.assertFalse(one[:, face.meshes[0].vertex_slice].any())
        sockets = numpy.empty((4, len(face.sockets), 3, 4), numpy.float32)
        channels = numpy.empty((4, len(face.channels)), numpy.float32)
        bounds = numpy.empty((4, 2, 3), numpy.float32)
        errors = numpy.empty((4, 1 + len(face.error_regions)), numpy.float32)
        outside = numpy.empty(4, numpy.uint32)
        face.evaluate_batch(
            poses, sockets=sockets, channels=channels, bounds=bounds, expected_errors=errors, outside=outside
        )
        self.assertTrue(numpy.array_equal(bounds, numpy.stack([both.min(1), both.max(1)], 1)))
        turns = sockets[..., :3] @ sockets[..., :3].swapaxes(2, 3)
        numpy.testing.assert_allclose(turns, numpy.broadcast_to(numpy.eye(3), turns.shape), atol=1e-5)
        for channel, values in zip(face.channels, channels.T):
            self.assertTrue(((values >= channel.minimum) & (values <= channel.maximum)).all())
        expected = face.expected_error(poses)
        self.assertEqual(errors[:, 0].tolist(), expected.face.tolist())
        self.assertEqual(outside.tolist(), expected.outside.tolist())
        at_rest = numpy.empty_like(sockets[:1])
        face.evaluate_batch([face.rest_controls], sockets=at_rest)
        numpy.testing.assert_allclose(at_rest[0], [socket.frame for socket in face.sockets], atol=1e-5)
        self.assertEqual(face.find_socket(face.sockets[0].name), 0)
        self.assertEqual(face.find_channel(face.channels[0].name), 0)

    def test_a_body(self):
        face = facebaker.load(FIXTURE.with_name("body.fbk"))
        self.assertGreater(len(face.joints), 1)
        self.assertEqual(face.find_joint(face.joints[1].name), 1)
        self.assertTrue(all(j.parent is None or j.parent < i for i, j in enumerate(face.joints)))
        joints, weights = face.skin
        self.assertEqual((joints.shape, joints.dtype), ((face.vertex_count, weights.shape[1]), numpy.uint16))
        sums = weights.sum(1)
        self.assertTrue(((abs(sums - 1) < 1e-3) | (sums == 0)).all())
        self.assertIsNone(self.face.skin)

    def test_joints_that_controls_drive(self):
        face = facebaker.load(pathlib.Path(__file__).parents[3] / "tests/golden/2.1/accepted/driven.fbk")
        self.assertEqual([joint.name for joint in face.driven_joints], ["jaw", "tongue", "pin", "lid"])
        self.assertEqual(face.driven_joints[1].parent, 0)
        self.assertEqual(face.driven_joints[1].numbers, ("rotate_x", "rotate_y", "move_z"))
        self.assertEqual(face.driven_joints[3].numbers[-3:], ("pivot_x", "pivot_y", "pivot_z"))
        self.assertEqual([joint.outer_rotations for joint in face.driven_joints], [0, 0, 0, 2])
        self.assertEqual(face.find_driven_joint("pin"), 2)
        joints, weights = face.driven_skin
        self.assertTrue((weights.sum(1) <= 1).all())
        pose = numpy.linspace(0.2, 0.8, face.control_count, dtype=numpy.float32)[None]
        frames = numpy.empty((1, 4, 3, 4), numpy.float32)
        seen = face.evaluate_batch(pose, joints=frames)[0]
        before = face.evaluate_batch(pose, unskinned=True)[0]
        moved = before.astype(float)
        for joint, frame in enumerate(frames[0].astype(float)):
            rest = numpy.vstack([face.driven_joints[joint].rest, [0, 0, 0, 1]]).astype(float)
            at = numpy.c_[before, numpy.ones(len(before))] @ (frame @ numpy.linalg.inv(rest)).T - before
            moved += numpy.where(joints == joint, weights, 0).sum(1)[:, None] * at
        numpy.testing.assert_allclose(seen, moved, atol=1e-4)
        self.assertGreater(abs(seen - before).max(), 0.1)
        self.assertEqual(self.face.driven_joints, ())
        self.assertIsNone(self.face.driven_skin)

    def test_exact_poses_and_levels(self):
        exact = facebaker.load(FIXTURE.with_name("exact.fbk"))
        self.assertGreater(len(exact.exact_poses), 0)
        self.assertEqual(exact.exact_poses[0].controls.shape, (exact.control_count,))
        face = facebaker.load(FIXTURE.with_name("levels.fbk"))
        self.assertEqual(len(face.levels), face.level_count)
        self.assertEqual(face.levels[0].vertices, face.vertex_count)
        self.assertEqual(face.levels[0].polygon_corners.tolist(), face.polygon_corners.tolist())
        for level in face.levels:
            self.assertEqual(level.polygon_sizes.sum(), len(level.polygon_corners))
            self.assertLessEqual(set(level.polygon_corners.tolist()), set(face.vertex_order[: level.vertices].tolist()))
            self.assertEqual(sum(mesh.polygons for mesh in level.meshes), len(level.polygon_sizes))

    def test_names_that_there_are_not(self):
        with self.assertRaisesRegex(ValueError, 'no region "brows"; the closest is "brow"'):
            self.face.evaluate_batch([[0] * 5], regions=["brows"])
        self.assertEqual(self.face.find_region("brow"), 1)

    def test_outputs_without_copies(self):
        out = numpy.empty((30, 3), numpy.float32)
        self.assertIs(self.face.evaluate({"jaw_open": 1}, out), out)
        for wrong in numpy.empty((30, 3)), numpy.empty((3, 30), numpy.float32).T:
            with self.assertRaises(ValueError):
                self.face.evaluate({}, wrong)
        rest = self.face.rest_positions.ctypes.data
        self.assertEqual(rest, self.face.rest_positions.ctypes.data)

    def test_threads_evaluate_at_once(self):
        poses = random_poses(self.face, 40)
        expected = self.face.evaluate_batch(poses)
        start, wrong = threading.Barrier(4), []

        def work():
            start.wait()
            for _ in range(30):
                if not numpy.array_equal(self.face.evaluate_batch(poses, threads=1), expected):
                    wrong.append(1)
                self.face.evaluate([9, 0, 0.25, 0, 0])
                if self.face.clamped_count != 1:
                    wrong.append(2)

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])
        self.face.evaluate({})
        self.assertEqual(self.face.clamped_count, 0)

    def test_wrong_shapes_are_refused(self):
        for controls in [0] * 4, [[0] * 5]:
            with self.assertRaises(ValueError):
                self.face.evaluate(controls)
        for controls in [0] * 5, [[0] * 4]:
            with self.assertRaises(ValueError):
                self.face.evaluate_batch(controls)
        for out in numpy.zeros((1, 30, 3)), numpy.zeros((2, 30, 3), numpy.float32):
            with self.assertRaises(ValueError):
                self.face.evaluate_batch([[0] * 5], out=out)


if __name__ == "__main__":
    unittest.main()
