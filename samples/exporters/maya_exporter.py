"""Evaluates a plan in Maya 2022 or newer. NOT RUN HERE: written from Maya's documentation, on a machine without Maya.

In Maya's script editor, or headless in mayapy after maya.standalone.initialize() and cmds.file("face.ma", open=True):

    import sys; sys.path.insert(0, "/path/to/samples/exporters")
    import maya_exporter
    maya_exporter.write_schema_of("face.json", "face", ["jaw_ctl.translateY", "smile_L_ctl.translateX"])
    # in a shell: facebaker plan face.json --out face_plan
    maya_exporter.evaluate("face_plan", ["head_mesh"])

Controls are attributes, "node.attribute"; nothing else may be keyed or connected to them. Meshes are shapes or their
transforms, in the order that they are to have in the archive; they share one list of vertices. Positions are in object
space of each mesh, in centimetres, Maya's own unit, whatever the scene shows.
"""
import maya.api.OpenMaya as om
import maya.cmds as cmds

from plan_evaluation import evaluate_plan, write_schema


class MayaHost:
    def __init__(self, meshes):
        selection = om.MSelectionList()
        for mesh in meshes:
            selection.add(mesh)
        self.meshes = []
        for i in range(selection.length()):
            path = selection.getDagPath(i)
            path.extendToShape()
            self.meshes.append(path)

    def set_controls(self, values):
        for name, value in values.items():
            cmds.setAttr(name, value)

    def points(self):
        # A function set made anew reads the mesh as it is now, deformers included.
        return [x for path in self.meshes for p in om.MFnMesh(path).getPoints(om.MSpace.kObject) for x in (p.x, p.y, p.z)]

    def polygons(self):
        polygons, first = [], 0
        for path in self.meshes:
            mesh = om.MFnMesh(path)
            counts, corners = mesh.getVertices()
            at = 0
            for count in counts:
                polygons.append([first + corners[at + k] for k in range(count)])
                at += count
            first += mesh.numVertices
        return polygons


def control_of(attribute):
    """A control from an attribute: its range and default as Maya knows them, 0 to 1 where it knows no range."""
    node, _, name = attribute.partition(".")
    ask = {"node": node}
    low = cmds.attributeQuery(name, minimum=True, **ask)[0] if cmds.attributeQuery(name, minExists=True, **ask) else None
    high = cmds.attributeQuery(name, maximum=True, **ask)[0] if cmds.attributeQuery(name, maxExists=True, **ask) else None
    if low is None or high is None:  # transform attributes: their limits
        limit = {"translate": "translation", "rotate": "rotation"}.get(name[:-1])
        if limit and cmds.transformLimits(node, q=True, **{"enable" + limit.capitalize() + name[-1]: True}) == [True, True]:
            low, high = cmds.transformLimits(node, q=True, **{limit + name[-1]: True})
        else:
            low, high = 0.0, 1.0
    return {"name": attribute, "min": low, "max": high, "default": cmds.getAttr(attribute), "group": node}


def write_schema_of(path, name, attributes):
    """Call it with the rig at rest: what attributes have now is their default."""
    write_schema(path, name, "cm", cmds.upAxis(query=True, axis=True), [control_of(a) for a in attributes])


def evaluate(folder, meshes, clips=None):
    return evaluate_plan(folder, MayaHost(meshes), clips=clips)
