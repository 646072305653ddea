"""Serves a Python rig to FaceBaker over the rig protocol (docs/rig-protocol.md):

    facebaker bake "exec:python3 -m facebaker.serve module:function" --out face.fbk

`module` is imported, from the working folder too; `function` is a facebaker.Rig, or returns one when it is called with
the words that follow. Needs NumPy and none of FaceBaker's libraries. A program that is a Python interpreter of its own,
such as an animation package, calls serve(rig)."""

from __future__ import annotations

import importlib
import json
import os
import struct
import sys
import traceback
from typing import Any, BinaryIO, Dict, List, Optional, Sequence, Tuple

import numpy as np

from ._arrays import Floats
from ._fields import character_fields
from ._rig import Rig, describe

PROTOCOL_VERSION = 1
_HEADER = struct.Struct("<4sIQ")
_SIGNATURE = b"FBR1"


def serve(rig: Rig, requests: Optional[BinaryIO] = None, answers: Optional[BinaryIO] = None) -> None:
    """Answers what FaceBaker asks about `rig` until it says bye or is gone, on the calling thread.

    requests, answers: binary streams; None: the pipes that FaceBaker gives to the processes it starts. What the rig
    raises is told to FaceBaker with the pose that did it. What it prints goes to FaceBaker's standard error. Raises
    RuntimeError if nobody is at the other end, or what comes is no request."""
    if requests is None or answers is None:
        requests, answers = _pipes()
    if rig.evaluate is None:
        return _write(answers, _error(f'"{rig.name}" is a recording, which has no new poses'))
    server = _Server(rig)
    while True:
        request = _read(requests)
        if request is None or request[0]["type"] == "bye":
            return None
        _write(answers, *server.answer(*request))
        _flush_prints()


def serve_failure(error: Exception) -> None:
    """Tells FaceBaker, through the pipes that it gives to the processes it starts, why there is no rig. The traceback is
    printed. Raises RuntimeError if nobody is at the other end."""
    _, answers = _pipes()
    traceback.print_exception(type(error), error, error.__traceback__)
    _write(answers, _error(describe(error)))


class _Server:
    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._told = False  # how the rig first failed, by a traceback

    def answer(self, request: Dict[str, Any], data: bytes) -> List[Any]:
        """The fields of the answer and its buffers."""
        if request["type"] == "hello":
            if request["version"] != PROTOCOL_VERSION:
                return [_error(f"version {request['version']} of the rig protocol; {PROTOCOL_VERSION} is spoken")]
            return self._hello()
        if request["type"] != "evaluate":
            raise RuntimeError(f"a request of type {request['type']!r}")
        controls: Floats = np.frombuffer(data, "<f4").reshape(request["poses"], len(self._rig.controls))
        return self._evaluate(controls.astype(np.float32))

    def _hello(self) -> List[Any]:
        rig = self._rig
        fields = {
            "type": "hello",
            "version": PROTOCOL_VERSION,
            **character_fields(rig, [{"bytes": len(image.data)} for image in rig.images]),
            "vertices": len(rig.rest_positions),
            "polygons": len(rig.polygon_sizes),
            "uvs": len(rig.uvs),
            "preferred_block": rig.preferred_block,
            "rig_version": rig.version,
            "notes": list(rig.notes),
            "skin_influences": rig.skin.weights.shape[1] if rig.skin else 0,
            "skinned": rig.skinned,
            "clips": [
                {"name": clip.name, "kind": clip.kind, "split": clip.split, "fps": clip.fps,
                 "frames": len(np.asarray(clip.controls))}
                for clip in rig.clips
            ],
        }  # fmt: skip
        data = [_little(rig.rest_positions, "f4"), _little(rig.polygon_sizes, "u4"), _little(rig.polygon_corners, "u4")]
        data += [_little(rig.uvs, "f4"), _little(rig.uv_corners, "u4")]
        data += [np.frombuffer(image.data, np.uint8) for image in rig.images]
        if rig.skin:
            data += [_little(rig.skin.joints, "u2"), _little(rig.skin.weights, "f4")]
        return [fields, *data, *[_little(clip.controls, "f4") for clip in rig.clips]]

    def _evaluate(self, controls: Floats) -> List[Any]:
        result, error = self._attempt(controls)
        if error is not None:
            return [self._failure(controls, error)]
        fields = {"type": "points", "poses": len(controls)}
        return [fields, *[_little(array, "f4") for array in result]]

    def _attempt(self, controls: Floats) -> Tuple[Sequence[Floats], Optional[Exception]]:
        try:
            return self._rig.evaluate_poses(controls), None
        except Exception as error:
            return (), error

    def _failure(self, controls: Floats, error: Exception) -> Dict[str, Any]:
        """Which of the poses fails, and why: each is tried alone."""
        if len(controls) == 1:
            return self._tell(error, 0)
        for pose in range(len(controls)):
            _, alone = self._attempt(controls[pose : pose + 1])
            if alone is not None:
                return self._tell(alone, pose)
        return self._tell(error, None)

    def _tell(self, error: Exception, pose: Optional[int]) -> Dict[str, Any]:
        if not self._told:
            traceback.print_exception(type(error), error, error.__traceback__)
        self._told = True
        fields = _error(describe(error))
        return fields if pose is None else {**fields, "pose": pose}


def _error(message: str) -> Dict[str, Any]:
    return {"type": "error", "message": message}


def _little(array: Any, kind: str) -> Any:
    """Contiguous and little-endian; on the usual machines without a copy."""
    return np.ascontiguousarray(array, "<" + kind)


def _pipes() -> Tuple[BinaryIO, BinaryIO]:
    streams: List[Any] = []
    for variable, mode in ("FACEBAKER_RIG_REQUESTS", "rb"), ("FACEBAKER_RIG_ANSWERS", "wb"):
        text = os.environ.get(variable)
        if text is None:
            raise RuntimeError(
                'nobody asks: this is started by FaceBaker, as in facebaker bake "exec:python3 -m facebaker.serve '
                'module:function" --out face.fbk'
            )
        os.set_inheritable(int(text), False)  # what the rig starts would keep the pipes open
        streams.append(os.fdopen(int(text), mode, closefd=False))
    return streams[0], streams[1]


def _read(requests: BinaryIO) -> Optional[Tuple[Dict[str, Any], bytes]]:
    header = requests.read(_HEADER.size)
    if not header:
        return None
    if len(header) < _HEADER.size:
        raise RuntimeError("the requests end within a message")
    signature, text_size, data_size = _HEADER.unpack(header)
    if signature != _SIGNATURE:
        raise RuntimeError(f"{signature!r} where a message begins with {_SIGNATURE!r}")
    text, data = requests.read(text_size), requests.read(data_size)
    if len(text) < text_size or len(data) < data_size:
        raise RuntimeError("the requests end within a message")
    request = json.loads(text)
    if not isinstance(request, dict) or "type" not in request:
        raise RuntimeError("a request without a type")
    return request, data


def _write(answers: BinaryIO, fields: Dict[str, Any], *data: Any) -> None:
    text = json.dumps(fields).encode() + b"\n"
    answers.write(_HEADER.pack(_SIGNATURE, len(text), sum(array.nbytes for array in data)) + text)
    for array in data:
        if array.nbytes:
            answers.write(memoryview(array).cast("B"))
    answers.flush()


def _flush_prints() -> None:
    for stream in sys.stdout, sys.stderr:
        if stream is not None:
            stream.flush()


def load_rig(target: str, arguments: Sequence[str] = ()) -> Rig:
    """The rig that "module:function" names; see the module's own text. Raises what the module or the function does,
    ValueError or TypeError where there is no rig."""
    module, colon, name = target.partition(":")
    if not (module and colon and name):
        raise ValueError(f'"{target}" is not module:function')
    found: Any = importlib.import_module(module)
    for part in name.split("."):
        found = getattr(found, part)
    rig = found if isinstance(found, Rig) else found(*arguments)
    if not isinstance(rig, Rig):
        raise TypeError(f"{target} gave {type(rig).__name__}, not a facebaker.Rig")
    return rig


def main(arguments: Sequence[str]) -> int:
    """What `python -m facebaker.serve` does: its exit code."""
    if not arguments:
        print("usage: python -m facebaker.serve module:function [ARGUMENT...]", file=sys.stderr)
        return 2
    try:
        requests, answers = _pipes()
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 2
    try:
        rig = load_rig(arguments[0], arguments[1:])
    except Exception as error:
        serve_failure(error)
        return 1
    serve(rig, requests, answers)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
