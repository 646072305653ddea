"""Structs are those of the last release, or have grown at their ends: its dumps against the headers, on 64 bits.

check.sh compares functions as well, but needs abigail-tools and libraries with debug information."""

import pathlib
import re
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "bindings" / "headers")]
from grown_only import Interface  # noqa: E402
from read_headers import read_headers  # noqa: E402
from struct_layouts import struct_layout  # noqa: E402


# Types as grown_only.py has them: with the bits of what is no typedef, and void never const.
BASIC_TYPES = {"float": "float:32", "double": "double:64", "char": "char:8", "void": "void:"}


def dump_type(field):
    if field.function:
        parameters = ", ".join(dump_type(one) for one in field.function.parameters)
        return f"{dump_type(field.function.result)}({parameters})*"
    text = ("const " if field.type.startswith("const ") and field.base != "void" else "") + BASIC_TYPES.get(field.base, field.base)
    for constant in re.findall(r"\*( ?const)?", field.type):
        text = f"const {text}*" if constant else f"{text}*"
    return f"{text}[{field.length}]" if field.length else text


def offences(released, read):
    """What would break hosts: members that are not as they were, and structs that have grown without telling their size."""
    found = []
    for name, was in released.items():
        fields = read.structs[name].fields if name in read.structs else []
        offsets = struct_layout(read, read.structs[name], 8).offsets if fields else {}
        now = [(8 * offsets[field.name], field.name, dump_type(field)) for field in fields]
        if now[: len(was)] != was:
            found.append(f"{name}: was {was}, is {now}")
        elif len(now) > len(was) and was[0][1] != "struct_size":
            found.append(f"{name}: has grown, and does not begin with its size")
    return found


class ReleasedStructsTest(unittest.TestCase):
    def test_structs_only_grow(self):
        dumps = sorted(HERE.glob("*.abi"))
        self.assertEqual(len(dumps), 2)
        for dump in dumps:
            released = Interface(str(dump)).structs
            self.assertGreater(len(released), 10)
            self.assertEqual(offences(released, read_headers()), [], dump.name)

    def test_what_would_break_hosts_is_found(self):
        size, slot, image = (0, "struct_size", "uint32_t"), (0, "slot", "uint32_t"), (0, "image", "uint32_t")
        for released, broken in (
            ({"fb_mesh": [size]}, []), ({"fb_texture": [slot]}, ["fb_texture"]), ({"fb_texture": [image]}, ["fb_texture"]),
            ({"fb_mesh": [(0, "struct_size", "int32_t")]}, ["fb_mesh"]), ({"fb_gone": [size]}, ["fb_gone"]),
        ):  # fmt: skip
            self.assertEqual([text.split(":")[0] for text in offences(released, read_headers())], broken)


if __name__ == "__main__":
    unittest.main()
