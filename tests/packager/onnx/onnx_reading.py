"""Reads ONNX files and evaluates them with NumPy, as far as exported faces need it, by the public descriptions of
Protocol Buffers and of the operators of set 13. Independent of the writer."""
import struct

import numpy as np


def fields(data):
    """Yields (number, value) for the fields of a message: whole numbers, or bytes."""
    place = 0
    while place < len(data):
        key, place = varint(data, place)
        if key & 7 == 0:
            value, place = varint(data, place)
        elif key & 7 == 2:
            size, place = varint(data, place)
            value, place = data[place:place + size], place + size
            if len(value) != size:
                raise ValueError("a field is longer than its message")
        else:
            raise ValueError(f"wire type {key & 7}")
        yield key >> 3, value


def varint(data, place):
    value = shift = 0
    while True:
        byte = data[place]
        place += 1
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return value, place


def signed(value):
    return value - (1 << 64) if value >> 63 else value


def tensor(data):
    shape, kind, name, raw = [], 0, "", b""
    for number, value in fields(data):
        if number == 1:
            shape.append(signed(value))
        elif number == 2:
            kind = value
        elif number == 8:
            name = value.decode()
        elif number == 9:
            raw = value
    return name, np.frombuffer(raw, {1: "<f4", 7: "<i8"}[kind]).reshape(shape)


class Node:
    def __init__(self, data):
        self.inputs, self.output, self.type, self.attributes = [], None, "", {}
        for number, value in fields(data):
            if number == 1:
                self.inputs.append(value.decode())
            elif number == 2:
                self.output = value.decode()
            elif number == 4:
                self.type = value.decode()
            elif number == 5:
                self.add_attribute(value)

    def add_attribute(self, data):
        name, one, many, kind = "", 0, [], 0
        for number, value in fields(data):
            if number == 1:
                name = value.decode()
            elif number == 3:
                one = signed(value)
            elif number == 8:
                many.append(signed(value))
            elif number == 20:
                kind = value
        self.attributes[name] = {2: one, 7: many}[kind]


def value_info(data):
    """Name and shape of an input or output."""
    name, shape = "", []
    for number, value in fields(data):
        if number == 1:
            name = value.decode()
        elif number == 2:
            (_, tensor_type), = fields(value)
            parts = dict(fields(tensor_type))
            assert parts[1] == 1, "not of float32"
            for _, dimension in fields(parts[2]):
                (kind, size), = fields(dimension)
                shape.append(size if kind == 1 else size.decode())
    return name, shape


class Model:
    """nodes, constants, inputs, outputs, properties and the operator set of a file."""

    def __init__(self, path):
        self.nodes, self.constants, self.inputs, self.outputs, self.properties = [], {}, {}, {}, {}
        self.operator_set = None
        with open(path, "rb") as file:
            data = file.read()
        for number, value in fields(data):
            if number == 7:
                self.read_graph(value)
            elif number == 8:
                self.operator_set = dict(fields(value))[2]
            elif number == 14:
                entry = dict(fields(value))
                self.properties[entry[1].decode()] = entry[2].decode()

    def read_graph(self, data):
        for number, value in fields(data):
            if number == 1:
                self.nodes.append(Node(value))
            elif number == 5:
                name, array = tensor(value)
                assert name not in self.constants
                self.constants[name] = array
            elif number == 11:
                self.inputs.update([value_info(value)])
            elif number == 12:
                self.outputs.update([value_info(value)])

    def run(self, controls):
        """controls [n, C] -> {output: array}."""
        values = {**self.constants, "controls": np.asarray(controls, np.float32)}
        with np.errstate(all="ignore"):
            for node in self.nodes:
                assert node.output not in values, node.output
                values[node.output] = OPERATORS[node.type]([values[name] for name in node.inputs], node.attributes)
        return {name: values[name] for name in self.outputs}


def slice_(x, _):
    index = [slice(None)] * x[0].ndim
    for begin, end, axis in zip(*x[1:]):
        index[axis] = slice(begin, end)
    return x[0][tuple(index)]


OPERATORS = {
    "Abs": lambda x, a: np.abs(x[0]),
    "Add": lambda x, a: x[0] + x[1],
    "Clip": lambda x, a: np.minimum(np.maximum(x[0], x[1]), x[2]),
    "Concat": lambda x, a: np.concatenate(x, axis=a["axis"]),
    "CumSum": lambda x, a: np.cumsum(x[0], axis=int(x[1])),
    "Div": lambda x, a: x[0] / x[1],
    "Floor": lambda x, a: np.floor(x[0]),
    "Gather": lambda x, a: np.take(x[0], x[1], axis=a.get("axis", 0)),
    "Identity": lambda x, a: x[0],
    "MatMul": lambda x, a: x[0] @ x[1],
    "Max": lambda x, a: np.maximum(x[0], x[1]),
    "Min": lambda x, a: np.minimum(x[0], x[1]),
    "Mul": lambda x, a: x[0] * x[1],
    "Neg": lambda x, a: -x[0],
    "ReduceMax": lambda x, a: x[0].max(axis=tuple(a["axes"]), keepdims=True),
    "Relu": lambda x, a: np.maximum(x[0], np.float32(0)),
    "Reshape": lambda x, a: x[0].reshape([x[0].shape[i] if n == 0 else n for i, n in enumerate(x[1])]),
    "Round": lambda x, a: np.rint(x[0]),
    "Slice": slice_,
    "Sub": lambda x, a: x[0] - x[1],
    "Transpose": lambda x, a: np.transpose(x[0], a["perm"]),
    "Unsqueeze": lambda x, a: np.expand_dims(x[0], tuple(int(i) for i in x[1])),
}


def read_mdd(path):
    """frames x points x 3."""
    with open(path, "rb") as file:
        frames, points = struct.unpack(">ii", file.read(8))
        file.seek(4 * frames, 1)
        return np.fromfile(file, ">f4").reshape(frames, points, 3).astype(np.float32)
