"""What a face is solved for, without Blender: which shape is which mesh, the command line, and lines about the result."""

import unittest

from facebaker_blender.channels import Channel, SceneControl, SettingsError
from facebaker_blender.solve_request import WHOLE, SolveRequest, matched_meshes, solve_lines, solve_words

CONTROLS = [
    SceneControl(name, Channel("shape_key", "face", key=name), 0, 1, 0, group)
    for name, group in (("smile.L", "mouth"), ("smile.R", "mouth"), ("brow", "brows"), ("extra", ""))
]


class MeshTest(unittest.TestCase):
    def test_which_mesh_a_shape_is_of(self):
        meshes = [("face", 64), ("brow", 9), ("teeth", 12), ("teeth.001", 12)]
        for shapes, expected in (
            ([("sculpt", 64)], [0]),
            ([("all of it", 97)], [WHOLE]),
            ([("brow.002", 9), ("face.001", 64)], [1, 0]),
            ([("teeth.001", 12), ("teeth", 12)], [3, 2]),
            ([("teeth.001 shape", 12), ("teeth shape", 12)], [3, 2]),
        ):  # fmt: skip
            self.assertEqual(matched_meshes(shapes, meshes), expected)
        self.assertEqual(matched_meshes([("sculpt", 64)], [("face", 64)]), [0])
        self.assertEqual(matched_meshes([("eye.003", 5), ("x", 7)], [("eye", 5), ("lid", 5), ("x", 7)]), [0, 2])

    def test_shapes_that_are_none(self):
        meshes = [("face", 64), ("teeth", 12), ("teeth.001", 12)]
        for shapes, message in (
            ([("body", 1234)], '"body" has 1,234 vertices, the face 88: "face" 64, "teeth" 12, "teeth.001" 12; a shape has'),
            ([("teeth.002", 12)], '"teeth.002" may be a shape of "teeth" or "teeth.001", .* such as "teeth.001 shape"'),
            ([("a", 64), ("b", 64)], '"a" and "b" are both shapes of the mesh "face"'),
        ):  # fmt: skip
            with self.assertRaisesRegex(SettingsError, message):
                matched_meshes(shapes, meshes)
        with self.assertRaisesRegex(SettingsError, '"body" has 65 vertices, the face 64; a shape'):
            matched_meshes([("body", 65)], [("face", 64)])


class RequestTest(unittest.TestCase):
    def test_locked_controls(self):
        for request, locked in (
            (SolveRequest(), []),
            (SolveRequest(locked=("mouth",)), ["smile.L", "smile.R"]),
            (SolveRequest(only=("mouth", "brow"), locked=("smile.R",)), ["smile.R", "extra"]),
        ):  # fmt: skip
            self.assertEqual(request.locked_controls(CONTROLS), locked)
        with self.assertRaisesRegex(SettingsError, 'there is no control or group "moth"; there are "mouth", '):
            SolveRequest(only=("moth",)).locked_controls(CONTROLS)
        with self.assertRaisesRegex(SettingsError, "all controls are locked"):
            SolveRequest(locked=("mouth", "brows", "extra")).locked_controls(CONTROLS)

    def test_the_command_line(self):
        request = SolveRequest(head_motion=True, noise=0.25, only=("mouth",), locked=("smile.L", "brow"))
        words = solve_words("/bin/facebaker", "/a/face.fbk", "/tmp/t.npy", "/tmp/o.npy", request)
        self.assertEqual(
            words,
            ["/bin/facebaker", "solve", "/a/face.fbk", "/tmp/t.npy", "--out", "/tmp/o.npy", "--noise", "0.25", "--json", "-",
             "--head-motion", "--only", "mouth", "--lock", "smile.L", "--lock", "brow"],
        )  # fmt: skip
        self.assertNotIn("--head-motion", solve_words("f", "a", "t", "o", SolveRequest()))


class LinesTest(unittest.TestCase):
    DOCUMENT = {
        "frames": 40, "units": "m", "rms": 0.00012, "max": 0.0021, "worst_frame": 7, "controls_moving": 12,
        "undecided": [{"control": f"c{i}"} for i in range(14)], "notes": ["one thing"],
    }  # fmt: skip

    def test_a_clip(self):
        lines = solve_lines(self.DOCUMENT, 101, ["eye"], ["teeth"])
        self.assertEqual(lines[0], "40 frames: off by 0.12 mm in the root mean square, by 2.1 mm at most, in frame 108")
        self.assertEqual(lines[1], "12 controls move")
        self.assertIn('"c11" and 2 more: ', lines[2])
        self.assertEqual(lines[3:], ['Locked at rest: "eye"', 'Without a shape: "teeth"', "One thing"])

    def test_a_pose(self):
        document = {**self.DOCUMENT, "frames": 1, "worst_frame": 0, "controls_moving": 1, "undecided": [], "notes": []}
        self.assertEqual(
            solve_lines(document, 5, [], []), ["Off by 0.12 mm in the root mean square, by 2.1 mm at most", "1 control moves"]
        )


if __name__ == "__main__":
    unittest.main()
