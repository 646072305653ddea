"""Load baked faces (.fbk) and pose them, bake faces from rigs, measure and pack them; docs/python.md begins with examples,
and facebaker.h and facebaker_bake.h say what everything means.

Arrays are NumPy's: controls are (poses, controls) and positions (poses, vertices, 3), float32, in the character's units.
facebaker.serve serves a rig to another process."""

from typing import TYPE_CHECKING

from ._bake import (
    Option, bag, bake, check, check_bag, compare, diff, evaluate, inspect, options, pack, plan, recipes, rights,
    sample, sign, verify, verify_signature,
)  # fmt: skip
from ._character import (
    Channel,
    Control,
    DrivenJoint,
    ExactPose,
    Image,
    Joint,
    Level,
    Material,
    MaterialRun,
    Mesh,
    Skin,
    Socket,
    Texture,
)
from ._dataset import save_dataset

from ._errors import (
    BadDataError, CorruptError, Error, FileError, InternalError, InvalidArgumentError, LimitError, NotAnArchiveError,
    NotFiniteError, NotFoundError, OutOfMemoryError, RigError, StoppedError, UnsupportedError,
)  # fmt: skip
from ._face import ExpectedError, Face, load
from ._many import evaluate_many

from ._results import (
    BagResult, BakeResult, CheckResult, ClipErrors, CompareResult, Errors, EvalResult, Failure, Method, PackResult,
    PlanResult, Result, RightsResult, SampleResult, VerifyResult,
)  # fmt: skip
from ._rig import Clip, Rig
from ._solutions import ClipSolution, Solution
from ._solver import Solver, SparseColumns
from ._source import Source

__all__ = [
    "BadDataError", "BagResult", "BakeResult", "Channel", "CheckResult", "Clip", "ClipErrors", "ClipSolution",
    "CompareResult", "Control", "CorruptError", "DrivenJoint", "Error", "Errors", "EvalResult", "ExactPose", "ExpectedError", "Face",
    "Failure", "FileError", "Image", "InternalError", "InvalidArgumentError", "Joint", "Level", "LimitError",
    "Material", "MaterialRun", "Mesh", "Method", "NotAnArchiveError", "NotFiniteError", "NotFoundError",
    "OutOfMemoryError", "PackResult", "PlanResult", "Result", "Rig", "RigError", "RightsResult", "SampleResult",
    "Skin", "Socket", "Solution", "Solver", "Source", "SparseColumns", "StoppedError", "Texture",
    "UnsupportedError", "VerifyResult", "__version__", "bag", "bake", "check", "check_bag", "compare", "diff",
    "evaluate", "evaluate_many", "inspect", "load", "options", "pack", "plan", "recipes", "rights", "sample",
    "save_dataset", "sign", "verify", "verify_signature",
]  # fmt: skip

if TYPE_CHECKING:
    __version__: str
else:

    def __getattr__(name: str) -> str:
        """__version__ is the library's, which is opened by then."""
        if name != "__version__":
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from ._library import library

        return library.fb_version_string().decode()
