"""Sampling, baking, comparing, measuring and packing. Each is one call of facebaker_bake.h, which says more about every
option; options have the names and defaults that they have there.

All take `progress`, called with stage, steps done and steps in all (True: shows it on standard error), and `note`, called
with sentences for the user. What they raise ends the call. So does Ctrl-C, as KeyboardInterrupt; the same call goes on
afterwards where a work folder or dataset keeps what is done. Calls fail with the exceptions of facebaker.Error."""

from __future__ import annotations

import contextlib
import datetime
import json
import os
import pathlib
from ctypes import byref, c_char_p, c_double, c_void_p, cast, sizeof
from typing import Any, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

from . import _interop as abi
from ._archive import AnyArchive, Archive
from ._arrays import floats
from ._calls import Call, Note, c_strings, path_bytes, text_bytes
from ._character import About, Socket
from ._fields import socket_fields
from ._library import assign
from ._library import bake_library as library
from ._progress import Progress
from ._results import (
    USES, BagResult, BakeResult, CheckResult, CompareResult, EvalResult, PackResult, PlanResult, Result,
    RightsResult, SampleResult, VerifyResult,
)  # fmt: skip
from ._rig import SPLITS, Clip
from ._rig_struct import clip_struct
from ._source import AnySource, Place, Source

_MEASURES = ("quality", "locality")
_OPTION_KINDS = ("count", "number", "flag", "word", "path")
OptionValue = Union[int, float, bool, str]


def recipes() -> Tuple[str, ...]:
    """The names of the recipes that bake and compare know."""
    return tuple(library.fb_recipe_name(index).decode() for index in range(library.fb_recipe_count()))


class Option(NamedTuple):
    """An option of bake and compare."""

    name: str  # the keyword
    kind: str  # "count", a whole number, "number", "flag", 0 or 1, "word", one of `words`, or "path"
    standard: str  # the default, as text
    least: float  # of numbers
    most: float
    words: Tuple[str, ...]
    since: str  # the version that had it first
    help: str


def options() -> Tuple[Option, ...]:
    """The numbers, flags, words and paths that decide how a face is baked, as this version of the library has them."""
    found = []
    for index in range(library.fb_option_count()):
        info = library.filled(abi.fb_option_info)
        library.check(library.fb_option_at(index, byref(info)))
        name, standard, since, text = (t.decode() for t in (info.name, info.standard, info.since, info.help))
        words = tuple(info.words.decode().split(",")) if info.words else ()
        found.append(Option(name, _OPTION_KINDS[info.kind], standard, info.least, info.most, words, since, text))
    return tuple(found)


def sample(
    source: AnySource,
    folder: Place,
    *,
    poses: int = 0,
    seed: int = 1,
    mix: str = "dense",
    rig_budget: int = 0,
    shots: bool = True,
    clips: Sequence[Clip] = (),
    skip_failing: bool = False,
    examples: Sequence[Place] = (),
    threads: int = 0,
    progress: Progress = None,
    note: Note = None,
) -> SampleResult:
    """Plans and evaluates training poses of a live source and writes them as a dataset folder, shard by shard; one begun
    with the same options is continued.

    poses: new training poses; 0: 20,000, or all of rig_budget. mix: how they are spread over the kinds, "dense" or
    "paper". rig_budget: different poses asked for at most in order to learn; 0: no limit. shots: also the rig's own
    clips. clips: more clips to evaluate, without positions. skip_failing: puts the rest pose in the place of drawn poses
    that fail. examples: files of control curves near which poses are sampled."""
    desc = library.filled(abi.fb_sample_desc)
    assign(desc, threads=threads, poses=poses, seed=seed, rig_budget=rig_budget)
    assign(desc, shots=shots, skip_failing=skip_failing)
    _set_plan(desc, folder, mix, examples)
    report, notes = _run_planned(library.fb_sample, desc, source, clips, progress, note)
    return SampleResult(report, notes, pathlib.Path(folder))


def plan(
    source: AnySource,
    folder: Place,
    *,
    poses: int = 0,
    seed: int = 1,
    mix: str = "dense",
    shots: bool = True,
    clips: Sequence[Clip] = (),
    examples: Sequence[Place] = (),
    threads: int = 0,
    progress: Progress = None,
    note: Note = None,
) -> PlanResult:
    """Writes the poses that some program is to evaluate as a dataset folder without points, which is complete when the
    program has written the files of points that its dataset.json names (docs/datasets.md).

    source: as for bake, or the path of a schema: a .json file like dataset.json that needs neither rest mesh nor clips,
    and takes no `clips` here. Other options are those of sample; of a source without test clips, a fifth of `poses`, at
    most 2,000, come on top to measure on."""
    desc = library.filled(abi.fb_sample_desc)
    assign(desc, threads=threads, poses=poses, seed=seed, shots=shots)
    _set_plan(desc, folder, mix, examples)
    if isinstance(source, (str, os.PathLike)) and pathlib.Path(source).suffix.lower() == ".json":
        if clips:
            raise ValueError("clips of a schema are planned by hand: name their controls in dataset.json")
        with Call(progress, note) as call:
            desc.schema, desc.callbacks = path_bytes(source), call.callbacks
            return PlanResult(_reported(call, library.fb_plan, desc), call.notes, pathlib.Path(folder))
    report, notes = _run_planned(library.fb_plan, desc, source, clips, progress, note)
    return PlanResult(report, notes, pathlib.Path(folder))


def check(folder: Place, *, threads: int = 0, progress: Progress = None, note: Note = None) -> CheckResult:
    """Reads a dataset folder, all of its points included, and finds everything that is wrong with it, and what its poses
    cover. Faults are no exception: see the result."""
    desc = library.filled(abi.fb_check_desc)
    desc.directory = path_bytes(folder)
    assign(desc, threads=threads)
    with Call(progress, note) as call:
        desc.callbacks = call.callbacks
        return CheckResult(_reported(call, library.fb_check, desc), call.notes)


def bake(
    source: AnySource,
    out: Place,
    *,
    recipe: str = "hero",
    use: str = "backlot",
    epochs: int = 0,
    poses: int = 0,
    mix: str = "dense",
    rig_budget: int = 0,
    seed: int = 1,
    max_bytes: int = 0,
    max_error: float = 0.0,
    force: bool = False,
    measure: Sequence[str] = (),
    learning_curve: bool = False,
    licence: Optional[str] = None,
    created: Optional[str] = None,
    work: Optional[Place] = None,
    reuse: Optional[Place] = None,
    skip_failing: bool = False,
    examples: Sequence[Place] = (),
    normal_weight: float = 1.0,
    cache_bytes: int = 8 << 30,
    about: Optional[About] = None,
    thumbnail: Optional[bytes] = None,
    exact: Sequence[str] = (),
    level_shares: Sequence[float] = (),
    level_meshes: Sequence[Place] = (),
    threads: int = 0,
    progress: Progress = None,
    note: Note = None,
    **more: OptionValue,
) -> BakeResult:
    """Samples a live source, trains, packs, measures and verifies a face and writes its archive, complete or not at all.

    source: a Rig, a Source, or what the tool takes: a dataset folder, a plugin, a glTF file, "exec:COMMAND",
    "sample". out: the .fbk to write. recipe: one of recipes(). use: "backlot" preserves a character whose shots
    exist, which are trained on; "variant" makes new ones. epochs: 0: the recipe's own. poses, mix, rig_budget,
    skip_failing, examples: of a live source, as for sample; by default 2,000 poses of one that is linear in its
    controls. max_bytes: of the archive. max_error: largest distance of a vertex, over the diagonal. force: write a
    face that meets none; else LimitError. measure: "quality" and "locality", for the result. learning_curve: bake on
    parts of the poses too. licence: text. created: a date; None: the same seed gives the same bytes. work: folder
    that keeps what resuming needs; None: beside the archive, removed at the end. reuse: work folder of a bake of an
    earlier version of the rig. normal_weight: how much errors of normals count, 0 to 4. cache_bytes: of evaluations
    that are kept. about: fields about the character. thumbnail: a square PNG. exact: poses that come out exactly,
    "CLIP:FRAME,...", "CLIP" or a file. level_shares: levels of detail by their share; level_meshes: as files.
    threads: 0: all. more: options() that have no keyword here."""
    desc = library.filled(abi.fb_bake_desc)
    desc.options, desc.option_count = _named(more)
    desc.archive, desc.recipe, desc.mix = path_bytes(out), text_bytes(recipe), text_bytes(mix)
    desc.use, desc.measure = _number(USES, use, "use"), _measures(measure)
    assign(desc, threads=threads, epochs=epochs, poses=poses, rig_budget=rig_budget, seed=seed, force=force)
    assign(desc, max_bytes=max_bytes, max_error=max_error, learning_curve=learning_curve)
    assign(desc, skip_failing=skip_failing, normal_weight=normal_weight, cache_bytes=cache_bytes)
    desc.licence, desc.created = _optional_text(licence), _optional_text(created)
    desc.work, desc.reuse = _optional_path(work), _optional_path(reuse)
    desc.examples, desc.example_count = _paths(examples)
    desc.exact, desc.exact_count = _paths(exact)
    _set_levels(desc, level_shares, level_meshes)
    _set_texts(desc, about, thumbnail)
    report, notes = _run(library.fb_bake, desc, source, progress, note)
    return BakeResult(report, notes, pathlib.Path(out))


def compare(
    source: AnySource,
    *,
    methods: Sequence[str] = ("linear", "paper-tuned", "hero"),
    epochs: int = 0,
    poses: int = 0,
    mix: str = "dense",
    rig_budget: int = 0,
    seed: int = 1,
    learning_curve: bool = False,
    work: Optional[Place] = None,
    threads: int = 0,
    progress: Progress = None,
    note: Note = None,
    **more: OptionValue,
) -> CompareResult:
    """Bakes several recipes on the same poses and measures them on the same clips. Options are those of bake; work: None:
    a temporary folder."""
    desc = library.filled(abi.fb_compare_desc)
    desc.options, desc.option_count = _named(more)
    assign(desc, threads=threads, epochs=epochs, poses=poses, rig_budget=rig_budget, seed=seed)
    assign(desc, learning_curve=learning_curve)
    desc.methods, desc.method_count = c_strings([text_bytes(method) for method in methods])
    desc.mix, desc.work = text_bytes(mix), _optional_path(work)
    report, notes = _run(library.fb_compare, desc, source, progress, note)
    return CompareResult(report, notes)


def evaluate(
    archive: AnyArchive,
    source: AnySource,
    *,
    split: str = "test",
    measure: Sequence[str] = (),
    threads: int = 0,
    progress: Progress = None,
    note: Note = None,
) -> EvalResult:
    """Compares an archive with the true rig, on the source's clips of a split: "train", "validation", "test" or "all". It
    is what the tool calls eval; to pose a face, see Face.evaluate.

    archive: a path, bytes or a Face. source: of the same face, as for bake. measure: as for bake."""
    desc = library.filled(abi.fb_eval_desc)
    assign(desc, threads=threads, measure=_measures(measure))
    desc.split = abi.FB_SPLIT_ALL if split == "all" else _number(SPLITS, split, "split")
    opened_archive = Archive(archive)
    desc.archive = opened_archive.handle
    report, notes = _run(library.fb_eval, desc, source, progress, note)
    return EvalResult(report, notes)


def verify(archive: AnyArchive) -> VerifyResult:
    """Whether an archive is whole and still evaluates to the bits that were archived. Raises CorruptError, naming pose and
    vertex, if not. archive: a path, bytes or a Face."""
    opened = Archive(archive)
    return VerifyResult(_reported(Call(), library.fb_verify, opened.handle), ())


def sign(
    file: Place,
    key: Place,
    *,
    certificate: Optional[Place] = None,
    pass_phrase: Optional[str] = None,
    out: Optional[Place] = None,
) -> Result:
    """Signs all bytes of a file, which stays as it is: an archive, which is verified first, a consent or a list of
    withdrawals. Its `document` says by whom, when, and which file has the signature.

    key: a PEM file with a private key; certificate: of the key's certificate; None: it is in `key`, too. out: the signature
    to write; None: `file` with ".sig"."""
    desc = library.filled(abi.fb_sign_desc)
    desc.path, desc.key, desc.certificate = path_bytes(file), path_bytes(key), _optional_path(certificate)
    desc.pass_phrase, desc.signature = _optional_text(pass_phrase), _optional_path(out)
    return Result(_reported(Call(), library.fb_sign, desc), ())


def verify_signature(
    file: AnyArchive,
    signature: Optional[Place] = None,
    *,
    trusted: Sequence[Place] = (),
    withdrawn: Sequence[Place] = (),
    on: Union[str, datetime.date, None] = None,
    accept_expired: bool = False,
) -> Result:
    """Whether a file is as somebody trusted signed it, and its consent is not withdrawn. Its `document` says who signed and
    when, by which file that is trusted, and what was asked of which list. Raises BadDataError, naming what is not so.

    file: a path of any file, the bytes of an archive or a Face. signature: None: the path of `file` with ".sig". trusted: PEM
    files with certificates of signers, of who issued those, or public keys. withdrawn: lists of withdrawals, each with its
    signature beside it. on: the day on which all of it must hold, as for rights. accept_expired: a certificate that was
    valid when the signer says to have signed is enough."""
    desc = library.filled(abi.fb_verify_signature_desc)
    source = getattr(file, "source", file)
    if isinstance(source, bytes):
        opened = Archive(source)
        desc.archive = opened.handle
    else:
        desc.path = path_bytes(source)
    desc.signature, desc.on = _optional_path(signature), _optional_day(on)
    desc.trusted, desc.trusted_count = _paths(trusted)
    desc.withdrawn, desc.withdrawn_count = _paths(withdrawn)
    desc.flags = abi.FB_SIGNATURE_ACCEPT_EXPIRED if accept_expired else 0
    return Result(_reported(Call(), library.fb_verify_signature, desc), ())


def inspect(archive: AnyArchive) -> Result:
    """Everything worth knowing of an archive, as the document of `facebaker inspect`: its `document`."""
    opened = Archive(archive)
    return Result(_reported(Call(), library.fb_inspect, opened.handle), ())


def rights(archive: AnyArchive, *, on: Union[str, datetime.date, None] = None) -> RightsResult:
    """What the rights that an archive states come to on a day: whether they have ended, and what else binds. Nothing keeps
    a program from a face whose rights have ended; that is its own to decide. archive: a path, bytes or a Face. on: of UTC,
    "2031-12-31" or a date; None: today."""
    about = Archive(archive).text("about").encode()
    return RightsResult(_reported(Call(), library.fb_rights, about, _optional_day(on)), ())


def diff(before: AnyArchive, now: AnyArchive) -> Result:
    """What has changed between two archives of one character, as the document of `facebaker diff`."""
    opened = Archive(before), Archive(now)
    return Result(_reported(Call(), library.fb_diff, *(archive.handle for archive in opened)), ())


def bag(
    archives: Sequence[Place],
    out: Place,
    *,
    beside: Sequence[Place] = (),
    sources: Sequence[Place] = (),
    files: Optional[Mapping[str, Place]] = None,
    info: Sequence[Tuple[str, str]] = (),
    date: Optional[str] = None,
    threads: int = 0,
    progress: Progress = None,
    note: Note = None,
) -> BagResult:
    """Writes archives as a BagIt bag for those who keep them, with all that is needed to read them later; whole or not at
    all.

    archives: paths, each with another name. out: a folder that is not there yet, or is empty. beside: files that are kept
    beside the archives, such as signatures. sources: files and folders that the archives were made of. files: more of
    them, by their paths in data/. info: labels and values for bag-info.txt, such as ("Source-Organization", "..."). date:
    of the bag, "2026-11-29"; None: today. The access copy of a face is its own thumbnail, if it has one; the tool draws
    larger pictures and writes glTF, which can be given as files={"access/face.fbk.glb": ...}."""
    desc = library.filled(abi.fb_bag_desc)
    assign(desc, threads=threads)
    given = dict(files or {})
    desc.directory, desc.date = path_bytes(out), _optional_text(date)
    desc.archives, desc.archive_count = _paths(archives)
    desc.beside, desc.beside_count = _paths(beside)
    desc.sources, desc.source_count = _paths(sources)
    desc.file_names, desc.file_count = c_strings([text_bytes(name) for name in given])
    desc.files, _ = _paths(list(given.values()))
    desc.info, desc.info_count = c_strings([text_bytes(f"{label}: {value}") for label, value in info])
    with Call(progress, note) as call:
        desc.callbacks = call.callbacks
        return BagResult(_reported(call, library.fb_bag, desc), call.notes)


def check_bag(folder: Place, *, threads: int = 0, progress: Progress = None, note: Note = None) -> BagResult:
    """Checks a BagIt bag of anyone: its structure, every file against every checksum, and whether its archives evaluate as
    archived. Faults are no exception: see the result."""
    desc = library.filled(abi.fb_bag_check_desc)
    desc.directory = path_bytes(folder)
    assign(desc, threads=threads)
    with Call(progress, note) as call:
        desc.callbacks = call.callbacks
        return BagResult(_reported(call, library.fb_bag_check, desc), call.notes)


def pack(
    archive: Union[Place, bytes],
    out: Optional[Place] = None,
    *,
    force: bool = False,
    seed: int = 1,
    max_bytes: int = 0,
    max_error: float = 0.0,
    licence: Optional[str] = None,
    about: Optional[About] = None,
    thumbnail: Optional[bytes] = None,
    sockets: Sequence[Socket] = (),
    progress: Progress = None,
    note: Note = None,
) -> PackResult:
    """Packs an archive again, without training: into this version of the format, into fewer bytes, with another licence.

    archive: a path, or bytes. out: the .fbk to write, which may be the same; None: the result has the bytes. max_bytes,
    max_error, force: as for bake, where errors are displacements. licence, about, thumbnail: in place of the archive's;
    None: kept. sockets: added, or in place of those of the same names."""
    desc = library.filled(abi.fb_pack_desc)
    assign(desc, force=force, seed=seed, max_bytes=max_bytes, max_error=max_error)
    if isinstance(archive, bytes):
        desc.bytes, desc.byte_count = cast(c_char_p(archive), c_void_p), len(archive)
    else:
        desc.path = path_bytes(archive)
    desc.out, desc.licence = _optional_path(out), _optional_text(licence)
    _set_texts(desc, about, thumbnail)
    if sockets:
        desc.sockets = json.dumps([socket_fields(socket) for socket in sockets]).encode()
    with Call(progress, note) as call:
        desc.callbacks = call.callbacks
        report = _reported(call, library.fb_pack, desc)
    return PackResult(report, call.notes)


@contextlib.contextmanager
def _opened(source: AnySource, progress: Progress, note: Note) -> Iterator[Tuple[Source, Call]]:
    """An open source, closed at the end unless it came open, and a call."""
    with contextlib.ExitStack() as stack:
        if isinstance(source, Source):
            opened, notes = source, []
        else:
            opened = stack.enter_context(Source(source, progress=progress, note=note))
            notes = list(opened.notes)
        call = stack.enter_context(Call(progress, note))
        call.notes += notes
        yield opened, call


def _run(function: Any, desc: Any, source: AnySource, progress: Progress, note: Note) -> Tuple[c_void_p, List[str]]:
    """The report of a call on a source, and its notes."""
    with _opened(source, progress, note) as (opened, call):
        desc.source, desc.callbacks = opened.handle, call.callbacks
        return _reported(call, function, desc, rig=opened.host_rig), call.notes


def _reported(call: Call, function: Any, *arguments: Any, rig: Any = None) -> c_void_p:
    """Runs a call and gives its report, which the caller owns."""
    report = c_void_p()
    try:
        call.run(function, *arguments, byref(report), rig=rig)
    except BaseException:  # of a callback, or Ctrl-C, when the call was done already
        library.fb_report_free(report)
        raise
    return report


def _set_plan(desc: abi.fb_sample_desc, folder: Place, mix: str, examples: Sequence[Place]) -> None:
    desc.directory, desc.mix = path_bytes(folder), text_bytes(mix)
    desc.examples, desc.example_count = _paths(examples)


def _run_planned(
    function: Any, desc: abi.fb_sample_desc, source: AnySource, clips: Sequence[Clip], progress: Progress, note: Note
) -> Tuple[c_void_p, List[str]]:
    """As _run, for calls that plan poses and take clips besides."""
    kept: List[Any] = []  # until the call is over
    with _opened(source, progress, note) as (opened, call):
        structs = [clip_struct(_planned(clip, opened), kept) for clip in clips]
        desc.clips, desc.clip_count = (abi.fb_rig_clip * len(structs))(*structs), len(structs)
        desc.clip_stride = sizeof(abi.fb_rig_clip)
        desc.source, desc.callbacks = opened.handle, call.callbacks
        return _reported(call, function, desc, rig=opened.host_rig), call.notes


def _planned(clip: Clip, source: Source) -> Clip:
    controls = floats(clip.controls, (None, len(source.controls)), f'clip "{clip.name}": controls')
    _number(SPLITS, clip.split, "split")
    return Clip(clip.name, controls, clip.kind, clip.split, clip.fps)


def _named(values: Mapping[str, OptionValue]) -> Tuple[Any, int]:
    """Options by name, as fb_bake_desc takes them. A flag is True or False."""
    texts = [f"{name}={int(value) if isinstance(value, bool) else value}" for name, value in values.items()]
    return c_strings([text_bytes(text) for text in texts])


def _set_levels(desc: abi.fb_bake_desc, shares: Sequence[float], meshes: Sequence[Place]) -> None:
    desc.level_meshes, desc.level_mesh_count = _paths(meshes)
    desc.level_shares, desc.level_share_count = (c_double * len(shares))(*shares), len(shares)


def _set_texts(desc: Any, about: Optional[About], thumbnail: Optional[bytes]) -> None:
    if about is not None:
        desc.about = json.dumps(about).encode()
    if thumbnail is not None:
        desc.thumbnail, desc.thumbnail_bytes = cast(c_char_p(thumbnail), c_void_p), len(thumbnail)


def _number(words: Sequence[str], word: str, what: str) -> int:
    if word not in words:
        raise ValueError(f"{what} is {word!r}, none of {', '.join(words)}")
    return words.index(word)


def _measures(words: Sequence[str]) -> int:
    if isinstance(words, str):
        words = [words]
    return sum(1 << _number(_MEASURES, word, "measure") for word in set(words))


def _paths(paths: Sequence[Place]) -> Tuple[Any, int]:
    if isinstance(paths, (str, os.PathLike)):
        paths = [paths]
    return c_strings([path_bytes(path) for path in paths])


def _optional_day(day: Union[str, datetime.date, None]) -> Optional[bytes]:
    return _optional_text(day.isoformat()[:10] if isinstance(day, datetime.date) else day)


def _optional_text(text: Optional[str]) -> Optional[bytes]:
    return None if text is None else text_bytes(text)


def _optional_path(path: Optional[Place]) -> Optional[bytes]:
    return None if path is None else path_bytes(path)
