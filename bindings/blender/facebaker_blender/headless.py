"""FaceBaker without Blender's window:

    blender -b scene.blend -P headless.py -- controls --out face.json
    blender -b scene.blend -P headless.py -- bake --out face.fbk
    blender -b scene.blend -P headless.py -- show face.fbk --picture face.png

`-- COMMAND --help` lists the options. docs/blender.md explains them."""

from __future__ import annotations

import argparse
import hashlib
import os
import pathlib
import signal
import sys
import time
import traceback
from dataclasses import replace
from typing import TYPE_CHECKING, Any, List, Sequence

if __name__ == "__main__":
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from facebaker_blender.bake_settings import (
    JOINT_POLICIES, MODIFIER_POLICIES, BakeOptions, BakeSettings, Shot, load_settings, save_settings,
)  # fmt: skip
from facebaker_blender.channels import SettingsError, there_are
from facebaker_blender.tool_command import add_package_path, find_tool

if TYPE_CHECKING:
    from facebaker_blender.bake_job import BakeJob


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, as the tool does."""

    def error(self, message: str) -> Any:
        self.exit(2, f"{self.prog}: {message}\n")


def make_parser() -> argparse.ArgumentParser:
    """The command line behind Blender's --."""
    parser = _Parser(prog="facebaker_blender", description="Bakes the face of a Blender scene.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=_Parser)
    controls = commands.add_parser("controls", help="find the controls of the scene and write a settings file")
    controls.add_argument("--out", required=True, metavar="FILE.json")
    _add_import_option(controls)
    _add_find_options(controls)
    bake = commands.add_parser("bake", help="bake the scene, measure the face and show it")
    bake.add_argument("--out", required=True, metavar="FACE.fbk")
    bake.add_argument("--settings", metavar="FILE.json", help="what to bake; without it controls are found")
    _add_import_option(bake)
    _add_find_options(bake)
    _add_bake_options(bake)
    _add_show_options(bake)
    show = commands.add_parser("show", help="measure a baked face against the scene and show it beside it")
    show.add_argument("face", metavar="FACE.fbk")
    show.add_argument("--settings", metavar="FILE.json", help="of the bake; by default those beside the archive")
    _add_show_options(show)
    return parser


def _add_import_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--import", dest="imported", default="", metavar="FILE",
                        help=".fbx, .usd, or what else this Blender imports, in place of a scene; of its bones those are "
                        "controls that its actions move")  # fmt: skip


def _add_find_options(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument_group("what is baked").add_argument
    add("--name", default="", help="of the character; by default that of the first mesh")
    add("--mesh", action="append", default=[], metavar="NAME", help="a mesh (repeatable); by default all that are shown")
    add("--armature", action="append", default=[], metavar="NAME",
        help="an armature (repeatable); by default those that deform or carry the meshes")  # fmt: skip
    add("--bones", action="append", default=[], metavar="PATTERN", help="bones by name, with * and ? (repeatable)")
    add("--collections", action="append", default=[], metavar="NAME",
        help="bone collections, before Blender 4 numbers of bone layers from 0 on (repeatable, commas); by default what "
        "is visible")  # fmt: skip
    add("--channels", default="location,rotation", metavar="KINDS",
        help="of location, rotation, scale (default: %(default)s); others that are limited or animated are found anyway")  # fmt: skip
    add("--modifiers", choices=MODIFIER_POLICIES, default="refuse",
        help="what happens to modifiers that change the number of vertices (default: %(default)s)")  # fmt: skip
    add("--driven-joints", choices=JOINT_POLICIES, default="none",
        help="what becomes of bones that the controls move: keep, they are joints of the face; or none, vertices alone "
        "learn what they do (default: %(default)s)")  # fmt: skip
    add("--train-shot", action="append", default=[], metavar="ACTION", help="a shot that may be learnt from (repeatable)")
    add("--keep-still", action="store_true", help="keep controls that move no vertex")


def _add_bake_options(parser: argparse.ArgumentParser) -> None:
    usual = BakeOptions()
    add = parser.add_argument_group("how it is baked (see facebaker bake --help)").add_argument
    add("--recipe", default=None)
    add("--use", choices=("variant", "backlot"), default=None)
    add("--rig-budget", type=int, default=None, help=f"poses asked in order to learn (default: {usual.rig_budget})")
    for option in "--poses", "--epochs", "--seed", "--threads":
        add(option, type=int, default=None)
    add("--workers", type=int, default=None, help=f"Blender processes that evaluate (default: {usual.workers})")
    add("--reuse", default=None, metavar="DIR",
        help="work folder of another bake, NAME.blender/work; of this one's, what still holds is taken over anyway")  # fmt: skip
    add("--tool", default="", metavar="FACEBAKER", help="the program; by default the one found")
    add("--only-prepare", action="store_true", help="write the copy of the scene and print the command line")


def _add_show_options(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument_group("how it is shown").add_argument
    add("--drawn", type=int, default=200, metavar="N", help="drawn poses to measure on (default: %(default)s)")
    add("--json", metavar="FILE", help="write what was measured")
    add("--preview", metavar="FILE.blend", help="save the scene with the baked face beside the rig")
    add("--picture", metavar="FILE.png", help="render rig, face and errors in the frame of the largest error")


def found_settings(options: argparse.Namespace) -> BakeSettings:
    """The settings of the open file with controls that are found. Raises SettingsError."""
    import bpy

    from facebaker_blender.action_shots import find_shots
    from facebaker_blender.bone_choice import FindOptions
    from facebaker_blender.find_controls import find_controls, groups_of, still_controls
    from facebaker_blender.scene_choice import chosen_armatures, chosen_meshes
    from facebaker_blender.scene_evaluator import SceneEvaluator

    meshes = chosen_meshes(bpy.context, options.mesh)
    armatures = chosen_armatures(meshes, options.armature)
    collections = tuple(name.strip() for words in options.collections for name in words.split(",") if name.strip())
    kinds = tuple(kind.strip() for kind in options.channels.split(",") if kind.strip())
    find = FindOptions(tuple(options.bones), collections, kinds=kinds, moved=bool(options.imported))
    controls, notes = find_controls(armatures, meshes, find)
    if not controls and find.moved:  # a file without actions
        controls, notes = find_controls(armatures, meshes, replace(find, moved=False))
    if not controls:
        raise SettingsError("no controls were found: no unlocked channels of visible bones, shape keys or properties")
    reference = armatures[0].name if armatures else meshes[0].name
    settings = BakeSettings(
        options.name or meshes[0].name, tuple(mesh.name for mesh in meshes), tuple(controls), reference,
        modifiers=options.modifiers, driven_joints=options.driven_joints,
    )  # fmt: skip
    if not options.keep_still:
        with SceneEvaluator(settings) as evaluator:
            still = still_controls(evaluator)
        settings = settings.without(still)
        if still:
            notes.append(f"{len(still)} of {len(controls)} channels move no vertex and are left out")
        if not settings.controls:
            raise SettingsError("none of the channels that were found moves a vertex")
    shots = _with_splits(find_shots(settings.controls), options.train_shot)
    for note in notes:
        say(f"note: {note}")
    groups = ", ".join(f"{name or 'no group'} {count}" for name, count in sorted(groups_of(settings.controls).items()))
    say(f"{len(settings.controls)} controls: {groups}; {len(shots)} shots")
    return replace(settings, shots=tuple(shots))


def _with_splits(shots: "List[Shot]", learnt: Sequence[str]) -> "List[Shot]":
    """The shots, those of these actions to learn from. Raises SettingsError if there is no such shot."""
    for action in learnt:
        if action not in [shot.action for shot in shots]:
            known = there_are((shot.action for shot in shots), action)
            raise SettingsError(f'no action that animates controls is called "{action}"; {known}')
    return [replace(shot, split="train") if shot.action in learnt else shot for shot in shots]


def refuse_find_options(options: argparse.Namespace) -> None:
    """Raises SettingsError if the command line says what is baked although a settings file does."""
    parser = _Parser(add_help=False)
    _add_find_options(parser)
    for name, usual in vars(parser.parse_args([])).items():
        if getattr(options, name) != usual:
            raise SettingsError(f"--settings says what is baked; --{name.replace('_', '-')} has no meaning beside it")


def with_bake_options(settings: BakeSettings, options: argparse.Namespace) -> BakeSettings:
    """The settings with the options of the command line, where these were given."""
    names = ("recipe", "use", "rig_budget", "poses", "epochs", "seed", "threads", "workers", "reuse")
    given = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    return replace(settings, bake=replace(settings.bake, **given))


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def open_imported(options: argparse.Namespace) -> None:
    """Imports what the command line says. Raises SettingsError, also where a scene is open that it would take the place
    of."""
    import bpy

    from facebaker_blender.import_file import import_scene

    if not options.imported:
        return
    if bpy.data.filepath:
        raise SettingsError("--import takes the place of a scene: call Blender without one")
    import_scene(pathlib.Path(options.imported), pathlib.Path(options.out).resolve().with_suffix(".blender"))


def run_controls(options: argparse.Namespace) -> None:
    open_imported(options)
    settings = found_settings(options)
    save_settings(settings, options.out)
    print(options.out)


def run_bake(options: argparse.Namespace) -> None:
    import shlex

    from facebaker_blender.bake_job import BakeJob

    begin = time.monotonic()
    job = BakeJob(options.out)
    tool = find_tool()
    if options.settings:
        refuse_find_options(options)
    open_imported(options)
    settings = load_settings(options.settings) if options.settings else found_settings(options)
    settings = with_bake_options(settings, options)
    session = session_digest(sys.argv)
    if options.only_prepare:
        job.prepare(settings, session)
        print(shlex.join(job.words(settings, tool)))
        return
    # Blender would take Ctrl-C for itself, and the bake in its own session would go on.
    for number in signal.SIGINT, signal.SIGTERM:
        signal.signal(number, signal.default_int_handler)
    job.start(settings, tool, session)
    _follow(job)
    job.tidy()
    say(f"baked in {time.monotonic() - begin:.0f} s")
    _show(job.archive, settings, options)
    say(f"all done in {time.monotonic() - begin:.0f} s")


def session_digest(arguments: Sequence[str]) -> str:
    """A digest of what Blender's command line did to the file that it opened: its options before --, and the scripts that
    these name, without this one."""
    words = list(arguments[1 : arguments.index("--")] if "--" in arguments else arguments[1:])
    digest = hashlib.sha256()
    for word in words:
        script = pathlib.Path(word)
        if script.suffix == ".py" and script.is_file():
            own = script.resolve() == pathlib.Path(__file__).resolve()
            digest.update(b"" if own else script.read_bytes())
        else:
            digest.update(word.encode() + b"\0")
    return digest.hexdigest()


def _follow(job: "BakeJob") -> None:
    """Tells how the bake goes until it ends. Ctrl-C ends the bake, which the same command goes on with."""
    told, notes = "", 0
    try:
        while not job.process.wait(0.5) or job.process.poll():
            job.process.poll()
            progress = job.process.progress
            for note in progress.notes[notes:]:
                say(f"note: {note}")
            notes = len(progress.notes)
            if progress.text != told:
                told = progress.text
                say(told)
    except KeyboardInterrupt:
        job.process.stop()
        job.process.wait(30)
        raise SettingsError("interrupted; what is done is kept, run the same command to go on") from None
    job.process.poll()
    for note in job.process.progress.notes[notes:]:
        say(f"note: {note}")
    if job.process.document is None:
        raise SettingsError(f"{job.process.progress.error or 'the bake failed'}; its log is {job.process.log}")


def run_show(options: argparse.Namespace) -> None:
    archive = pathlib.Path(options.face).resolve()
    beside = archive.with_suffix(".blender") / "settings.json"
    _show(archive, load_settings(options.settings or beside), options)


def _show(archive: pathlib.Path, settings: BakeSettings, options: argparse.Namespace) -> None:
    import facebaker

    from facebaker_blender.bake_job import save_json
    from facebaker_blender.face_measure import measure_face
    from facebaker_blender.scene_evaluator import SceneEvaluator

    face = facebaker.load(archive)
    with SceneEvaluator(settings) as evaluator:
        measure = measure_face(face, evaluator, options.drawn)
    print("\n".join([str(archive), *measure.lines()]), flush=True)
    if options.json:
        save_json(measure.document(), options.json)
    if options.preview or options.picture:
        from facebaker_blender.show_face import save_preview

        save_preview(archive, settings, options.preview, options.picture)


def main(words: Sequence[str]) -> int:
    """Runs a command; its exit code."""
    options = make_parser().parse_args(words)
    if getattr(options, "tool", ""):
        os.environ["FACEBAKER_TOOL"] = options.tool
    try:
        add_package_path()
        {"controls": run_controls, "bake": run_bake, "show": run_show}[options.command](options)
    except KeyboardInterrupt:
        say(f"facebaker_blender {options.command}: interrupted")
        return 1
    except Exception as error:  # Blender would end with 0 after any that reaches it
        if not isinstance(error, (SettingsError, OSError)) and not _is_of_library(error):
            traceback.print_exc()
            error = RuntimeError(f"failed, which it should not: {type(error).__name__}: {error}")
        say(f"facebaker_blender {options.command}: {error}")
        return 1
    return 0


def _is_of_library(error: Exception) -> bool:
    """Whether it is a facebaker.Error, whose text is for people."""
    package = sys.modules.get("facebaker")
    return package is not None and isinstance(error, package.Error)


def own_words(arguments: List[str]) -> List[str]:
    """What stands behind Blender's --."""
    return arguments[arguments.index("--") + 1 :] if "--" in arguments else []


if __name__ == "__main__":
    sys.exit(main(own_words(sys.argv)))
