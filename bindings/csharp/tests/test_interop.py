"""The generator of the C# side of the headers: it leaves nothing out."""

import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "bindings" / "csharp"))
import generate_interop  # noqa: E402
from read_headers import FOLDER, RUNTIME_HEADERS, read_headers  # noqa: E402


class InteropTest(unittest.TestCase):
    def test_everything_is_written(self):
        read = read_headers(names=RUNTIME_HEADERS)
        lines = "\n".join(generate_interop.interop_lines(FOLDER))
        for function in read.functions:
            self.assertIn(f" {function.name}(", lines)
        for struct in read.structs.values():
            self.assertIn(f"struct {struct.name}\n", lines)
        for constant in read.constants:
            self.assertIn(f" {constant.name} = {constant.value};", lines)

    def test_what_cannot_be_read_is_an_error_and_writes_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in RUNTIME_HEADERS:
                pathlib.Path(folder, name).write_text("typedef struct fb_odd {\n  long count;\n} fb_odd;\n")
            out = pathlib.Path(folder, "Out.cs")
            with contextlib.redirect_stderr(io.StringIO()) as printed:
                code = generate_interop.main(["--headers", folder, "--out", str(out)])
            self.assertEqual((code, printed.getvalue()), (1, 'generate_interop.py: fb_odd: the type "long" is not known\n'))
            self.assertFalse(out.exists())


if __name__ == "__main__":
    unittest.main()
