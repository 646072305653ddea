"""The settings file: what of a scene is baked, and how. The window writes it, and the processes that do the work read it;
it can be edited by hand. Without Blender."""

from __future__ import annotations

import hashlib
import json
import os
import pathlib
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any, Dict, List, Mapping, Sequence, Tuple, Union

from .channels import Channel, SceneControl, SettingsError, channel_fields

FORMAT = "facebaker-blender"
VERSION = 1
MODIFIER_POLICIES = ("refuse", "apply", "off")
JOINT_POLICIES = ("keep", "none")
SPLITS = ("train", "validation", "test")

Path = Union[str, "os.PathLike[str]"]


@dataclass(frozen=True)
class Shot:
    """An action that animates controls. first, last: frames, both included; split: "test" (measured on), "train"
    (learnt from by a bake for a backlot) or "validation"."""

    action: str
    first: int
    last: int
    split: str = "test"

    def __post_init__(self) -> None:
        if self.split not in SPLITS:
            raise SettingsError(f'shot "{self.action}": split "{self.split}" is none of {", ".join(SPLITS)}')
        if self.last < self.first:
            raise SettingsError(f'shot "{self.action}": ends at frame {self.last}, before {self.first}')


@dataclass(frozen=True)
class BakeOptions:
    """Options of `facebaker bake`; 0 and "" leave them to the tool.

    rig_budget: poses that are asked of the rig in order to learn. poses: that are drawn. workers: Blender processes that
    evaluate. use: "variant" (shots are not learnt from) or "backlot". threads: of the bake itself, 0: all cores. extra:
    further words of the command line."""

    recipe: str = "hero"
    use: str = "variant"
    rig_budget: int = 20000
    poses: int = 0
    workers: int = 2
    epochs: int = 0
    seed: int = 0
    threads: int = 0
    reuse: str = ""
    extra: Tuple[str, ...] = ()


@dataclass(frozen=True)
class BakeSettings:
    """meshes: names of mesh objects, in the order of the face's vertices. reference: the object in whose space positions
    are ("": the first mesh). modifiers: what happens to modifiers that change the number of vertices: "refuse" names
    them and stops; "apply" bakes the mesh as they make it; "off" switches them off during the bake. driven_joints: what
    becomes of bones that the controls move: "keep" makes them joints of the face, where meshes follow them by linear
    blend skinning; with "none" vertices alone learn what they do."""

    name: str
    meshes: Tuple[str, ...]
    controls: Tuple[SceneControl, ...]
    reference: str = ""
    shots: Tuple[Shot, ...] = ()
    modifiers: str = "refuse"
    bake: BakeOptions = field(default_factory=BakeOptions)
    driven_joints: str = "none"

    def __post_init__(self) -> None:
        if not self.name:
            raise SettingsError("the character has no name")
        if not self.meshes:
            raise SettingsError("no mesh is chosen")
        if self.modifiers not in MODIFIER_POLICIES:
            raise SettingsError(f'modifiers "{self.modifiers}" is none of {", ".join(MODIFIER_POLICIES)}')
        if self.driven_joints not in JOINT_POLICIES:
            raise SettingsError(f'driven_joints "{self.driven_joints}" is none of {", ".join(JOINT_POLICIES)}')
        for what, names in (("mesh", list(self.meshes)), ("control", [control.name for control in self.controls])):
            repeated = sorted({name for name in names if names.count(name) > 1}) if len(set(names)) < len(names) else []
            if repeated:
                raise SettingsError(f'two of {what} "{repeated[0]}"')

    def without(self, names: Sequence[str]) -> "BakeSettings":
        """Without the controls of these names."""
        dropped = set(names)
        return replace(self, controls=tuple(control for control in self.controls if control.name not in dropped))

    @property
    def deformation(self) -> str:
        """A digest of what decides where vertices are, which the options of the bake and the shots do not."""
        document = settings_document(self)
        for key in "bake", "shots":
            del document[key]
        return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()[:16]

    @property
    def sampling(self) -> str:
        """A digest of what decides which poses are asked of the rig: a work folder holds those of one such digest."""
        free = {"workers", "threads", "reuse", "epochs"}
        options = {key: value for key, value in asdict(self.bake).items() if key not in free}
        shots = [asdict(shot) for shot in self.shots]
        return hashlib.sha256(json.dumps([options, shots], sort_keys=True).encode()).hexdigest()[:16]


def settings_document(settings: BakeSettings) -> Dict[str, Any]:
    """As JSON."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": settings.name,
        "meshes": list(settings.meshes),
        "reference": settings.reference,
        "modifiers": settings.modifiers,
        "driven_joints": settings.driven_joints,
        "bake": {**asdict(settings.bake), "extra": list(settings.bake.extra)},
        "shots": [asdict(shot) for shot in settings.shots],
        "controls": [_control_fields(control) for control in settings.controls],
    }


def _control_fields(control: SceneControl) -> Dict[str, Any]:
    document: Dict[str, Any] = {"name": control.name}
    if control.group:
        document["group"] = control.group
    document.update(min=control.minimum, max=control.maximum, rest=control.rest)
    if control.mirror:
        document["mirror"] = control.mirror
    return {**document, "channel": channel_fields(control.channel)}


def settings_text(settings: BakeSettings) -> str:
    """As readable JSON: a control and a shot a line."""
    document = settings_document(settings)
    lists = {key: document.pop(key) for key in ("shots", "controls")}
    text = json.dumps(document, indent=1, ensure_ascii=False)[:-2]
    for key, items in lists.items():
        rows = ",\n  ".join(json.dumps(item, ensure_ascii=False) for item in items)
        text += f',\n "{key}": [' + (f"\n  {rows}\n ]" if items else "]")
    return text + "\n}\n"


def save_settings(settings: BakeSettings, path: Path) -> None:
    """Writes a settings file, complete or not at all. Raises OSError."""
    target = pathlib.Path(path)
    partial = target.with_name(target.name + ".facebaker-partial")
    partial.write_text(settings_text(settings), encoding="utf-8")
    os.replace(partial, target)


def load_settings(path: Path) -> BakeSettings:
    """Raises OSError, and SettingsError that names the file and what is wrong in it."""
    try:
        return settings_of(json.loads(pathlib.Path(path).read_text(encoding="utf-8")))
    except (SettingsError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise SettingsError(f"{os.fspath(path)}: {error}") from None


def settings_of(document: Any) -> BakeSettings:
    """The settings of a JSON document. Raises SettingsError."""
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise SettingsError(f"its format is not {FORMAT}")
    if document.get("version") != VERSION:
        raise SettingsError(f"version {document.get('version')}; {VERSION} is read")
    return BakeSettings(
        name=_typed(document, "name", str),
        meshes=tuple(_typed_items(document, "meshes", str)),
        controls=tuple(_control(item) for item in _typed_items(document, "controls", dict)),
        reference=_typed(document, "reference", str, ""),
        shots=tuple(_record(Shot, item, "shot") for item in _typed_items(document, "shots", dict, [])),
        modifiers=_typed(document, "modifiers", str, "refuse"),
        driven_joints=_typed(document, "driven_joints", str, "none"),
        bake=_bake_options(_typed(document, "bake", dict, {})),
    )


def _bake_options(item: Mapping[str, Any]) -> BakeOptions:
    extra = _typed_items(item, "extra", str, [])
    options: BakeOptions = _record(BakeOptions, {**item, "extra": tuple(extra)}, "bake")
    return options


def _control(item: Mapping[str, Any]) -> SceneControl:
    name = _typed(item, "name", str)
    low, high, rest = (float(_typed(item, key, (int, float))) for key in ("min", "max", "rest"))
    channel: Channel = _record(Channel, _typed(item, "channel", dict), f'control "{name}": channel')
    return SceneControl(name, channel, low, high, rest, _typed(item, "group", str, ""), _typed(item, "mirror", str, ""))


def _record(kind: Any, item: Mapping[str, Any], what: str) -> Any:
    """A dataclass of JSON's types. Keys that are not known are refused: a misspelt one would have no effect."""
    known = {entry.name: entry for entry in fields(kind)}
    unknown = sorted(set(item) - set(known))
    if unknown:
        raise SettingsError(f'{what}: has no "{unknown[0]}"; there are {", ".join(known)}')
    types = {"int": int, "str": str, "bool": bool, "Tuple[str, ...]": tuple}
    for key, value in item.items():
        wanted = types[str(known[key].type)]
        if not isinstance(value, wanted) or wanted is int and isinstance(value, bool):
            raise SettingsError(f'{what}: "{key}" is {json.dumps(value)}, no {wanted.__name__}')
    try:
        return kind(**item)
    except TypeError as error:
        raise SettingsError(f"{what}: {str(error).split(') ')[-1]}") from None


_REQUIRED: Any = object()


def _typed(item: Mapping[str, Any], key: str, kind: Any, default: Any = _REQUIRED) -> Any:
    if key not in item:
        if default is _REQUIRED:
            raise SettingsError(f'"{key}" is missing')
        return default
    value = item[key]
    if not isinstance(value, kind) or isinstance(value, bool) and kind is not bool:
        raise SettingsError(f'"{key}" is {json.dumps(value)[:80]}')
    return value


def _typed_items(item: Mapping[str, Any], key: str, kind: Any, default: Any = _REQUIRED) -> List[Any]:
    items: List[Any] = _typed(item, key, list, default)
    for index, value in enumerate(items):
        if not isinstance(value, kind):
            raise SettingsError(f'"{key}", entry {index}: {json.dumps(value)[:80]}')
    return items
