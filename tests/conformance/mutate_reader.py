#!/usr/bin/env python3
"""mutate_reader.py FOLDER: whether the golden archives pin the rules of FORMAT.md, DRACO.md and EVALUATION.md.

Breaks the independent reader in one rule after the other. A broken reader must fail on FOLDER/accepted, or accept
something of FOLDER/rejected. Prints the rules that no archive pins; fails if there are any.
"""
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

# File, text that occurs once, and what replaces it: a reader that gets one rule wrong.
MUTATIONS = [
    ("fbk_evaluate", "min(max(c, control[2]), control[3])", "c"),
    ("fbk_evaluate", "(q + base // 2) % base - base // 2", "q % base"),
    ("fbk_evaluate", "largest > 127 * base", "largest > 128 * base"),
    ("fbk_evaluate", "return min(LIMIT, (2**31 - 1) // largest)", "return min(LIMIT, 2**31 // largest)"),
    ("fbk_evaluate", "return min(LIMIT, (2**31 - 1) // largest)", "return min(32767, (2**31 - 1) // largest)"),
    ("fbk_evaluate", "magnitudes[~(magnitudes <= F(2.0**100))] = F(2.0**100)", "pass"),
    ("fbk_evaluate", "if m < F(2.0**-100):", "if m == 0:"),
    ("fbk_evaluate", "q = np.rint(x * (F(limit) / m))", "q = np.floor(x * (F(limit) / m) + F(0.5))"),
    ("fbk_evaluate", "q = np.rint(x * (F(limit) / m))", "q = np.rint(x / (m / F(limit)))"),
    ("fbk_evaluate", "y = np.where(y < -TANH_MOST, -TANH_MOST, np.where(y > TANH_MOST, TANH_MOST, y))", "y = y + F(0)"),
    ("fbk_evaluate", "return y * horner(TANH_P, s) / horner(TANH_Q, s)", "return np.tanh(y)"),
    ("fbk_evaluate", "return np.where(y > 0, y, F(0))", "return np.abs(y)"),
    ("fbk_evaluate", "F(0.5) + F(0.5) * tanh(F(0.5) * y)", "F(0.5) + F(0.5) * tanh(y)"),
    ("fbk_evaluate", "sums = np.stack(digits(layer[\"weights\"])) if layer[\"is_16_bit\"] else layer[\"weights\"]",
     "sums = layer[\"weights\"]"),
    ("fbk_evaluate", "block[\"limit\"] = limit_of(block[\"matrix\"])", "block[\"limit\"] = LIMIT"),
    ("fbk_evaluate", "block[\"coordinates\"] = 3 * order[rows // 3] + rows % 3", "block[\"coordinates\"] = rows"),
    ("fbk_evaluate", "F(0) if a == 0 or b == 0 else a * b", "a * b"),
    ("fbk_evaluate", "values.append(a if a < b else b)", "values.append(a if a > b else b)"),
    ("fbk_evaluate", "(controls[control] - rest[control]) * scale", "controls[control] * scale - rest[control] * scale"),
    ("fbk_evaluate", "t = u - threshold", "t = u"),
    ("fbk_evaluate", "falling = F(1) + (F(1) - t) * fall", "falling = F(1) - t * fall"),
    ("fbk_evaluate", "sums = F(256) * high.astype(F) + low.astype(F)", "sums = (256 * high + low).astype(F)"),
    ("fbk_evaluate", "layer[\"scales\"] * step * sums + layer[\"bias\"]", "layer[\"scales\"] * (step * sums) + layer[\"bias\"]"),
    ("fbk_evaluate", "x = y + x if layer[\"skip\"] else y", "x = y"),
    ("fbk_evaluate", "region[\"slope\"] * (total - largest)", "region[\"slope\"] * total"),
    ("fbk_evaluate", "gate = gate if gate < 1 else F(1)", "pass"),
    ("fbk_evaluate", "y = run_layers(region, x) - region[\"rest\"]", "y = run_layers(region, x)"),
    ("fbk_evaluate", "coefficient * (segment[\"scale\"] * F(segment[\"base\"]))", "coefficient * segment[\"scale\"] * F(256)"),
    ("fbk_evaluate", "rest[at] + step * (block[\"matrix\"] @ q).astype(F)", "rest[at] + (step * (block[\"matrix\"] @ q)).astype(F)"),
    ("fbk_evaluate", "(value if value < high else high) if value > low else low", "value"),
    ("fbk_exact", "near = F(1) - total * falloff", "near = F(1) - total"),
    ("fbk_exact", "return near * near if near > 0 else F(0)", "return near if near > 0 else F(0)"),
    ("fbk_exact", "if total > 1 else weights", "if total > 2 else weights"),
    ("fbk_errors", "effect = reached * np.sqrt(reached)", "effect = reached"),
    ("fbk_errors", "(8 + code % 8) * 2.0 ** ((code >> 3) - 35)", "(code % 8) * 2.0 ** ((code >> 3) - 35)"),
    ("fbk_errors", "if place < low[i] or place > high[i]:", "if place > high[i]:"),
    ("fbk_errors", "if reached >= 0.25:", "if reached > 0.5:"),
    ("fbk_sockets", "for step in range(25):", "for step in range(4):"),
    ("fbk_sockets", "if step < 24:", "if step < 23:"),
    ("fbk_levels", "== (not hasattr(face, \"uvs\") or corner_count == 0)", "== (not hasattr(face, \"uvs\")) or corner_count == 0"),
    ("fbk_sockets", "axis = [value - centre for value, centre in zip(axis, at_rest)]", "pass"),
    ("fbk_levels", "for _, level, _ in reversed(face.levels[:number]):", "for _, level, _ in face.levels[:number]:"),
    ("fbk_read", "axes, 25 + segment[\"table\"])", "axes, 25)"),
    ("fbk_read", "part = 4 * values_before[column] // before", "part = 0"),
    ("fbk_read", "pair = rans.symbol(0, 0, pairs % 4)", "pair = rans.symbol(0, 0, 0)"),
    ("fbk_read", "units[part] % 4, axes", "row % 4, axes"),
    ("fbk_read", "2 if axis == axes[-1] else 0", "2 if axis == 2 else 0"),
    ("fbk_read", "3 * (min(b, 9) - 2)", "3 * (min(b, 10) - 2)"),
    ("fbk_read", "reached = reached or abs(residuals[axis]) >= 1 << b - 1", "reached = abs(residuals[axis]) >= 1 << b - 1"),
    ("fbk_read", "rest[vertices].tobytes() == found.tobytes()", "(rest[vertices] == found).all()"),
    ("fbk_read", "size <= 66", "True"),
    ("fbk_read", "len(from_v) <= 64 and", ""),
    ("fbk_read", "len(opposite) == len(from_v)", "True"),
    ("fbk_bytes", "return z >> 1 ^ -(z & 1)", "return z >> 1"),
    ("fbk_bytes", "h = (h + size) & mask", "h = h"),
    ("fbk_bytes", "require(self.at == len(self.data),", "require(True,"),
    ("fbk_bytes", "require(b\"\\0\" not in text,", "require(True,"),
    ("fbk_bytes", "require(all(next(words, None) is None for words in self.words),", "require(True,"),
    ("fbk_draco", "stack += [left, right]", "stack += [right, left]"),
    ("fbk_draco", "if max(corners) < number:", "if True:"),
    ("fbk_draco", "value = min(max(prediction, least), most) + unzigzag(residual)", "value = prediction + unzigzag(residual)"),
    ("fbk_draco", "if start_faces.bit():", "if False:"),
    ("fbk_draco", "self.merged[gone] = kept", "pass"),
]


def is_caught(reader, folder):
    """Whether the reader in a folder disagrees with the golden archives."""
    def accepts(files):
        done = subprocess.run([sys.executable, "-B", str(reader), *map(str, files)], capture_output=True, timeout=120)
        return done.returncode == 0

    try:
        if not accepts(sorted((folder / "accepted").glob("*.fbk"))):
            return True
        return any(accepts([file]) for file in sorted((folder / "rejected").glob("*.fbk")))
    except subprocess.TimeoutExpired:
        return True


def try_mutation(mutation, folder):
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
        return is_caught(pathlib.Path(temporary) / "fbk_read.py", folder)


def main(folder):
    folder = pathlib.Path(folder)
    if is_caught(pathlib.Path(__file__).parent / "fbk_read.py", folder):
        sys.exit("the reader as it is disagrees with the golden archives")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        caught = list(pool.map(lambda mutation: try_mutation(mutation, folder), MUTATIONS))
    for (name, text, replacement), found in zip(MUTATIONS, caught):
        if not found:
            print(f"{name}: no archive pins {text!r}, which may be {replacement!r}")
    print(f"{sum(caught)} of {len(caught)} broken readers are caught")
    return 0 if all(caught) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
