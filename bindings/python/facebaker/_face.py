import collections
import collections.abc
import ctypes
import json
import os
import threading
import weakref

import numpy

from ._character import Control
from ._library import check, library
from ._structs import BatchDesc, ControlStruct, RowBlockStruct

ExpectedError = collections.namedtuple("ExpectedError", "face regions outside")
ExpectedError.__doc__ = """What to expect of a pose: the root mean square distance of the face's vertices from where the
rig has them, in units; the same of each of error_regions; and how many controls are outside of what was trained."""


def load(source):
    """Loads a face from a path, or from the bytes of an archive."""
    handle = ctypes.c_void_p()
    if isinstance(source, (bytes, bytearray, memoryview)):
        data = bytes(source)
        check(library.fb_load_memory(data, len(data), None, ctypes.byref(handle)))
    else:
        check(library.fb_load(os.fsencode(source), None, ctypes.byref(handle)))
    return Face(handle)


class Face:
    """A loaded face. Its arrays are read-only views of the model. Threads may share a face; its evaluations are serialised,
    so use evaluate_batch for speed."""

    def __init__(self, handle):
        """Called by load(). Takes ownership of the reference in handle."""
        self._handle = handle
        self._closer = weakref.finalize(self, library.fb_release, handle)
        self._scratches = {}
        self._lock = threading.Lock()
        self._clamped = 0
        self.vertex_count = library.fb_vertex_count(handle)
        self.control_count = library.fb_control_count(handle)
        self.coefficient_count = library.fb_coefficient_count(handle)
        self.name = library.fb_name(handle).decode()
        self.units = library.fb_units(handle).decode()
        self.up_axis = library.fb_up_axis(handle).decode()
        self.diagonal = library.fb_diagonal(handle)
        self.runtime_bytes = library.fb_runtime_bytes(handle)
        self.instruction_set = library.fb_instruction_set(handle).decode()
        self.regions = tuple(
            library.fb_region_name(handle, index).decode() for index in range(library.fb_region_count(handle))
        )
        self.error_regions = tuple(
            library.fb_error_region_name(handle, i).decode() for i in range(library.fb_error_region_count(handle))
        )
        self.level_count = library.fb_level_count(handle)  # levels of detail, with level 0
        self.controls = tuple(self._control(index) for index in range(self.control_count))

    def _control(self, index):
        struct = ControlStruct()
        library.fb_control_fill(struct, ctypes.sizeof(struct))
        check(library.fb_control_at(self._handle, index, struct))
        return Control(struct.name.decode(), struct.group.decode(), struct.minimum, struct.maximum, struct.rest)

    def _view(self, pointer, count, shape=None):
        """A read-only array over memory of the model, which it keeps alive."""
        if count == 0:
            return numpy.empty(0, numpy.uint32)
        memory = ctypes.cast(pointer, ctypes.POINTER(pointer._type_ * count)).contents
        memory._face = self
        array = numpy.ctypeslib.as_array(memory)
        array.flags.writeable = False
        return array.reshape(shape) if shape else array

    @property
    def provenance(self):
        """How the archive was made, as a dictionary; empty if it is not recorded."""
        return json.loads(library.fb_provenance(self._handle) or b"{}")

    @property
    def names(self):
        return [control.name for control in self.controls]

    @property
    def ranges(self):
        """(controls, 2): minimum and maximum of every control."""
        return numpy.array([(c.minimum, c.maximum) for c in self.controls], numpy.float32)

    @property
    def rest_controls(self):
        return self._view(library.fb_rest_controls(self._handle), self.control_count)

    @property
    def rest_positions(self):
        """(vertices, 3)."""
        return self._view(library.fb_rest_positions(self._handle), 3 * self.vertex_count, (self.vertex_count, 3))

    @property
    def polygon_sizes(self):
        """Corners of every polygon."""
        return self._view(library.fb_polygon_sizes(self._handle), library.fb_polygon_count(self._handle))

    @property
    def polygon_corners(self):
        """Vertex indices, polygon after polygon."""
        return self._view(library.fb_polygon_corners(self._handle), library.fb_polygon_corner_count(self._handle))

    @property
    def uvs(self):
        """(texture coordinates, 2): u and v, v growing upwards; empty if the source had none."""
        count = library.fb_uv_count(self._handle)
        return self._view(library.fb_uvs(self._handle), 2 * count, (count, 2))

    @property
    def uv_corners(self):
        """The index into uvs of every polygon corner."""
        count = library.fb_polygon_corner_count(self._handle) if library.fb_uv_count(self._handle) else 0
        return self._view(library.fb_uv_corners(self._handle), count)

    @property
    def tangent_signs(self):
        """(vertices,): -1 where the texture is mirrored, else 1; empty without texture coordinates."""
        count = self.vertex_count if library.fb_uv_count(self._handle) else 0
        return self._view(library.fb_tangent_signs(self._handle), count)

    @property
    def clamped_count(self):
        """The number of control values that the last evaluation clamped to their ranges."""
        return self._clamped

    def find(self, name):
        """The index of a control; the error names the closest one there is."""
        index = ctypes.c_uint32()
        check(library.fb_find_control(self._handle, name.encode(), ctypes.byref(index)))
        return index.value

    def pose(self, values):
        """(controls,), float32: the rest pose with the controls in `values`, a dictionary from names to values."""
        controls = self.rest_controls.copy()
        for name, value in values.items():
            controls[self.find(name)] = value
        return controls

    def evaluate(self, controls):
        """(controls,), or a dictionary as for pose() -> (vertices, 3), float32."""
        if isinstance(controls, collections.abc.Mapping):
            controls = self.pose(controls)
        controls = self._floats(controls, 1)
        positions = numpy.empty((self.vertex_count, 3), numpy.float32)
        with self._lock:
            scratch = self._scratch(1)
            check(library.fb_evaluate(self._handle, scratch, _pointer(controls), _pointer(positions)))
            self._clamped = library.fb_clamped_count(scratch)
        return positions

    def evaluate_batch(
        self,
        controls,
        threads=0,
        out=None,
        *,
        normals=None,
        tangents=None,
        baked_order=False,
        regions=None,
        dtype=numpy.float32,
        lod=0.0,
        displacements=False,
    ):
        """(poses, controls) -> (poses, vertices, 3), with the same bits as evaluate.

        threads: 0 is all cores. dtype: float32 or float16. out, normals, tangents: contiguous arrays of the result's shape
        and dtype; unit normals and unit tangents are written to the latter two; tangents need texture coordinates.
        baked_order: vertices in the order of vertex_order. regions: the names of the regions whose networks run; the
        others keep their values at rest. lod: level of detail, 0 (the whole) to level_count - 1 or between two of them.
        displacements: from rest, in place of positions."""
        controls = self._floats(controls, 2)
        if threads < 0:
            raise ValueError(f"{threads} threads")
        dtype = numpy.dtype(dtype)
        if dtype not in (numpy.float32, numpy.float16):
            raise ValueError(f"dtype is {dtype}, neither float32 nor float16")
        shape = (len(controls), self.vertex_count, 3)
        if out is None:
            out = numpy.empty(shape, dtype)
        for name, array in (("out", out), ("normals", normals), ("tangents", tangents)):
            if array is not None and (
                array.shape != shape or array.dtype != dtype or not array.flags.c_contiguous or not array.flags.writeable
            ):
                raise ValueError(f"{name} must be a writable contiguous {dtype} array of shape {shape}")
        desc = BatchDesc()
        library.fb_batch_desc_fill(desc, ctypes.sizeof(desc))
        desc.threads = threads
        desc.poses = len(controls)
        desc.controls, desc.control_floats = _pointer(controls), controls.size
        desc.positions, desc.position_floats = out.ctypes.data, out.size
        desc.vertex_order, desc.format = int(baked_order), int(dtype == numpy.float16)
        desc.lod, desc.displacements = lod, int(displacements)
        if normals is not None:
            desc.normals, desc.normal_numbers = normals.ctypes.data, normals.size
        if tangents is not None:
            desc.tangents, desc.tangent_numbers = tangents.ctypes.data, tangents.size
        if regions is not None:
            indices = [self.regions.index(name) for name in regions]
            desc.regions, desc.region_count = (ctypes.c_uint32 * max(len(indices), 1))(*indices), len(indices)
        with self._lock:
            scratch = self._scratch(threads or os.cpu_count() or 1)
            check(library.fb_evaluate_batch(self._handle, scratch, desc))
            self._clamped = library.fb_clamped_count(scratch)
        return out

    def coefficients(self, controls):
        """(controls,), or a dictionary as for pose() -> (coefficients,), float32: the weights of basis()'s columns."""
        if isinstance(controls, collections.abc.Mapping):
            controls = self.pose(controls)
        controls = self._floats(controls, 1)
        coefficients = numpy.empty(self.coefficient_count, numpy.float32)
        with self._lock:
            scratch = self._scratch(1)
            check(library.fb_evaluate_coefficients(self._handle, scratch, _pointer(controls), _pointer(coefficients)))
            self._clamped = library.fb_clamped_count(scratch)
        return coefficients

    def expected_error(self, controls):
        """(controls,), or a dictionary as for pose() -> ExpectedError, for little of the time that evaluate() takes. (poses,
        controls) -> one of arrays with one row a pose. Fails if error_regions is empty."""
        if isinstance(controls, collections.abc.Mapping):
            controls = self.pose(controls)
        single = numpy.ndim(controls) == 1
        controls = self._floats([controls] if single else controls, 2)
        errors = numpy.empty((len(controls), 1 + len(self.error_regions)), numpy.float32)
        outside = numpy.empty(len(controls), numpy.uint32)
        with self._lock:
            scratch = self._scratch(1)
            for pose, row, count in zip(controls, errors, outside.ctypes.data + 4 * numpy.arange(len(controls))):
                to = ctypes.cast(int(count), ctypes.POINTER(ctypes.c_uint32))
                check(library.fb_expected_error(self._handle, scratch, _pointer(pose), _pointer(row), to))
        if single:
            return ExpectedError(float(errors[0, 0]), errors[0, 1:], int(outside[0]))
        return ExpectedError(errors[:, 0], errors[:, 1:], outside)

    @property
    def error_vertex_regions(self):
        """(vertices,): the index into error_regions of every vertex; empty if there are none."""
        count = self.vertex_count if self.error_regions else 0
        return self._view(library.fb_error_vertex_regions(self._handle), count)

    @property
    def vertex_order(self):
        """Baked order: the source index of every vertex."""
        order = library.fb_vertex_order(self._handle)
        if not order:
            return numpy.arange(self.vertex_count, dtype=numpy.uint32)
        return self._view(order, self.vertex_count)

    def basis(self):
        """Yields the row blocks of the basis: (rows, columns, values). rows: a slice of the 3 x vertices coordinates in baked
        order; columns: the coefficients that displace them; values: (columns, rows), the displacements for one unit."""
        for index in range(library.fb_row_block_count(self._handle)):
            block = RowBlockStruct()
            library.fb_row_block_fill(block, ctypes.sizeof(block))
            check(library.fb_row_block_at(self._handle, index, block))
            columns = numpy.empty(block.column_count, numpy.uint32)
            values = numpy.empty((block.column_count, block.row_count), numpy.float32)
            pointer = columns.ctypes.data_as(ctypes.POINTER(ctypes.c_uint32))
            check(library.fb_row_block_values(self._handle, index, pointer, _pointer(values)))
            yield slice(block.first_row, block.first_row + block.row_count), columns, values

    def _floats(self, controls, dimensions):
        controls = numpy.ascontiguousarray(controls, numpy.float32)
        if controls.ndim != dimensions or controls.shape[-1] != self.control_count:
            wanted = (self.control_count,) if dimensions == 1 else ("poses", self.control_count)
            raise ValueError(f"controls have shape {controls.shape}, not {wanted}")
        return controls

    def _scratch(self, workers):
        if workers not in self._scratches:
            handle = ctypes.c_void_p()
            check(library.fb_scratch_create(self._handle, workers, ctypes.byref(handle)))
            weakref.finalize(self, library.fb_scratch_destroy, handle)
            self._scratches[workers] = handle
        return self._scratches[workers]


def _pointer(array):
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_float))
