"""What progress shows, with and without tqdm, on terminals and elsewhere."""

import contextlib
import io
import sys
import unittest
import unittest.mock

try:
    import numpy  # noqa: F401
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

from facebaker._progress import close_progress, shown_progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


class FakeBar:
    made = []

    def __init__(self, desc, total):
        self.desc, self.total, self.n, self.closed = desc, total, 0, False
        FakeBar.made.append(self)

    def update(self, by):
        self.n += by

    def close(self):
        self.closed = True


def show(modules, stream):
    with unittest.mock.patch.dict(sys.modules, modules), contextlib.redirect_stderr(stream):
        progress = shown_progress(True)
        for step in ("sampling", 0, 5), ("sampling", 5, 5), ("training", 0, 9), ("training", 3, 9):
            progress(*step)
        close_progress(progress)


class ProgressTest(unittest.TestCase):
    def test_in_words(self):
        stream = io.StringIO()
        show({"tqdm": None}, stream)
        self.assertEqual(stream.getvalue(), "sampling\ntraining\n")

    def test_on_a_terminal(self):
        stream = Terminal()
        show({"tqdm": None}, stream)
        lines = stream.getvalue().replace("\033[K", "").split("\n")
        self.assertEqual([line.split("\r")[-1] for line in lines], ["sampling 5/5", "training 3/9", ""])

    def test_by_tqdm(self):
        FakeBar.made.clear()
        show({"tqdm": unittest.mock.Mock(tqdm=FakeBar)}, io.StringIO())
        self.assertEqual(
            [(bar.desc, bar.n, bar.total) for bar in FakeBar.made], [("sampling", 5, 5), ("training", 3, 9)]
        )
        self.assertTrue(all(bar.closed for bar in FakeBar.made))

    def test_a_callable_or_nothing(self):
        self.assertIs(shown_progress(print), print)
        self.assertIsNone(shown_progress(None))
        self.assertIsNone(shown_progress(False))
        close_progress(print)


if __name__ == "__main__":
    unittest.main()
