"""Random poses by the native library, for the viewer's test: what it has to show, bit for bit.

dump_poses.py FACE.fbk COUNT OUT writes OUT.controls and OUT.positions, float32 values, pose after pose.
"""

import sys

import facebaker
import numpy as np

face = facebaker.load(sys.argv[1])
count, out = int(sys.argv[2]), sys.argv[3]
random = np.random.default_rng(19)
low, high = face.ranges[:, 0], face.ranges[:, 1]
drawn = random.uniform(low, high, (count, len(low)))
active = random.random(drawn.shape) < random.choice([0.05, 0.2, 1.0], (count, 1))
controls = np.clip(np.where(active, drawn, face.rest_controls).astype(np.float32), low, high)
with open(f"{out}.controls", "wb") as file:
    file.write(np.ascontiguousarray(controls, np.float32).tobytes())
with open(f"{out}.positions", "wb") as file:
    for pose in controls:
        file.write(np.ascontiguousarray(face.evaluate(pose), np.float32).tobytes())
