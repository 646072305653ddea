"""What calls found out."""

from __future__ import annotations

import ctypes
import datetime
import json
import pathlib
import weakref
from ctypes import byref, c_char_p, c_void_p
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Dict, Optional, Sequence, Tuple

from . import _interop as abi
from ._library import bake_library as library
from ._rig import KINDS, SPLITS

if TYPE_CHECKING:
    from ._face import Face

USES = ("variant", "backlot")
Document = Dict[str, Any]


class Result:
    """The document of a call, as the tool prints it with --json, and the notes that came meanwhile.

    document: a dictionary, to which keys are only ever added. notes: sentences."""

    def __init__(self, report: Optional[c_void_p], notes: Sequence[str]) -> None:
        self._report = report
        weakref.finalize(self, library.fb_report_free, report)
        self.document: Document = json.loads(library.fb_report_json(report))
        self.notes: Tuple[str, ...] = tuple(notes)

    def __repr__(self) -> str:
        return f"<facebaker.{type(self).__name__}: {', '.join(self.document)}>"

    def __getstate__(self) -> Dict[str, Any]:
        return {**self.__dict__, "_report": None}

    def details(self) -> Document:
        """Unstable. What a page about faces shows: figures of every frame and vertex, see fb_report_details. Of bake,
        compare and evaluate; not of a result that was pickled. Not thread-safe."""
        if self._report is None:
            raise ValueError("a result that was pickled has no details")
        text = c_char_p()
        library.check(library.fb_report_details(self._report, byref(text)))
        details: Document = json.loads(text.value or b"{}")
        return details


@dataclass(frozen=True)
class Errors:
    """Distances of vertices from the true rig, over the diagonal of the rest mesh.

    frames: measured; 0: nothing was, and the rest is 0. mse: mean of the squared distance, of all vertices and frames;
    rms: its square root. mean: mean distance. p99: 99 % of all vertices are nearer. max: worst vertex of all frames; mfm:
    mean over frames of the frame's worst vertex. worst_frame: that of max, counted over what was measured."""

    frames: int
    mse: float
    rms: float
    mean: float
    p99: float
    max: float
    mfm: float
    worst_frame: int


@dataclass(frozen=True)
class ClipErrors:
    """Errors on one clip."""

    name: str
    kind: str
    split: str
    errors: Errors


@dataclass(frozen=True)
class Method:
    """A face that was baked or measured.

    name: the recipe; of evaluate the archive's. use: "variant" or "backlot". poses: trained on; 0: not known. parameters:
    trained numbers. coefficients: columns of the basis. rig_calls: poses evaluated besides the recorded ones.
    train_seconds: basis and networks, without sampling. unseen: errors on clips that were not trained on, of evaluate on
    those asked for. dependency: on poses trained on. quantisation: of bake, the packed face against that of floats.
    clips: errors by clip, in the source's order. archive: the bytes of the .fbk, for load()."""

    name: str
    use: str
    poses: int
    parameters: int
    coefficients: int
    rig_calls: int
    train_seconds: float
    unseen: Errors
    dependency: Errors
    quantisation: Errors
    clips: Tuple[ClipErrors, ...]
    archive: bytes

    def load(self) -> "Face":
        """The face, to pose it."""
        from ._face import load

        return load(self.archive)

    def __repr__(self) -> str:
        return f"<facebaker.Method {self.name!r}: {len(self.archive)} bytes, {_figures(self.unseen)}>"


@dataclass(frozen=True)
class Failure:
    """A method of compare that could not be baked or measured, and the message of its error."""

    name: str
    use: str
    reason: str


class BakeResult(Result):
    """path: of the archive. method: the face and its errors; on unseen clips only if bake was told to measure. held_back:
    errors on poses that were kept from every fit; None where there are none."""

    def __init__(self, report: c_void_p, notes: Sequence[str], path: pathlib.Path) -> None:
        super().__init__(report, notes)
        self.path = path
        self.method = _methods(report)[0]
        held_back = self.document.get("held_back")
        names = [field.name for field in fields(Errors)]
        self.held_back = Errors(*(held_back[name] for name in names)) if held_back else None

    def __repr__(self) -> str:
        errors = self.method.unseen
        if self.held_back and not errors.frames:
            errors = self.held_back
        return f"<facebaker.BakeResult {str(self.path)!r}: {len(self.method.archive)} bytes, {_figures(errors)}>"

    def load(self) -> "Face":
        """The face, from its file."""
        from ._face import load

        return load(self.path)


class EvalResult(Result):
    """method: errors of the face, all together and by clip."""

    def __init__(self, report: c_void_p, notes: Sequence[str]) -> None:
        super().__init__(report, notes)
        self.method = _methods(report)[0]

    def __repr__(self) -> str:
        return f"<facebaker.EvalResult: {_figures(self.method.unseen)}>"


class CompareResult(Result):
    """methods: one for each method and use. failures: those that could not be baked."""

    def __init__(self, report: c_void_p, notes: Sequence[str]) -> None:
        super().__init__(report, notes)
        self.methods = _methods(report)
        self.failures: Tuple[Failure, ...] = ()
        for index in range(library.fb_report_failure_count(report)):
            struct = library.filled(abi.fb_failure)
            library.check(library.fb_report_failure_at(report, index, struct))
            self.failures += (Failure(struct.name.decode(), USES[struct.use], struct.reason.decode()),)

    def __repr__(self) -> str:
        lines = [f"{method.name} ({method.use}): {_figures(method.unseen)}" for method in self.methods]
        lines += [f"{failure.name} ({failure.use}): failed" for failure in self.failures]
        return f"<facebaker.CompareResult: {'; '.join(lines)}>"


class SampleResult(Result):
    """folder: of the dataset. poses: in it. evaluated: of those, in this call. rig_calls: poses evaluated in this call, for
    whatever reason. asked: different poses asked for in order to learn, what rig_budget limits. left_out: poses that
    failed and are the rest pose now."""

    def __init__(self, report: c_void_p, notes: Sequence[str], folder: pathlib.Path) -> None:
        super().__init__(report, notes)
        struct = library.filled(abi.fb_sample_result)
        library.check(library.fb_report_sample(report, struct))
        self.folder = folder
        self.poses: int = struct.poses
        self.evaluated: int = struct.evaluated
        self.rig_calls: int = struct.rig_calls
        self.asked: int = struct.asked
        self.left_out: int = struct.left_out

    def __repr__(self) -> str:
        return f"<facebaker.SampleResult {str(self.folder)!r}: {self.poses} poses, {self.rig_calls} rig calls>"


class PlanResult(Result):
    """folder: of the dataset, whose points some program is to write. poses: to evaluate."""

    def __init__(self, report: c_void_p, notes: Sequence[str], folder: pathlib.Path) -> None:
        super().__init__(report, notes)
        struct = library.filled(abi.fb_sample_result)
        library.check(library.fb_report_sample(report, struct))
        self.folder = folder
        self.poses: int = struct.poses

    def __repr__(self) -> str:
        return f"<facebaker.PlanResult {str(self.folder)!r}: {self.poses} poses to evaluate>"


class CheckResult(Result):
    """bakeable: there is no fault, and bake takes the folder. faults: sentences on what keeps it from that; warnings: on
    what does not. poses: of all clips; evaluated: of those, with points. The document has figures of clips, controls and
    pairs, see docs/datasets.md."""

    def __init__(self, report: c_void_p, notes: Sequence[str]) -> None:
        super().__init__(report, notes)
        struct = library.filled(abi.fb_check_result)
        library.check(library.fb_report_check(report, struct))
        self.bakeable = bool(struct.bakeable)
        self.faults: Tuple[str, ...] = tuple(fault["text"] for fault in self.document["faults"])
        self.warnings: Tuple[str, ...] = tuple(warning["text"] for warning in self.document["warnings"])
        self.poses: int = struct.poses
        self.evaluated: int = struct.evaluated

    def __repr__(self) -> str:
        state = "can be baked" if self.bakeable else "cannot be baked"
        return f"<facebaker.CheckResult: {state}, {len(self.faults)} faults, {len(self.warnings)} warnings>"


class VerifyResult(Result):
    """bytes: of the archive. poses: evaluated and compared bit for bit; 0: it has no proof. vertices: of each."""

    def __init__(self, report: c_void_p, notes: Sequence[str]) -> None:
        super().__init__(report, notes)
        struct = library.filled(abi.fb_verify_result)
        library.check(library.fb_report_verify(report, struct))
        self.bytes: int = struct.bytes
        self.poses: int = struct.poses
        self.vertices: int = struct.vertices

    def __repr__(self) -> str:
        return f"<facebaker.VerifyResult: {self.bytes} bytes, {self.poses} poses with the bits that were archived>"


class RightsResult(Result):
    """What the rights that an archive states come to on a day.

    stated: whether there are any. expired: whether they have ended; last_day: on which they hold, or None where no date is
    said. learning: from the character, "allowed", "constrained" or "forbidden"; ai_training, ai_generative_training,
    data_mining: "allowed", "constrained" or "notAllowed"; None where nothing is said; where fields disagree the strictest.
    suspendable: whether the consent can be suspended. binding: clauses about what is not simply permitted, expiry first.
    unread: clauses about what is not as the format has it, and is taken for the strictest."""

    def __init__(self, report: c_void_p, notes: Sequence[str]) -> None:
        super().__init__(report, notes)
        struct = library.filled(abi.fb_rights_result)
        library.check(library.fb_report_rights(report, struct))
        self.stated = bool(struct.stated)
        self.expired = bool(struct.expired)
        last_day: Optional[str] = self.document.get("last_day")
        self.last_day = datetime.date.fromisoformat(last_day) if last_day else None
        self.learning: Optional[str] = self.document.get("learning")
        self.ai_training: Optional[str] = self.document.get("ai_training")
        self.ai_generative_training: Optional[str] = self.document.get("ai_generative_training")
        self.data_mining: Optional[str] = self.document.get("data_mining")
        self.suspendable = bool(struct.suspendable)
        self.binding: Tuple[str, ...] = tuple(self.document["binding"])
        self.unread: Tuple[str, ...] = tuple(self.document["unread"])

    def __repr__(self) -> str:
        return f"<facebaker.RightsResult: {'; '.join(self.binding) or 'nothing binds'}>"


class BagResult(Result):
    """valid: there is no fault. files, bytes: of the payload. archives: that evaluate as archived. faults and warnings:
    pairs of a file in the bag, "" for the bag as a whole, and what is wrong with it."""

    def __init__(self, report: c_void_p, notes: Sequence[str]) -> None:
        super().__init__(report, notes)
        struct = library.filled(abi.fb_bag_result)
        library.check(library.fb_report_bag(report, struct))
        self.valid = bool(struct.valid)
        self.files: int = struct.files
        self.bytes: int = struct.bytes
        self.archives: int = struct.archives
        self.faults: Tuple[Tuple[str, str], ...] = _told(self.document["faults"])
        self.warnings: Tuple[Tuple[str, str], ...] = _told(self.document["warnings"])

    def __repr__(self) -> str:
        state = "valid" if self.valid else f"{len(self.faults)} faults"
        return f"<facebaker.BagResult: {state}, {self.files} files, {self.archives} archives>"


def _told(notes: Sequence[Document]) -> Tuple[Tuple[str, str], ...]:
    return tuple((note["file"], note["reason"]) for note in notes)


class PackResult(Result):
    """archive: bytes of the new one. bytes_before: of the one that was packed. within_limits: false with force only.
    step_factor: of the basis' quantisation steps; 1: as they were. max_error: the limit of the displacement that held,
    over the diagonal; 0: none did. displacement: of vertices from where they were, on seeded poses; frames 0: none."""

    def __init__(self, report: c_void_p, notes: Sequence[str]) -> None:
        super().__init__(report, notes)
        struct = library.filled(abi.fb_pack_result)
        library.check(library.fb_report_pack(report, struct))
        self.archive: bytes = ctypes.string_at(struct.archive, struct.archive_bytes)
        self.bytes_before: int = struct.bytes_before
        self.within_limits = bool(struct.within_limits)
        self.step_factor: float = struct.step_factor
        self.max_error: float = struct.max_error
        self.displacement = _errors(struct.displacement)

    def __repr__(self) -> str:
        return f"<facebaker.PackResult: {len(self.archive)} bytes, before {self.bytes_before}>"


def _figures(errors: Errors) -> str:
    return f"mse {errors.mse:.2g}, max {errors.max:.2g}" if errors.frames else "not measured"


def _errors(struct: abi.fb_errors) -> Errors:
    return Errors(*(getattr(struct, name) for name, *_ in abi.fb_errors._fields_))


def _methods(report: c_void_p) -> Tuple[Method, ...]:
    methods = []
    for index in range(library.fb_report_method_count(report)):
        struct = library.filled(abi.fb_method)
        library.check(library.fb_report_method_at(report, index, struct))
        methods.append(
            Method(
                struct.name.decode(),
                USES[struct.use],
                struct.poses,
                struct.parameters,
                struct.coefficients,
                struct.rig_calls,
                struct.train_seconds,
                _errors(struct.unseen),
                _errors(struct.dependency),
                _errors(struct.quantisation),
                tuple(_clip_errors(report, index, clip) for clip in range(struct.clip_count)),
                ctypes.string_at(struct.archive, struct.archive_bytes),
            )
        )
    return tuple(methods)


def _clip_errors(report: c_void_p, method: int, index: int) -> ClipErrors:
    struct = library.filled(abi.fb_clip_errors)
    library.check(library.fb_report_clip_at(report, method, index, struct))
    return ClipErrors(struct.name.decode(), KINDS[struct.kind], SPLITS[struct.split], _errors(struct.errors))
