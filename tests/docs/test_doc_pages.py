#!/usr/bin/env python3
"""Tests of the reader of pages and of the comparison of output."""
import os
import tempfile
import unittest

from doc_pages import PageError, anchors_of, links_of, paths_of, read_blocks
from run_docs import compare


def blocks(text):
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "page.md"), "w", encoding="utf-8") as file:
            file.write(text)
        return read_blocks(folder, "page.md")


class Pages(unittest.TestCase):
    def test_blocks_and_directives(self):
        found = blocks('text\n<!-- replace "20000" with "300" -->\n```sh\nbake --poses 20000\n```\n<!-- file: a.c -->\n\n```c\nint a;\n```\n')
        self.assertEqual([b.language for b in found], ["sh", "c"])
        self.assertEqual(found[0].code, "bake --poses 300\n")
        self.assertEqual(found[1].file, "a.c")
        self.assertEqual(found[1].line, 8)

    def test_faults(self):
        for text in ("```ruby\n```\n", "```sh\n", "<!-- skip: no -->\nwords\n", '<!-- replace "x" -->\n```sh\n```\n',
                     "<!-- skip -->\n```sh\n```\n"):
            with self.assertRaises(PageError):
                blocks(text)
        with self.assertRaises(PageError):
            blocks('<!-- replace "x" with "y" -->\n```sh\nz\n```\n')[0].code

    def test_links_and_paths(self):
        text = "# A head, it is\n[a](b.md#c) `core/{a,b}/x.h` `NAME/x` `core/bake/NAME.cpp` `y.cpp` `--json` `1/2`\n```\n`core/no`\n```\n"
        self.assertEqual(links_of(text), ["b.md#c"])
        self.assertEqual(anchors_of(text), {"a-head-it-is"})
        self.assertEqual(list(paths_of(text, {"core"})), ["core/a/x.h", "core/b/x.h", "y.cpp"])


class Output(unittest.TestCase):
    def test_numbers_and_gaps(self):
        printed = "| mse   | 1.5e-07 |\n| ----- | ------- |\nface: 12 poses\nend\n"
        self.assertIsNone(compare("| mse | 2e-9 |\n| --- | --- |\n...\nend\n", printed, False))
        self.assertIsNone(compare("| mse | -2.25e-9 |\n| --- | --- |\nface: 9 poses\nend", printed, False))
        self.assertIsNone(compare("...\nface: 12 ...\nend", printed, True))
        self.assertIn("shows", compare("...\nface: 13 poses\nend", printed, True))
        self.assertIn("shows", compare("| max | 2e-9 |\n...", printed, False))
        self.assertIn("also", compare("| mse | 2e-9 |\n| --- | --- |\nface: 1 poses", printed, False))
        self.assertIn("shows", compare("face: x poses", "face: 1 poses", False))

    def test_numbers_that_were_printed(self):
        filled = []
        self.assertIsNone(compare("| mse   |  2e-9 |\n...\nface: 9 ..., 1", "| mse | 1.5e-07 |\nmore\nface: 12 poses, 3", False, filled))
        self.assertEqual(filled, ["| mse   |  1.5e-07 |", "...", "face: 12 ..., 3"])


if __name__ == "__main__":
    unittest.main()
