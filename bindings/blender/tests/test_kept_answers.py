"""What of a rig's answers is kept once a bake is complete."""

import unittest

from facebaker_blender.kept_answers import worth_keeping


def stage(asked, evaluated, seconds):
    return {"stage": "drawn poses", "asked": asked, "evaluated": evaluated, "seconds": seconds}


class KeptAnswersTest(unittest.TestCase):
    def test_large_files_of_quick_rigs_are_given_back(self):
        self.assertFalse(worth_keeping(1_268_691_434, 467_890, [stage(1000, 1000, 3), stage(3442, 3536, 10)]))

    def test_small_files_stay(self):
        self.assertTrue(worth_keeping(5_000_000, 20_000, [stage(150, 150, 1)]))
        self.assertTrue(worth_keeping(40_000_000, 5_000_000, [stage(150, 150, 1)]))

    def test_what_took_a_minute_stays(self):
        self.assertTrue(worth_keeping(1 << 30, 500_000, [stage(20_000, 20_000, 900)]))
        # Most of it was taken over, and would take as long again.
        self.assertTrue(worth_keeping(1 << 30, 500_000, [stage(20_000, 400, 18)]))
        self.assertTrue(worth_keeping(1 << 30, 500_000, [stage(20_000, 0, 0)]))


if __name__ == "__main__":
    unittest.main()
