"""FORMAT.md, "network", "weights", "basis" and "basis-values". For fbk_read.py."""
import collections
import heapq
import itertools
from types import SimpleNamespace

import numpy as np

from fbk_bytes import F, RansDecoder

IDENTITY, _, HAT, PRODUCT, MINIMUM = range(5)  # kinds of features
LARGEST = {8: 127, 16: 32512}  # of quantised values, by their bits


def read_feature(c, face):
    kind, last = c.u8(), len(face.features) - 1
    c.check(kind <= MINIMUM, f"unsupported feature kind {kind}")
    if kind in (PRODUCT, MINIMUM):
        return SimpleNamespace(kind=kind, first=c.u32(most=last), second=c.u32(most=last))
    control, numbers = c.u32(most=len(face.controls) - 1), [*c.floats(kind + 1), F(0), F(0)]
    c.check(min(numbers[1:]) >= 0, "a threshold or a fall")
    return SimpleNamespace(kind=kind, control=control, scale=numbers[0], threshold=numbers[1], fall=numbers[2])


def read_layer(c, width):
    inputs, outputs, activation, flags = c.u32(), c.u32(1), c.u8(), c.u8()
    c.check(activation <= 3 and flags <= 3, "unsupported layer")
    c.check(inputs == width < 2**24 and (inputs == outputs or not flags & 1), "widths of a layer")
    return SimpleNamespace(shape=(outputs, inputs), activation=activation, skip=flags & 1, bits=16 if flags & 2 else 8,
                           bias=c.planes(outputs, "f4"), scales=c.planes(outputs, "f4"))


def read_network(c, face):
    def feature_indices():
        indices = c.array("u4", c.u32()).tolist()
        c.check(all(index < len(face.features) for index in indices), "no such feature")
        return indices

    face.features = []
    for _ in range(c.u32()):
        face.features.append(read_feature(c, face))
    face.direct, face.regions = feature_indices(), []
    for _ in range(c.u32()):
        c.string()
        region = SimpleNamespace(features=feature_indices(), gate=feature_indices(), slope=c.f32(), layers=[])
        c.check(region.slope > 0, "a gate's slope")
        gate = [face.features[f] for f in region.gate]
        c.check(all(feature.kind == IDENTITY for feature in gate), "a gate feature is no identity")
        c.check(all(a.control < b.control for a, b in zip(gate, gate[1:])), "gate features are not ascending")
        width = len(region.features)
        for _ in range(c.u32(1)):
            region.layers.append(read_layer(c, width))
            width = region.layers[-1].shape[0]
        face.regions.append(region)
    face.coefficients = len(face.direct) + sum(region.layers[-1].shape[0] for region in face.regions)


def read_weights(c, face):
    rans = RansDecoder(c, 9, 9, parts=1)
    for region in face.regions:
        for number, layer in enumerate(region.layers):
            t = 2 if layer is region.layers[-1] else min(number, 1)
            weights = []
            for i in range(layer.shape[0] * layer.shape[1]):
                if layer.bits == 8:
                    weights.append(rans.symbol(t, 0, i) - 127)
                else:
                    high = rans.symbol(t + 3, 0, i) - 127
                    weights.append(256 * high + rans.symbol(t + 6, 0, i) - 128)
            c.check(all(abs(weight) <= LARGEST[layer.bits] for weight in weights), "out of range")
            layer.weights = np.array(weights, np.int64).reshape(layer.shape)
    rans.end()


def read_basis(c, face):
    columns, ordered = c.u32(), c.u32(most=1)
    c.check(columns == face.coefficients, "columns")
    behind = list(range(face.vertices, face.points))
    face.order = c.deltas(face.points).tolist() if ordered else list(range(face.points))
    c.check(sorted(face.order) == list(range(face.points)), "the order does not list every vertex once")
    c.check(face.order[face.vertices :] == behind, "the order lists vertices behind those that carry numbers")
    rows = c.planes(c.u32()).tolist()
    c.check(all(rows) and sum(rows) == 3 * face.points, "rows")
    mesh_of_row = np.repeat(face.mesh_of[face.order], 3)
    face.row_blocks, end = [], 0
    for count in rows:
        block = SimpleNamespace(first=end, end=end + count, rows=count, segments=[])
        c.check(len(set(mesh_of_row[block.first : block.end])) == 1, "a row block of two meshes, or of numbers too")
        face.row_blocks.append(block)
        end = block.end
    read_segments(c, face, columns)
    for block in face.row_blocks:
        c.check(sum(segment.bits // 8 for segment in block.segments) < 2**24, "too many summands")


def read_segments(c, face, columns):
    counts = c.planes(columns).tolist()
    deltas, flags = c.planes(sum(counts)).tolist(), c.take(sum(counts))
    scales = iter(c.planes(c.u32(), "f4"))
    entries, face.segments, scale = zip(deltas, flags), [], None
    for column, count in enumerate(counts):
        number = 0
        for i, (delta, flag) in enumerate(itertools.islice(entries, count)):
            number += delta
            c.check((i == 0 or delta > 0) and number < len(face.row_blocks), "row blocks of a column")
            scale = next(scales, None) if flag & 2 else scale
            c.check(scale is not None, "a segment has no scale")
            segment = SimpleNamespace(column=column, block=face.row_blocks[number], scale=scale,
                                      bits=16 if flag & 1 else 8, table=25 + (flag >> 2))
            c.check(segment.bits == 8 or np.isfinite(scale * F(256)), "a scale that is not finite")
            segment.block.segments.append(segment)
            face.segments.append(segment)
    c.check(next(scales, None) is None, "too many scales")


def find_neighbours(face):
    neighbours = [set() for _ in range(face.points)]
    for polygon in face.polygons:
        for v, w in zip(polygon, polygon[1:] + polygon[:1]):
            if v != w and len(neighbours[v]) < 16 and len(neighbours[w]) < 16:
                neighbours[v].add(w)
                neighbours[w].add(v)
    return neighbours


def candidates_of(v, neighbours, time):
    """The candidate predictors of a vertex as triples (left, right, across) of vertices or None."""
    def last(vertices):
        return max((w for w in vertices - neighbours[v] - {v} if time[w]), key=lambda w: time[w], default=None)

    coded = sorted((k for k in neighbours[v] if time[k]), key=lambda k: -time[k])
    candidates = [(i, j, last(neighbours[i] & neighbours[j])) for i, j in itertools.combinations(coded[:4], 2)]
    candidates += [(k, None, None) for k in coded[:2]]
    for k in coded[:4]:
        others = [neighbours[u] for u in neighbours[v] if u != k]
        candidates.append((k, k, last(neighbours[k].difference(*others))))
    candidates = [candidate for candidate in candidates if candidate.count(None) != 1]  # else across is missing
    return candidates or [(None, None, None)]


def read_coding_units(face, rans):
    """The coding units of every row block in coding order, with their two predictors."""
    neighbours = find_neighbours(face)
    time = [0] * face.points  # when the last unit of a vertex was coded; 0: not yet
    now = coded_pairs = 0
    for block in face.row_blocks:
        waiting, block.units = {}, []
        for row in range(block.first, block.end):
            unit = SimpleNamespace(v=face.order[row // 3], row=row - block.first, axes=[])
            waiting.setdefault(unit.v, unit).axes.append(row % 3)

        def priority(v):
            return -sum(time[w] > 0 for w in neighbours[v]), waiting[v].row, v

        heap = [priority(v) for v in waiting]
        heapq.heapify(heap)
        while waiting:
            *_, v = heapq.heappop(heap)
            if v not in waiting:
                continue  # coded since, at a higher priority
            candidates, index = candidates_of(v, neighbours, time), 0
            pairs = [(first, second) for j, second in enumerate(candidates) for first in candidates[: j + 1]]
            if len(pairs) > 1:
                index = rans.symbol(0, 0, coded_pairs)
                coded_pairs += 1
            rans.c.check(index < len(pairs), "no such predictors")
            unit = waiting.pop(v)
            unit.predictors = pairs[index]
            block.units.append(unit)
            now += 1
            time[v] = now
            for w in neighbours[v] & waiting.keys():
                heapq.heappush(heap, priority(w))


def read_basis_values(c, face):
    rans = RansDecoder(c, 25, 89, parts=4)
    read_coding_units(face, rans)
    total, before = sum(segment.block.rows for segment in face.segments), 0
    for _, segments in itertools.groupby(face.segments, lambda segment: segment.column):
        part, column_values = 4 * before // total, collections.defaultdict(lambda: [0, 0, 0])
        for segment in segments:
            c.check(segment.table < len(rans.tables), "no such table")
            segment.values = np.zeros(segment.block.rows, np.int64)
            residuals_of_units = read_residuals(rans, part, segment)
            for unit, residuals in zip(segment.block.units, residuals_of_units):
                for row, axis in enumerate(unit.axes, unit.row):
                    a, b = (predicted(predictor, column_values, axis) for predictor in unit.predictors)
                    value = (a + b + 1 >> 1) + residuals[axis]
                    c.check(abs(value) <= LARGEST[segment.bits], "out of range")
                    segment.values[row] = column_values[unit.v][axis] = value
            before += segment.block.rows
    rans.end()


def predicted(predictor, values, axis):
    left, right, across = (values[v][axis] for v in predictor)
    return left + right - across


def read_residuals(rans, part, segment):
    """The residuals of a segment's units by axis."""
    units = segment.block.units
    symbols = [rans.symbol(segment.table, part, i) for i in range(len(units))]
    residuals, large = [], 0
    for symbol, unit in zip(symbols, units):
        if symbol < 27:
            residuals.append([(0, 1, -1)[symbol // 3**axis % 3] for axis in range(3)])
            rans.c.check(all(residuals[-1][axis] == 0 or axis in unit.axes for axis in range(3)), "no such axis")
        else:
            residuals.append(read_large_residuals(rans, part, large, unit.axes, symbol - 25))
            large += 1
    return residuals


def read_large_residuals(rans, part, index, axes, b):
    """The residuals of a unit of class b by axis."""
    rans.c.check(b <= 17, "a class is too large")
    residuals, reached, f = [0, 0, 0], False, max(b - 6, 0)
    for axis in axes:
        table = 1 + 3 * (min(b, 9) - 2) + (1 if reached else 2 if axis == axes[-1] else 0)
        code = rans.symbol(table, part, index) << f
        if f > 0:
            code += rans.bits(f, part, index)
        residuals[axis] = code - (2**b - 1)
        reached = reached or abs(residuals[axis]) >= 2 ** (b - 1)
    return residuals
