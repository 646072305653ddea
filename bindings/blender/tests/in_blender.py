"""Runs the tests of the add-on that need Blender; test.sh calls it:

    blender -b --factory-startup --python-exit-code 1 -P in_blender.py -- [MODULE[.CLASS[.TEST]]...]"""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import addon_support  # noqa: E402, F401  (makes the package importable)

MODULES = (
    "addon_tests", "action_tests", "time_tests", "choice_tests", "group_tests", "joint_tests", "preview_tests", "bake_tests",
    "rebake_tests", "window_tests", "key_tests", "solve_tests", "extension_tests", "import_tests",
)  # fmt: skip

words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
program = unittest.main(module=None, argv=["in_blender.py", *(words or MODULES)], exit=False, verbosity=2)
sys.exit(not program.result.wasSuccessful())
