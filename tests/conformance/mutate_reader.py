#!/usr/bin/env python3
"""mutate_reader.py FOLDER...: whether the golden archives pin the rules of FORMAT.md, DRACO.md and EVALUATION.md.

Breaks the independent reader in one rule after the other. A broken reader must fail on an accepted archive of a FOLDER, or
accept a rejected one. Prints the rules that no archive pins; fails if there are any.
"""
import concurrent.futures
import contextlib
import importlib
import io
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

JUDGE = "--judge"  # READER FOLDER...: exits with 0 if the reader agrees

# File, text that occurs once, and what replaces it: a reader that gets one rule wrong.
MUTATIONS = [
    ("fbk_evaluate", "controls = np.clip(controls, face.low, face.high)", "pass"),
    ("fbk_evaluate", "(q + base // 2) % base - base // 2", "q % base"),
    ("fbk_evaluate", "if largest <= 127 * base", "if largest <= 128 * base"),
    ("fbk_evaluate", "return min(LIMIT, (2**31 - 1) // largest)", "return min(LIMIT, 2**31 // largest)"),
    ("fbk_evaluate", "return min(LIMIT, (2**31 - 1) // largest)", "return min(32767, (2**31 - 1) // largest)"),
    ("fbk_evaluate", "magnitudes[~(magnitudes <= F(2.0**100))] = F(2.0**100)", "pass"),
    ("fbk_evaluate", "if m < F(2.0**-100):", "if m == 0:"),
    ("fbk_evaluate", "q = np.rint(x * (F(limit) / m))", "q = np.floor(x * (F(limit) / m) + F(0.5))"),
    ("fbk_evaluate", "q = np.rint(x * (F(limit) / m))", "q = np.rint(x / (m / F(limit)))"),
    ("fbk_evaluate", "y = np.clip(y, -TANH_MOST, TANH_MOST)", "y = y + F(0)"),
    ("fbk_evaluate", "return y * horner(TANH_P, s) / horner(TANH_Q, s)", "return np.tanh(y)"),
    ("fbk_evaluate", "np.where(y > 0, y, F(0))", "np.abs(y)"),
    ("fbk_evaluate", "F(0.5) + F(0.5) * tanh(F(0.5) * y)", "F(0.5) + F(0.5) * tanh(y)"),
    ("fbk_evaluate", "layer.limit = limit_of(layer.digits)", "layer.limit = limit_of(layer.weights)"),
    ("fbk_evaluate", "block.limit = limit_of(block.matrix)", "block.limit = LIMIT"),
    ("fbk_evaluate", "block.coordinates = 3 * order[rows // 3] + rows % 3", "block.coordinates = rows"),
    ("fbk_evaluate", "F(0) if a == 0 or b == 0 else a * b", "a * b"),
    ("fbk_evaluate", "values.append(a if a < b else b)", "values.append(a if a > b else b)"),
    ("fbk_evaluate", "(control - rest) * feature.scale", "control * feature.scale - rest * feature.scale"),
    ("fbk_evaluate", "t = u - feature.threshold", "t = u"),
    ("fbk_evaluate", "falling = F(1) + (F(1) - t) * feature.fall", "falling = F(1) - t * feature.fall"),
    ("fbk_evaluate",
     "*high, low = (layer.digits @ q).astype(F)\n        sums = F(256) * high[0] + low if high else low",
     "*high, low = layer.digits @ q\n        sums = (256 * high[0] + low if high else low).astype(F)"),
    ("fbk_evaluate", "layer.scales * step * sums + layer.bias", "layer.scales * (step * sums) + layer.bias"),
    ("fbk_evaluate", "x = y + x if layer.skip else y", "x = y"),
    ("fbk_evaluate", "region.slope * (added(sizes) - max(F(0), *sizes))", "region.slope * added(sizes)"),
    ("fbk_evaluate", "return gate if gate < 1 else F(1)", "return gate"),
    ("fbk_evaluate", "(run_layers(region, x) - region.rest) * gate", "run_layers(region, x) * gate"),
    ("fbk_evaluate", "coefficient * (segment.scale * F(segment.base))", "coefficient * segment.scale * F(256)"),
    ("fbk_evaluate", "rest[at] + step * (block.matrix @ q).astype(F)",
     "rest[at] + (step * (block.matrix @ q)).astype(F)"),
    ("fbk_evaluate", "(value if value < high else high) if value > low else low", "value"),
    ("fbk_evaluate", "near = F(1) - added(differences * differences) * pose.falloff",
     "near = F(1) - added(differences * differences)"),
    ("fbk_evaluate", "near * near if near > 0 else F(0)", "near if near > 0 else F(0)"),
    ("fbk_evaluate", "if total > 1 else weights", "if total > 2 else weights"),
    ("fbk_evaluate", "effects = reached * np.sqrt(reached)", "effects = reached"),
    ("fbk_evaluate", "(places < errors.lowest) | (places > errors.highest)", "places > errors.highest"),
    ("fbk_evaluate", "reached >= 0.25", "reached > 0.5"),
    ("fbk_evaluate", "for step in range(25):", "for step in range(4):"),
    ("fbk_evaluate", "frame[:, 3] -= p_centre", "pass"),
    ("fbk_evaluate", "for level in reversed(face.levels[:number]):", "for level in face.levels[:number]:"),
    ("fbk_sections", "(8 + w % 8) * 2.0 ** ((w >> 3) - 35)", "(w % 8) * 2.0 ** ((w >> 3) - 35)"),
    ("fbk_basis", "rans.symbol(segment.table, part, i)", "rans.symbol(25, part, i)"),
    ("fbk_basis", "part, column_values = 4 * before // total,", "part, column_values = 0,"),
    ("fbk_basis", "index = rans.symbol(0, 0, coded_pairs)", "index = rans.symbol(0, 0, 0)"),
    ("fbk_basis", "rans.symbol(segment.table, part, i)", "rans.symbol(segment.table, part, i + 1)"),
    ("fbk_basis", "rans, part, large, unit.axes", "rans, part, len(residuals), unit.axes"),
    ("fbk_basis", "2 if axis == axes[-1] else 0", "2 if axis == 2 else 0"),
    ("fbk_basis", "3 * (min(b, 9) - 2)", "3 * (min(b, 10) - 2)"),
    ("fbk_basis", "reached = reached or abs(residuals[axis]) >= 2 ** (b - 1)",
     "reached = abs(residuals[axis]) >= 2 ** (b - 1)"),
    ("fbk_evaluate", "if step < 24:", "if step < 23:"),
    ("fbk_sections", "== (len(face.uvs) == 0 or len(polygons) == 0)", "== (len(face.uvs) == 0) or len(polygons) == 0"),
    ("fbk_sections", "rest[vertices].tobytes() == positions.tobytes()", "(rest[vertices] == positions).all()"),
    ("fbk_sections", "size <= 66", "True"),
    ("fbk_sections", "len(from_first) <= 64 and", ""),
    ("fbk_sections", "len(opposite) == len(from_first)", "True"),
    ("fbk_bytes", "return z >> 1 ^ -(z & 1)", "return z >> 1"),
    ("fbk_bytes", "h += len(data)", "pass"),
    ("fbk_bytes", "self.check(self.at == len(self.data),", "self.check(True,"),
    ("fbk_bytes", "self.check(b\"\\0\" not in text,", "self.check(True,"),
    ("fbk_bytes", "self.c.check(all(next(words, None) is None for words in self.words),", "self.c.check(True,"),
    ("fbk_draco", "stack += [left, right]", "stack += [right, left]"),
    ("fbk_draco", "if max(corners) < number:", "if True:"),
    ("fbk_draco", "value = min(max(prediction, least), most) + unzigzag(residual)",
     "value = prediction + unzigzag(residual)"),
    ("fbk_draco", "if start_faces.bit():", "if False:"),
    ("fbk_draco", "self.merged[gone] = kept", "pass"),
    ("fbk_joints", "joint.numbers < 4096", "True"),
    ("fbk_joints", "len(rotations) <= 15", "True"),
    ("fbk_joints", "len(rotations) <= 15", "len(rotations) < 15"),
    ("fbk_joints", "all(bits > 0 for bits in rotations)", "True"),
    ("fbk_joints", "all(bits < 8 for bits in rotations)", "True"),
    ("fbk_joints", "depths[-1] <= 256", "True"),
    ("fbk_joints", "depths[-1] <= 256", "depths[-1] < 256"),
    ("fbk_joints", "joint.scales[number] > 0", "True"),
    ("fbk_joints", "face.points += (numbers + 2) // 3", "face.points += numbers // 3"),
    ("fbk_joints", "max(counts) <= most", "True"),
    ("fbk_joints", "all(j < len(face.driven) for j in joints)", "True"),
    ("fbk_joints", "all(w > 0 for w in weights)", "True"),
    ("fbk_joints", "sum(weights[at : at + count]) <= 32768", "True"),
    ("fbk_joints", "F(w) / F(32768)", "F(w) / F(32767)"),
    ("fbk_joints", "for coefficient in coefficients[-2::-1]:", "for coefficient in coefficients[-2:0:-1]:"),
    ("fbk_joints", "square if square < F(40) else F(40)", "square"),
    ("fbk_joints", "(a[:, 0:1] * b[0] + a[:, 1:2] * b[1]) + a[:, 2:3] * b[2]",
     "a[:, 0:1] * b[0] + (a[:, 1:2] * b[1] + a[:, 2:3] * b[2])"),
    ("fbk_joints", "range(12 + 3 * i, 15 + 3 * i) for i in range(len(rotations))",
     "range(9 + 3 * i, 12 + 3 * i) for i in range(len(rotations), 0, -1)"),
    ("fbk_joints", "for outer in joint.outer:", "for outer in reversed(joint.outer):"),
    ("fbk_joints", "if any(numbers.get(n, F(0)) != 0 for n in outer):", "if True:"),
    ("fbk_joints", "(further + linear) + times(further, linear)", "(further + linear) + times(linear, further)"),
    ("fbk_joints", "(further + linear) + times(further, linear)", "further + (linear + times(further, linear))"),
    ("fbk_joints", "moved - times(linear, along_axes(PIVOT))", "moved + times(linear, along_axes(PIVOT))"),
    ("fbk_joints", "moved = moved - times(linear, along_axes(PIVOT))", "origin = origin + along_axes(PIVOT)"),
    ("fbk_joints", "linear = (linear + lengths) + times(linear, lengths)", "linear = linear + lengths"),
    ("fbk_joints", "linear = (linear + lengths) + times(linear, lengths)",
     "linear = (linear + lengths) + times(lengths, linear)"),
    ("fbk_joints", "moved - times(linear, origin)", "moved"),
    ("fbk_joints", "found.append(above)", "found.append(None)"),
    ("fbk_joints", "found.append(own if above is None else (above + own) + times(above, own))",
     "found.append(own if above is None else (above + own) + times(own, above))"),
    ("fbk_joints", "found.append(own if above is None else (above + own) + times(above, own))",
     "found.append(own if above is None else above + (own + times(above, own)))"),
    ("fbk_joints", "(blend[:, 0] * x + blend[:, 1] * y) + (blend[:, 2] * z + blend[:, 3])",
     "((blend[:, 0] * x + blend[:, 1] * y) + blend[:, 2] * z) + blend[:, 3]"),
    ("fbk_joints", "frame += follow", "frame = frame + times(change, joint.rest)"),
    ("fbk_evaluate", "return fbk_joints.skinned(face, points.ravel())[0]", "return points.ravel()[: 3 * face.vertices]"),
]


def accepts(reader, file):
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        try:
            return reader.main([str(file)]) == 0
        except Exception:
            return False


def agrees(folders):
    """Whether the reader that is imported takes the golden archives as FOLDER/accepted and FOLDER/rejected say."""
    reader = importlib.import_module("fbk_read")
    files = [(file, kind) for kind in ("accepted", "rejected") for folder in folders
             for file in sorted((folder / kind).glob("*.fbk"))]
    return all(accepts(reader, file) == (kind == "accepted") for file, kind in files)


def is_caught(reader, folders):
    """Whether the reader in a folder disagrees with the golden archives, or does not end: in a process of its own."""
    command = [sys.executable, "-B", __file__, JUDGE, reader, *folders]
    try:
        return subprocess.run(command, capture_output=True, timeout=600).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def try_mutation(mutation, folders):
    name, text, replacement = mutation
    here = pathlib.Path(__file__).parent
    with tempfile.TemporaryDirectory() as temporary:
        for file in here.glob("fbk_*.py"):
            shutil.copy(file, temporary)
        broken = pathlib.Path(temporary) / f"{name}.py"
        source = broken.read_text()
        if source.count(text) != 1:
            sys.exit(f"{name}: {text!r} occurs {source.count(text)} times")
        broken.write_text(source.replace(text, replacement))
        return is_caught(temporary, folders)


def main(*arguments):
    if arguments and arguments[0] == JUDGE:
        sys.path.insert(0, arguments[1])
        return 0 if agrees([pathlib.Path(folder) for folder in arguments[2:]]) else 1
    folders = [pathlib.Path(folder) for folder in arguments]
    if is_caught(pathlib.Path(__file__).parent, folders):
        sys.exit("the reader as it is disagrees with the golden archives")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        caught = list(pool.map(lambda mutation: try_mutation(mutation, folders), MUTATIONS))
    for (name, text, replacement), found in zip(MUTATIONS, caught):
        if not found:
            print(f"{name}: no archive pins {text!r}, which may be {replacement!r}")
    print(f"{sum(caught)} of {len(caught)} broken readers are caught")
    return 0 if all(caught) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
