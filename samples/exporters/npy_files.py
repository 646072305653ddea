"""NumPy's .npy files without NumPy: little-endian float32 and int32, C order, for programs whose Python has nothing else.

An array is its shape, a tuple, and its values, an array.array in C order. Python 3.7 or newer.
"""
import array
import ast
import os
import struct
import sys

MAGIC = b"\x93NUMPY"
TYPES = {"<f4": "f", "<i4": "i"}  # by what NumPy calls them: by what the module array does


class NpyError(Exception):
    """A file that is no such array; the message names it."""


def values_in(shape):
    count = 1
    for size in shape:
        count *= size
    return count


def in_file_order(values):
    """The same values as their bytes are in files."""
    if sys.byteorder == "little":
        return values
    swapped = array.array(values.typecode, values)
    swapped.byteswap()
    return swapped


def read_header(file, path):
    """The shape, the type code and the offset of the values. Checks that the file has the size which that needs."""
    start = file.read(10)
    if len(start) < 10 or start[:6] != MAGIC or start[6] not in (1, 2):
        raise NpyError("%s: is no NumPy array of version 1 or 2" % path)
    width = 2 if start[6] == 1 else 4
    length = struct.unpack("<H" if width == 2 else "<I", start[8:10] + file.read(width - 2))[0]
    if length > 1 << 16:
        raise NpyError("%s: its header of %d bytes is too long" % (path, length))
    try:
        fields = ast.literal_eval(file.read(length).decode("latin-1").strip())
        shape, kind, fortran = tuple(fields["shape"]), fields["descr"], fields["fortran_order"]
    except (ValueError, SyntaxError, KeyError, TypeError):
        raise NpyError("%s: its header cannot be read" % path) from None
    if kind not in TYPES or fortran or any(not isinstance(size, int) or size < 0 for size in shape):
        raise NpyError("%s: is not of little-endian float32 or int32 in C order" % path)
    data = 8 + width + length
    need, there = data + 4 * values_in(shape), os.path.getsize(path)
    if there != need:
        raise NpyError("%s: has %d bytes where its shape %s needs %d" % (path, there, shape, need))
    return shape, TYPES[kind], data


def read_shape(path):
    """The shape of an array, from its header alone."""
    with open(path, "rb") as file:
        return read_header(file, path)[0]


def read_npy(path):
    """Shape and values of an array."""
    with open(path, "rb") as file:
        shape, code, data = read_header(file, path)
        file.seek(data)
        values = array.array(code)
        values.frombytes(file.read(4 * values_in(shape)))
    return shape, in_file_order(values)


def write_npy(path, shape, values):
    """Writes values, which may be any sequence of numbers or an array.array of floats or ints: the file is complete or
    not there."""
    if not isinstance(values, array.array):
        values = array.array("f", values)
    if values.typecode not in ("f", "i") or len(values) != values_in(shape):
        raise NpyError("%s: %d values of type %r do not fill the shape %s" % (path, len(values), values.typecode, shape))
    kind = next(name for name, code in TYPES.items() if code == values.typecode)
    header = "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }" % (kind, "".join("%d, " % size for size in shape))
    header += " " * (63 - (10 + len(header)) % 64) + "\n"
    temporary = path + ".part"
    with open(temporary, "wb") as file:
        file.write(MAGIC + b"\x01\x00" + struct.pack("<H", len(header)) + header.encode("ascii"))
        in_file_order(values).tofile(file)
        file.flush()
        os.fsync(file.fileno())
    os.replace(temporary, path)
