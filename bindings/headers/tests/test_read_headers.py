"""What reads the public headers: it leaves nothing out, and refuses what it does not understand."""

import pathlib
import re
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1]))
from read_headers import FOLDER, HEADERS, Field, HeaderError, read_headers  # noqa: E402
from struct_layouts import struct_layout  # noqa: E402

STRUCT = "typedef struct fb_odd {\n  %s;\n} fb_odd;\n"


def read_text(text):
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, "odd.h").write_text(text)
        return read_headers(pathlib.Path(folder), ["odd.h"])


class ReadingTest(unittest.TestCase):
    def test_nothing_is_left_out(self):
        self.assertEqual(sorted(HEADERS), sorted(path.name for path in FOLDER.glob("*.h")))
        text = "\n".join((FOLDER / name).read_text(encoding="utf-8") for name in HEADERS)
        read = read_headers()
        self.assertEqual([one.name for one in read.functions], re.findall(r"^FB_API [^(]*?(fb_\w+)\(", text, flags=re.M))
        self.assertEqual(list(read.structs), re.findall(r"^typedef struct (fb_\w+) \{", text, flags=re.M))
        self.assertEqual(list(read.callbacks), re.findall(r"^typedef [\w ]+ ?\(\*(fb_\w+)\)", text, flags=re.M))
        macros = re.findall(r"^#define (FB_\w+)", text, flags=re.M)
        others = {"FB_API", "FB_RIG_OPEN_SYMBOL"}
        self.assertEqual([one.name for one in read.constants], [name for name in macros if name not in others])

    def test_declarations(self):
        read = read_text(
            "#define FB_SIZE 0x10u /**< ( */\ntypedef struct fb_it fb_it; // ;\n"
            + STRUCT % "const fb_it* const* its; float frame[FB_SIZE]; void (*close)(void* user, int32_t how)"
            + "FB_API const char* fb_name(const fb_odd* odd);\n"
        )
        its, frame, close = read.structs["fb_odd"].fields
        self.assertEqual((its.base, its.stars, frame), ("fb_it", 2, Field("float", "frame", 16)))
        self.assertEqual([one.type for one in [close.function.result, *close.function.parameters]], ["void", "void*", "int32_t"])
        self.assertEqual((read.functions[0].result.type, read.functions[0].parameters[0].base), ("const char*", "fb_odd"))
        self.assertEqual(struct_layout(read, read.structs["fb_odd"], 4).offsets, {"its": 0, "frame": 4, "close": 68})
        self.assertEqual(struct_layout(read, read.structs["fb_odd"], 8).size, 80)

    def test_what_is_not_understood_is_an_error(self):
        for member in (
            "long count", "unsigned bits : 3", "struct fb_other other", "fb_later later", "float frame[FB_NONE]", "int32_t a, b",
            "union { float a; } u", "int32_t (*table[3])(void)",
        ):  # fmt: skip
            with self.assertRaises(HeaderError, msg=member):
                read_text(STRUCT % member)
        for text in (
            "#define FB_LIST {1, 2}\n", "#define FB_MOST(a) a\n", "#pragma pack(1)\n", "enum fb_kind { FB_A };\n",
            "typedef long fb_long;\n", "typedef struct fb_a { int32_t x; } fb_b;\n", "int32_t fb_hidden(void);\n",
            "FB_API int32_t fb_call(int32_t (*of)(void));\n", "FB_API long fb_long(void);\n", "extern int32_t fb_global;\n",
        ):  # fmt: skip
            with self.assertRaises(HeaderError, msg=text):
                read_text(text)


if __name__ == "__main__":
    unittest.main()
