"""The structs of the package against those of the public headers: a program of the C compiler prints the latter."""

import ctypes
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

try:
    import numpy  # noqa: F401
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

from facebaker._bake_structs import BAKE_STRUCTS
from facebaker._structs import RUNTIME_STRUCTS

HEADERS = pathlib.Path(__file__).parents[3] / "capi" / "include"
COMPILER = os.environ.get("CC") or shutil.which("cc")


def python_layout():
    for struct in RUNTIME_STRUCTS + BAKE_STRUCTS:
        yield f"{struct.c_name} {ctypes.sizeof(struct)}"
        for name, *_ in struct._fields_:
            field = getattr(struct, name)
            yield f"{struct.c_name}.{name} {field.offset} {field.size}"


def c_layout(folder):
    lines = ["#include <facebaker/facebaker_bake.h>", "#include <stddef.h>", "#include <stdio.h>", "int main(void) {"]
    for struct in RUNTIME_STRUCTS + BAKE_STRUCTS:
        lines.append(f'printf("{struct.c_name} %zu\\n", sizeof({struct.c_name}));')
        for name, *_ in struct._fields_:
            place = f"offsetof({struct.c_name}, {name}), sizeof((({struct.c_name}*)0)->{name})"
            lines.append(f'printf("{struct.c_name}.{name} %zu %zu\\n", {place});')
    source = pathlib.Path(folder, "layout.c")
    source.write_text("\n".join([*lines, "return 0; }\n"]))
    program = pathlib.Path(folder, "layout")
    subprocess.run([COMPILER, "-std=c99", f"-I{HEADERS}", str(source), "-o", str(program)], check=True)
    return subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout.splitlines()


class StructTest(unittest.TestCase):
    @unittest.skipUnless(COMPILER and HEADERS.is_dir(), "there is no C compiler, or no headers")
    def test_fields_lie_where_the_headers_have_them(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(list(python_layout()), c_layout(folder))


if __name__ == "__main__":
    unittest.main()
