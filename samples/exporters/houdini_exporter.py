"""Evaluates a plan in Houdini 19 or newer. NOT RUN HERE: written from Houdini's documentation, on a machine without
Houdini.

In Houdini's Python shell, or headless in hython after hou.hipFile.load("face.hip"):

    import sys; sys.path.insert(0, "/path/to/samples/exporters")
    import houdini_exporter
    houdini_exporter.write_schema_of("face.json", "face", ["/obj/face/rig/jaw_open", "/obj/face/rig/smile_l"])
    # in a shell: facebaker plan face.json --out face_plan
    houdini_exporter.evaluate("face_plan", "/obj/face/OUT")

Controls are parameters by their full path. The node is a SOP whose geometry is the face; its points keep their number
and order whatever the controls are. Positions are those of the geometry, in metres unless the scene has other units.
"""
import hou

from plan_evaluation import evaluate_plan, write_schema


class HoudiniHost:
    def __init__(self, node):
        self.node = hou.node(node)
        if self.node is None:
            raise ValueError("there is no node " + node)

    def set_controls(self, values):
        for name, value in values.items():
            hou.parm(name).set(value)

    def points(self):
        return self.node.geometry().pointFloatAttribValues("P")  # cooks the node

    def polygons(self):
        # Houdini's polygons run clockwise seen from outside.
        polygons = []
        for primitive in self.node.geometry().prims():
            if primitive.type() == hou.primType.Polygon and len(primitive.vertices()) >= 3:
                polygons.append([vertex.point().number() for vertex in reversed(primitive.vertices())])
        return polygons


def control_of(path):
    """A control from a parameter: its range as its template has it, its value now as the default."""
    parm = hou.parm(path)
    template = parm.parmTemplate()
    return {"name": path, "min": template.minValue(), "max": template.maxValue(), "default": parm.eval(),
            "group": parm.node().name()}


def write_schema_of(path, name, parameters):
    """Call it with the rig at rest."""
    write_schema(path, name, "m", "y", [control_of(parameter) for parameter in parameters])


def evaluate(folder, node, clips=None):
    return evaluate_plan(folder, HoudiniHost(node), clips=clips)
