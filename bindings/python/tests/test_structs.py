"""The generated ctypes interface: it is that of the public headers, and ctypes lays structs out as compilers do."""

import ctypes
import pathlib
import sys
import unittest

try:
    import numpy  # noqa: F401
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

from facebaker import _interop

PROJECT = pathlib.Path(__file__).parents[1]
sys.path[:0] = [str(PROJECT), str(PROJECT.parent / "headers")]
import generate_ctypes  # noqa: E402
import read_headers  # noqa: E402
import struct_layouts  # noqa: E402


class StructTest(unittest.TestCase):
    def test_the_file_is_that_of_the_headers(self):
        text = "\n".join(generate_ctypes.interop_lines()) + "\n"
        again = "a header has changed: run bindings/python/generate_ctypes.py"
        self.assertTrue(generate_ctypes.OUT.read_text(encoding="utf-8") == text, again)

    def test_fields_lie_where_compilers_have_them(self):
        read = read_headers.read_headers()
        for struct in read.structs.values():
            layout = struct_layouts.struct_layout(read, struct, ctypes.sizeof(ctypes.c_void_p))
            made = getattr(_interop, struct.name)
            self.assertEqual(ctypes.sizeof(made), layout.size, struct.name)
            self.assertEqual({name: getattr(made, name).offset for name, _ in made._fields_}, layout.offsets)


if __name__ == "__main__":
    unittest.main()
