"""Evaluates a plan: a dataset folder that `facebaker plan` wrote, of which the points are missing.

Programs differ in how controls are set and points are read. That is a host, an object with

    set_controls(values)    values: {name of a control: value}; all controls, in the units of the rig
    points()                positions of all vertices, x y z x y z ..., object space, in the units of the plan
    polygons()              vertex indices of each polygon; asked once, where the plan has no rest mesh

What is here is the same for all of them: it goes through the clips of the plan, writes points in files of some hundred
frames, and goes on after an interruption behind the last file that is whole. Standard library only; Python 3.7 or newer.
"""
import array
import json
import math
import os

from npy_files import NpyError, read_npy, read_shape, write_npy


class PlanError(Exception):
    """A folder that cannot be evaluated, or a host that gives no points for it; the message says where."""


class Plan:
    """The parts of dataset.json that matter here."""

    def __init__(self, folder):
        self.folder = folder
        path = os.path.join(folder, "dataset.json")
        try:
            with open(path, encoding="utf-8") as file:
                index = json.load(file)
        except (OSError, ValueError) as error:
            raise PlanError("%s: %s" % (path, error)) from None
        if index.get("format") != "facebaker-dataset" or not index.get("plan"):
            raise PlanError("%s: is no plan; `facebaker plan` writes one" % path)
        if index.get("channels"):
            raise PlanError("%s: has channels, which these exporters do not write" % path)
        self.controls = index["controls"]
        self.clips = index["clips"]
        self.rest = index["rest"]
        self.units = index["units"]

    def path(self, name):
        return os.path.join(self.folder, name)

    @property
    def names(self):
        return [control["name"] for control in self.controls]

    def rest_pose(self):
        return {control["name"]: control["default"] for control in self.controls}

    def poses(self, clip):
        """Values of all controls, frame after frame: a list of dictionaries."""
        shape, values = read_npy(self.path(clip["controls"]))
        width = len(self.controls)
        if len(shape) != 2 or shape[1] != width:
            raise PlanError("%s: shape %s where (frames, %d) is needed" % (clip["controls"], shape, width))
        return [dict(zip(self.names, values[width * f : width * (f + 1)])) for f in range(shape[0])]

    def part_path(self, clip, number):
        """A file of some frames of a clip: "smile.points.npy" comes as "smile.000.points.npy", ..."""
        name = clip["points"]
        end = len(name) - len(".points.npy") if name.endswith(".points.npy") else len(name) - len(".npy")
        return self.path("%s.%03d%s" % (name[:end], number, name[end:]))


def frames_done(plan, clip, vertices):
    """Frames that are written already, and files they are in. A file that is not whole is removed, with those after it."""
    if os.path.exists(plan.path(clip["points"])):
        return read_shape(plan.path(clip["points"]))[0], 0
    frames = files = 0
    while os.path.exists(plan.part_path(clip, files)):
        try:
            shape = read_shape(plan.part_path(clip, files))
        except NpyError:
            break
        if vertices is not None and shape[1:] != (vertices, 3):
            raise PlanError("%s: shape %s, but the mesh has %d vertices now" % (plan.part_path(clip, files), shape, vertices))
        frames += shape[0]
        files += 1
    later = files
    while os.path.exists(plan.part_path(clip, later)):
        os.remove(plan.part_path(clip, later))
        later += 1
    return frames, files


def checked_points(host, vertices, where):
    points = array.array("f", host.points())
    if len(points) % 3 or vertices is not None and len(points) != 3 * vertices:
        raise PlanError("%s: %d coordinates where %s are needed" % (where, len(points), "3 a vertex" if vertices is None else 3 * vertices))
    for i, value in enumerate(points):
        if not math.isfinite(value):
            raise PlanError("%s: vertex %d is not finite" % (where, i // 3))
    return points


def write_rest(plan, host):
    """Writes the rest mesh where it is missing; returns its number of vertices."""
    if not isinstance(plan.rest, dict):
        return None  # a mesh file
    points_path, faces_path = plan.path(plan.rest["points"]), plan.path(plan.rest["faces"])
    if not (os.path.exists(points_path) and os.path.exists(faces_path)):
        host.set_controls(plan.rest_pose())
        points = checked_points(host, None, "the rest pose")
        polygons = [list(polygon) for polygon in host.polygons()]
        width = max([3] + [len(polygon) for polygon in polygons])
        corners = array.array("i", [c for p in polygons for c in p + [-1] * (width - len(p))])
        write_npy(faces_path, (len(polygons), width), corners)
        write_npy(points_path, (len(points) // 3, 3), points)
    return read_shape(points_path)[0]


def evaluate_clip(plan, clip, host, vertices, poses_per_file):
    """Writes the points that a clip lacks; returns how many frames that were."""
    poses = plan.poses(clip)
    done, number = frames_done(plan, clip, vertices)
    start = done
    while done < len(poses):
        count = min(poses_per_file, len(poses) - done)
        block = array.array("f")
        for frame in range(done, done + count):
            host.set_controls(poses[frame])
            where = "clip \"%s\", frame %d" % (clip["name"], frame)
            block.extend(checked_points(host, vertices, where))
            if vertices is None:
                vertices = len(block) // 3
        write_npy(plan.part_path(clip, number), (count, vertices, 3), block)
        done += count
        number += 1
    return done - start


def evaluate_plan(folder, host, poses_per_file=200, clips=None, report=print):
    """Writes all points that a plan lacks; `clips`: names of those to evaluate, so that several programs can share a
    plan; None: all. Leaves the host at rest. Returns how many poses were evaluated now."""
    plan = Plan(folder)
    unknown = set(clips or ()) - {clip["name"] for clip in plan.clips}
    if unknown:
        raise PlanError("%s: has no clip \"%s\"" % (folder, sorted(unknown)[0]))
    vertices = write_rest(plan, host)
    evaluated = 0
    try:
        for clip in plan.clips:
            if clips is not None and clip["name"] not in clips:
                continue
            new = evaluate_clip(plan, clip, host, vertices, poses_per_file)
            evaluated += new
            report("%s: %d poses evaluated" % (clip["name"], new) if new else "%s: is there" % clip["name"])
    finally:
        host.set_controls(plan.rest_pose())
    return evaluated


def write_schema(path, name, units, up_axis, controls):
    """Writes what `facebaker plan` needs to know of a rig. `controls`: dictionaries with "name", "min", "max", "default"
    and, if there is one, "group"."""
    schema = {"format": "facebaker-dataset", "version": 1, "name": name, "units": units, "up_axis": up_axis,
              "controls": controls}
    temporary = path + ".part"
    with open(temporary, "w", encoding="utf-8") as file:
        json.dump(schema, file, indent=1)
    os.replace(temporary, path)
