"""The generator of the C# side of the headers: it leaves nothing out, and lays structs out as the C compiler does."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "bindings" / "csharp"))
import generate_interop  # noqa: E402

INCLUDE = ROOT / "capi" / "include"
HEADERS = INCLUDE / "facebaker"
COMPILER = os.environ.get("CC") or shutil.which("cc")


class InteropTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.header = generate_interop.read_headers(HEADERS)
        cls.text = "\n".join((HEADERS / name).read_text(encoding="utf-8") for name in generate_interop.HEADERS)

    def test_every_function_and_struct_is_written(self):
        self.assertEqual([f.name for f in self.header.functions], re.findall(r"^FB_API [^(]*?(fb_\w+)\(", self.text, flags=re.M))
        with_body = [name for name in re.findall(r"^typedef struct (fb_\w+) \{", self.text, flags=re.M)]
        self.assertEqual([s.name for s in self.header.structs], with_body)
        self.assertGreater(len(with_body), 10)
        lines = "\n".join(generate_interop.Writer(self.header).lines())
        for name in [f.name for f in self.header.functions]:
            self.assertIn(f" {name}(", lines)

    @unittest.skipUnless(COMPILER, "there is no C compiler")
    def test_layouts_are_those_of_the_c_compiler(self):
        writer = generate_interop.Writer(self.header)
        with tempfile.TemporaryDirectory() as folder:
            source, program = pathlib.Path(folder, "layout.c"), pathlib.Path(folder, "layout")
            source.write_text(writer.layout_program())
            subprocess.run([COMPILER, "-std=c99", f"-I{INCLUDE}", str(source), "-o", str(program)], check=True)
            printed = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout.splitlines()
        ours = [f"{name} {number}" for struct in self.header.structs for name, number in writer.layout(struct)]
        self.assertEqual(ours, printed)

    def test_what_it_does_not_understand_is_an_error(self):
        for member in ("long count", "unsigned bits : 3", "struct fb_other other"):
            with tempfile.TemporaryDirectory() as folder:
                for name in generate_interop.HEADERS:
                    pathlib.Path(folder, name).write_text("typedef struct fb_odd {\n  %s;\n} fb_odd;\n" % member)
                out = pathlib.Path(folder, "Out.cs")
                with open(os.devnull, "w") as silent:
                    errors, sys.stderr = sys.stderr, silent
                    try:
                        code = generate_interop.main(["--headers", folder, "--out", str(out)])
                    finally:
                        sys.stderr = errors
                self.assertEqual(code, 1, member)
                self.assertFalse(out.exists(), member)


if __name__ == "__main__":
    unittest.main()
