import inspect
import multiprocessing
import os
import pathlib
import pickle
import threading
import types
import unittest

try:
    import numpy as np
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

import facebaker
from facebaker._choices import control_indices
from facebaker._interop import fb_solve_desc
from facebaker._library import library

FIXTURE = pathlib.Path(os.environ["FB_FIXTURE"])


def pose_of(face, share):
    """So far from rest to ends of ranges, every second control to its minimum if that is not rest."""
    low, high = face.ranges.T
    ends = np.where((np.arange(face.control_count) % 2 == 1) & (low < face.rest_controls), low, high)
    return (face.rest_controls + share * (ends - face.rest_controls)).astype(np.float32)


def solve_elsewhere(solver, targets):
    return solver.solve(targets).controls


class SolverTest(unittest.TestCase):
    def setUp(self):
        self.face = facebaker.load(FIXTURE)
        self.solver = facebaker.Solver(self.face)

    def exactly(self, **options):
        """Options with which little but the targets counts."""
        return {"noise": 1e-4 * self.face.diagonal, "nearness": 0, "sparsity": 0, "max_iterations": 50, **options}

    def assert_near(self, found, expected, share):
        np.testing.assert_allclose(found, expected, atol=share * self.face.diagonal)

    # Derivatives

    def test_derivatives_are_differences_of_poses(self):
        face, pose = self.face, pose_of(self.face, 0.4)
        values = np.empty(self.solver.row_count, np.float32)
        derivatives = self.solver.jacobian(pose, values=values)
        self.assertEqual((derivatives.shape, derivatives.dtype), ((90, 5), np.float32))
        self.assert_near(values, face.evaluate(pose).ravel(), 1e-6)
        for control, (low, high) in enumerate(face.ranges.tolist()):
            step = 2e-3 * (high - low)
            moved = pose.copy()
            moved[control] += step
            difference = (face.evaluate(moved) - face.evaluate(pose)).ravel() / step
            self.assert_near(derivatives[:, control], difference, 0.02)
        np.testing.assert_array_equal(face.jacobian(pose), derivatives)

    def test_chosen_controls_come_in_their_order(self):
        face, pose = self.face, pose_of(self.face, 0.4)
        whole = self.solver.jacobian(pose)
        jaw, brow, lid = (face.find(name) for name in ("jaw_open", "brow_raise", "lid_close"))
        mask = np.arange(5) == lid
        for chosen, columns in (
            (["lid_close", jaw], [lid, jaw]),
            ("brow", [brow]),
            (["lid_close", "brow", "lid_close"], [lid, brow]),
            (np.array([4, 0]), [4, 0]),
            (mask, [lid]),
            (mask.tolist(), [lid]),
            ([], []),
        ):
            np.testing.assert_array_equal(face.find_controls(chosen), columns)
            found = self.solver.jacobian(pose, chosen)
            self.assertEqual(found.shape, (90, len(columns)))
            np.testing.assert_array_equal(found, whole[:, columns])
            np.testing.assert_array_equal(face.jacobian(pose, None, chosen), found)
            out = np.full_like(found, np.nan)
            self.assertIs(self.solver.jacobian(pose, chosen, out=out), out)
            np.testing.assert_array_equal(out, found)

    def test_what_names_a_control_and_a_group_is_both(self):
        controls = [
            facebaker.Control("jaw", "mouth"),
            facebaker.Control("lip", "jaw"),
            facebaker.Control("brow", "upper"),
        ]
        face = types.SimpleNamespace(controls=controls, control_count=3)
        np.testing.assert_array_equal(control_indices(face, ["brow", "jaw"], "chosen"), [2, 0, 1])
        np.testing.assert_array_equal(control_indices(face, ["upper", "mouth"], "chosen"), [2, 0])

    def test_sparse_columns_hold_what_dense_ones_do(self):
        face = facebaker.load(FIXTURE.with_name("driven.fbk"))
        joints = [joint.name for joint in face.driven_joints]
        solver = facebaker.Solver(face, [20, 3], sockets=range(len(face.sockets)), joints=joints)
        self.assertEqual(solver.row_count, 6 + 12 * (len(face.sockets) + len(joints)))
        for share in 0.4, 0.0, 0.7:
            pose = pose_of(face, share)
            for chosen in None, [3, 0], [], np.arange(face.control_count)[::-1]:
                dense = solver.jacobian(pose, chosen)
                data, rows, starts = solver.jacobian(pose, chosen, sparse=True)
                self.assertEqual((data.dtype, rows.dtype, starts.dtype), (np.float32, np.int32, np.int64))
                self.assertEqual((len(data), len(starts)), (np.count_nonzero(dense), dense.shape[1] + 1))
                again = np.zeros_like(dense)
                for column, (begin, end) in enumerate(zip(starts, starts[1:])):
                    self.assertTrue((np.diff(rows[begin:end]) > 0).all())
                    again[rows[begin:end], column] = data[begin:end]
                np.testing.assert_array_equal(again, dense)

    def test_scipy_takes_sparse_columns(self):
        try:
            from scipy.sparse import csc_matrix
        except ImportError:
            self.skipTest("SciPy is not installed")
        pose = pose_of(self.face, 0.4)
        dense = self.solver.jacobian(pose)
        matrix = csc_matrix(self.solver.jacobian(pose, sparse=True), shape=dense.shape)
        np.testing.assert_array_equal(matrix.toarray(), dense)

    def test_points_are_sums_of_vertices(self):
        face, pose = self.face, pose_of(self.face, 0.3)
        corners = face.triangles[[0, 7, 20]]
        weights = np.array([[0.5, 0.25, 0.25], [0.1, 0.2, 0.7], [1, 0, 0]], np.float32)
        values = np.empty(9, np.float32)
        solver = facebaker.Solver(face, corners, vertex_weights=weights)
        derivatives = solver.jacobian(pose, values=values)
        sums = (face.evaluate(pose)[corners] * weights[..., None]).sum(1)
        self.assert_near(values.reshape(3, 3), sums, 1e-6)
        of_vertices = self.solver.jacobian(pose).reshape(30, 3, 5)[corners]
        np.testing.assert_allclose(
            derivatives.reshape(3, 3, 5), (of_vertices * weights[..., None, None]).sum(1), atol=1e-5
        )
        np.testing.assert_array_equal(face.jacobian(pose, corners, vertex_weights=weights), derivatives)
        np.testing.assert_array_equal(face.jacobian(pose, [7, 3])[:3], self.solver.jacobian(pose)[21:24])

    def test_the_way_down_where_the_pose_bends(self):
        face = facebaker.load(FIXTURE.with_name("character.fbk"))
        solver = facebaker.Solver(face)
        up, down = solver.jacobian({}), solver.jacobian({}, downwards=np.ones(face.control_count, bool))
        inside = np.flatnonzero((face.ranges[:, 0] < face.rest_controls) & (face.rest_controls < face.ranges[:, 1]))
        self.assertGreater(len(inside), 0)
        for control in inside:
            for derivatives, step in (up, 1e-3), (down, -1e-3):
                moved = face.rest_controls.copy()
                moved[control] += step
                difference = (face.evaluate(moved) - face.rest_positions).ravel() / step
                np.testing.assert_allclose(derivatives[:, control], difference, atol=0.02 * face.diagonal)

    # Solving

    def test_a_pose_is_found_again(self):
        face, pose = self.face, pose_of(self.face, 0.3)
        targets = face.evaluate(pose)
        targets[2, 1] = np.nan  # not measured
        found = self.solver.solve(targets, start=pose_of(face, 0.25), decided=True, **self.exactly())
        self.assertTrue(found.converged and found.iterations > 0 and found.point_count == 29)
        self.assertLess(found.max_difference, 5e-3 * face.diagonal)
        self.assertLessEqual(found.rms_difference, found.max_difference)
        self.assertTrue(
            np.isnan(found.point_differences[2]) and np.isfinite(np.delete(found.point_differences, 2)).all()
        )
        self.assertEqual(found.point_differences[found.worst_point], np.float32(found.max_difference))
        self.assert_near(np.delete(face.evaluate(found.controls), 2, 0), np.delete(targets, 2, 0), 5e-3)
        self.assertTrue(((found.decided >= 0) & (found.decided <= 1)).all())
        self.assertIsNone(found.motion)
        self.assertIn("29 points", repr(found))
        alone = face.solve(targets, start=pose_of(face, 0.25), **self.exactly())
        np.testing.assert_array_equal(alone.controls, found.controls)
        self.assertIsNone(alone.decided)
        nothing = self.solver.solve(np.full((30, 3), np.nan))
        self.assertEqual((nothing.worst_point, nothing.point_count, nothing.max_difference), (None, 0, 0))
        np.testing.assert_array_equal(nothing.controls, face.rest_controls)

    def test_locked_controls_stay_where_they_start(self):
        face = self.face
        start, targets = pose_of(face, 0.25), face.evaluate(pose_of(face, 0.4))
        brow, lid = face.find("brow_raise"), face.find("lid_close")
        free = [control for control in range(5) if control not in (brow, lid)]
        everything = self.solver.solve(targets, start=start).controls
        self.assertFalse((everything == start).any())
        for options in (
            {"locked": ["brow", "lid_close"]},
            {"movable": free},
            {"movable": [face.names[control] for control in free]},
            {"movable": np.isin(np.arange(5), free)},
            {"movable": [*free, brow], "locked": "brow_raise"},
        ):
            found = self.solver.solve(targets, start=start, **options).controls
            np.testing.assert_array_equal(found[[brow, lid]], start[[brow, lid]])
            self.assertFalse((found[free] == start[free]).any())
        np.testing.assert_array_equal(self.solver.solve(targets, start=start, movable=[]).controls, start)
        np.testing.assert_array_equal(self.solver.solve(targets, before=start, movable=[]).controls, start)

    def test_targets_come_from_spaces_and_units_of_their_own(self):
        face, pose = self.face, pose_of(self.face, 0.25)
        shown = face.evaluate(pose)
        found = self.solver.solve(shown - face.rest_positions, relative=True, start=pose, **self.exactly())
        self.assertLess(found.max_difference, 5e-3 * face.diagonal)
        # In tenths of the unit, z up: to the face by 0.1 (x, z, -y).
        to_face = 0.1 * np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]])
        turned = 10 * np.stack([shown[:, 0], -shown[:, 2], shown[:, 1]], 1)
        found = self.solver.solve(turned, to_face=to_face, start=pose, **self.exactly())
        self.assertLess(found.max_difference, 5e-3 * face.diagonal)
        # And where the head is, is found.
        found = self.solver.solve(turned + 5, to_face=to_face, find_motion=True, start=pose, **self.exactly())
        expected = np.array([[1, 0, 0, 0.5], [0, 1, 0, 0.5], [0, 0, 1, -0.5]])
        np.testing.assert_allclose(found.motion, expected, atol=0.02)
        again = self.solver.solve(
            turned + 5, to_face=to_face, find_motion=True, motion=found.motion, start=found.controls, **self.exactly()
        )
        self.assertLessEqual(again.iterations, found.iterations)
        np.testing.assert_allclose(again.motion, expected, atol=0.02)

    def test_distances_and_frames(self):
        face = facebaker.load(FIXTURE.with_name("character.fbk"))
        pose = pose_of(face, 0.3)
        shown = face.evaluate(pose)
        pairs = [(0, 1), (1, 2), (0, 3)]
        solver = facebaker.Solver(face, [0, 8, 17, 29], pairs=pairs, sockets=[face.sockets[0].name])
        self.assertEqual((solver.point_count, solver.pair_count, solver.frame_count), (4, 3, 1))
        positions = shown[[0, 8, 17, 29]]
        lengths = np.array([np.linalg.norm(positions[a] - positions[b]) for a, b in pairs])
        frames = np.empty((1, len(face.sockets), 3, 4), np.float32)
        face.evaluate_batch([pose], sockets=frames)
        options = {"distances": lengths, "frames": frames[0, :1], "noise": 1e-4 * face.diagonal}
        found = solver.solve(**options, nearness=0, sparsity=0, start=pose_of(face, 0.28))
        self.assertEqual((found.point_count, found.worst_point), (0, None))
        there = face.evaluate(found.controls)[[0, 8, 17, 29]]
        for length, (a, b) in zip(lengths, pairs):
            self.assertAlmostEqual(np.linalg.norm(there[a] - there[b]), length, delta=5e-3 * face.diagonal)
        again = np.empty_like(frames)
        face.evaluate_batch([found.controls], sockets=again)
        np.testing.assert_allclose(again[0, 0], frames[0, 0], atol=0.02 * face.diagonal)
        ignored = solver.solve(**options, distance_weights=np.zeros(3), frame_weights=[0])
        np.testing.assert_array_equal(ignored.controls, face.rest_controls)

    def test_defaults_are_the_library_s(self):
        defaults, said = library.filled(fb_solve_desc), inspect.signature(facebaker.Solver.solve).parameters
        for name in "nearness", "sparsity", "smoothness", "symmetry", "tolerance", "max_iterations", "relative":
            self.assertAlmostEqual(said[name].default, getattr(defaults, name), places=7, msg=name)

    # Clips

    @property
    def beside_noise(self):
        return {"noise": 0.02 * self.face.diagonal, "sparsity": 0, "nearness": 0}

    def clip(self):
        """The controls of a clip, and its positions with noise."""
        shares = 0.25 + 0.2 * np.sin(np.linspace(0, 2 * np.pi, 40))
        controls = np.stack([pose_of(self.face, share) for share in shares])
        noise = np.random.default_rng(1).normal(0, 0.02 * self.face.diagonal, (40, 30, 3))
        return controls, self.face.evaluate_batch(controls) + noise

    def test_a_clip_is_solved_from_pose_to_pose(self):
        controls, targets = self.clip()
        options = {**self.beside_noise, "tolerance": 1e-3, "max_iterations": 40}
        found = self.solver.solve_clip(targets, decided=True, start=controls[0], smoothness=2, **self.beside_noise)
        self.assertEqual(
            (found.controls.shape, found.point_differences.shape, found.decided.shape), ((40, 5), (40, 30), (40, 5))
        )
        self.assertIsNone(found.motions)
        self.assertIn("40 poses", repr(found))
        before, start = None, controls[0]
        for pose in range(40):
            one = self.solver.solve(targets[pose], start=start, before=before, smoothness=2, decided=True, **options)
            np.testing.assert_array_equal(found.controls[pose], one.controls)
            np.testing.assert_array_equal(found.decided[pose], one.decided)
            self.assertEqual(found.max_differences[pose], np.float32(one.max_difference))
            self.assertEqual(found.worst_points[pose], one.worst_point)
            start = before = one.controls

    def test_going_back_brings_a_clip_nearer_to_the_truth(self):
        controls, targets = self.clip()
        truth = self.face.evaluate_batch(controls)
        errors = {}
        for smoothness, backwards in (0, False), (20, False), (20, True):
            found = self.solver.solve_clip(
                targets, smoothness=smoothness, backwards=backwards, start=controls[0], **self.beside_noise
            )
            errors[smoothness, backwards] = np.sqrt(np.mean((self.face.evaluate_batch(found.controls) - truth) ** 2))
        self.assertLess(errors[20, False], 0.75 * errors[0, False])
        self.assertLess(errors[20, True], 0.95 * errors[20, False])

    def test_poses_that_were_not_measured_are_between_their_neighbours(self):
        controls, targets = self.clip()
        targets[17:20] = np.nan
        found = self.solver.solve_clip(targets, smoothness=20, backwards=True, start=controls[0], **self.beside_noise)
        self.assertEqual(found.worst_points[17:20].tolist(), [-1] * 3)
        self.assertTrue(np.isnan(found.point_differences[17:20]).all())
        jaw = found.controls[17:21, self.face.find("jaw_open")]
        self.assertEqual(len(set(np.sign(np.diff(jaw)))), 1, jaw)
        self.assertTrue(np.diff(jaw).all(), jaw)
        with self.assertRaisesRegex(ValueError, "targets: shape"):
            self.solver.solve_clip(targets[0])

    def test_clips_with_motion_and_weights(self):
        controls, targets = self.clip()
        shift = np.linspace(0, 1, 40)[:, None, None] * [1, 2, 3]
        found = self.solver.solve_clip(targets + shift, start=controls[0], find_motion=True, locked="brow")
        self.assertEqual(found.motions.shape, (40, 3, 4))
        np.testing.assert_allclose(found.motions[:, :, 3], shift[:, 0], atol=0.1 * self.face.diagonal)
        brow = self.face.find("brow_raise")
        self.assertTrue((found.controls[:, brow] == controls[0, brow]).all())
        by_point = np.arange(30) % 2
        same = [self.solver.solve_clip(targets[:3], weights=w).controls for w in (by_point, np.tile(by_point, (3, 1)))]
        np.testing.assert_array_equal(*same)
        self.assertFalse(np.array_equal(same[0], self.solver.solve_clip(targets[:3]).controls))
        empty = self.solver.solve_clip(targets[:0])
        self.assertEqual((empty.controls.shape, empty.point_differences.shape), ((0, 5), (0, 30)))

    # Errors, memory and threads

    def test_what_is_wrong_is_named(self):
        face, targets = self.face, self.face.rest_positions
        infinite, far = targets.copy(), np.repeat(targets[None], 3, 0)
        infinite[4, 0] = np.inf
        far[2, 1] = 1e30
        solver = self.solver
        for kind, words, call in (
            (ValueError, 'locked: there is no control or control group "jaw_opem"; the closest is "jaw_open"', lambda: solver.solve(targets, locked=["jaw_opem"])),
            (ValueError, 'chosen: there is no control or control group "brows"; the closest is "brow"', lambda: solver.jacobian({}, ["brows"])),
            (ValueError, "movable: 5 is no name, and no index of the 5 controls", lambda: solver.solve(targets, movable=[5])),
            (ValueError, "movable: -1 is no name", lambda: solver.solve(targets, movable=[-1])),
            (ValueError, "movable: a mask of 4 for 5 controls", lambda: solver.solve(targets, movable=[True] * 4)),
            (ValueError, r"targets: shape \(29, 3\), not \(30, 3\)", lambda: solver.solve(targets[1:])),
            (ValueError, r"weights: shape \(3,\)", lambda: solver.solve(targets, weights=[1, 1, 1])),
            (ValueError, "controls have shape", lambda: solver.solve(targets, start=[0, 0])),
            (ValueError, "noise is 0", lambda: solver.solve(targets, noise=0)),
            (ValueError, "find_motion", lambda: solver.solve(targets, motion=np.eye(3, 4))),
            (ValueError, "max_iterations is -1", lambda: solver.solve(targets, max_iterations=-1)),
            (ValueError, "poses differ: targets of 3, distances of 2", lambda: solver.solve_clip(far, distances=np.zeros((2, 0)))),
            (ValueError, "a clip needs targets", lambda: solver.solve_clip()),
            (ValueError, "out must be a writable", lambda: solver.jacobian({}, out=np.zeros((90, 4), np.float32))),
            (ValueError, "out is for", lambda: solver.jacobian({}, sparse=True, out=np.zeros((90, 5), np.float32))),
            (ValueError, "values must be a writable", lambda: solver.jacobian({}, values=np.zeros(90))),
            (ValueError, "pairs: shape", lambda: facebaker.Solver(face, pairs=[1, 2])),
            (ValueError, "as without vertex_weights", lambda: facebaker.Solver(face, [[1, 2, 3]])),
            (ValueError, "as with vertex_weights", lambda: facebaker.Solver(face, [1], vertex_weights=[[1, 0, 0]])),
            (ValueError, "which are not given", lambda: facebaker.Solver(face, vertex_weights=[[1, 0, 0]])),
            (ValueError, 'no socket "nose"', lambda: facebaker.Solver(face, sockets=["nose"])),
            (facebaker.InvalidArgumentError, "point 1 has vertex 30 of 30", lambda: facebaker.Solver(face, [0, 30])),
            (facebaker.InvalidArgumentError, "pair 0 has point 30", lambda: facebaker.Solver(face, pairs=[(0, 30)])),
            (facebaker.InvalidArgumentError, r"point_weights\[5\] is -1", lambda: solver.solve(targets, weights=[-(i == 5) for i in range(30)])),
            (facebaker.InvalidArgumentError, "smoothness is -1", lambda: solver.solve(targets, smoothness=-1)),
            (facebaker.InvalidArgumentError, "to_face", lambda: solver.solve(targets, to_face=np.eye(3, 4) * [1, 2, 1, 1])),
            (facebaker.InvalidArgumentError, "^pose 2: .*point 1", lambda: solver.solve_clip(far)),
            (facebaker.NotFiniteError, "point 4 is infinite", lambda: solver.solve(infinite)),
            (facebaker.NotFiniteError, '"brow_raise"', lambda: solver.jacobian({"brow_raise": np.nan})),
        ):  # fmt: skip
            with self.subTest(words), self.assertRaisesRegex(kind, words):
                call()
        np.testing.assert_array_equal(solver.solve(targets).controls, face.rest_controls)

    def test_threads_may_share_a_solver(self):
        poses = [pose_of(self.face, share) for share in (0.1, 0.2, 0.3, 0.4)]
        targets = self.face.evaluate_batch(poses)
        expected = [self.solver.solve(one).controls for one in targets]
        derivatives = [self.solver.jacobian(pose) for pose in poses]
        start, wrong = threading.Barrier(4), []

        def work(index):
            start.wait()
            for _ in range(50):
                if not np.array_equal(self.solver.solve(targets[index]).controls, expected[index]):
                    wrong.append(index)
                if not np.array_equal(self.solver.jacobian(poses[index]), derivatives[index]):
                    wrong.append(index)

        threads = [threading.Thread(target=work, args=(index,)) for index in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_arrays_are_copied(self):
        points, pairs = np.array([3, 8], np.uint32), np.array([[0, 1]], np.uint32)
        solver = facebaker.Solver(self.face, points, pairs=pairs)
        expected = solver.jacobian({})
        points[:], pairs[:] = 29, 7
        solver.close()  # it is made anew
        np.testing.assert_array_equal(solver.jacobian({}), expected)

    def test_closing(self):
        with facebaker.Solver(self.face) as solver:
            expected = solver.jacobian({})
        np.testing.assert_array_equal(solver.jacobian({}), expected)
        self.face.close()
        with self.assertRaisesRegex(ValueError, "'tiny' is closed"):
            solver.jacobian(pose_of(facebaker.load(FIXTURE), 0.5))

    def test_solvers_go_to_other_processes(self):
        solver = facebaker.Solver(self.face, [0, 5, 9, 20], pairs=[(0, 1)])
        again = pickle.loads(pickle.dumps(solver))
        self.assertEqual(repr(again), repr(solver))
        targets = self.face.evaluate(pose_of(self.face, 0.3))[[0, 5, 9, 20]]
        expected = solver.solve(targets).controls
        for method in "fork", "spawn":
            with multiprocessing.get_context(method).Pool(1) as pool:
                np.testing.assert_array_equal(pool.apply(solve_elsewhere, (solver, targets)), expected)


if __name__ == "__main__":
    unittest.main()
