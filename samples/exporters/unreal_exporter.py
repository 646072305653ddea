"""Evaluates a plan in Unreal Editor 5.4 or newer. NOT RUN HERE: written from Unreal's documentation, on a machine without
Unreal.

Plugins: Python Editor Script, Geometry Script, Control Rig. Open a level sequence that has the character with a control
rig, then in the editor's Python console:

    import sys; sys.path.insert(0, "/path/to/samples/exporters")
    import unreal_exporter
    unreal_exporter.write_schema_of("face.json", "face", {"CTRL_jaw_open": (0, 1), "CTRL_smile_l": (0, 1)})
    # in a shell: facebaker plan face.json --out face_plan
    unreal_exporter.evaluate("face_plan", component)

`component` is the skeletal mesh component of the character in the sequence, such as
actor.get_component_by_class(unreal.SkeletalMeshComponent) of a selected actor. Controls are float controls of the first
control rig of the sequence, by name. Every pose is keyed at one frame of the sequence, which is not saved. Positions are
in the component's space, in centimetres, with Unreal's axes: z up, and left-handed. The exporter turns y around, so that
what it writes is right-handed.
"""
import unreal

from plan_evaluation import evaluate_plan, write_schema

FRAME = 0  # of the sequence, in display rate


class UnrealHost:
    def __init__(self, component):
        self.component = component
        self.sequence = unreal.LevelSequenceEditorBlueprintLibrary.get_current_level_sequence()
        rigs = unreal.ControlRigSequencerLibrary.get_control_rigs(self.sequence)
        if not rigs:
            raise ValueError("the open level sequence has no control rig")
        self.rig = rigs[0].control_rig
        self.mesh = unreal.DynamicMesh()

    def set_controls(self, values):
        for name, value in values.items():
            unreal.ControlRigSequencerLibrary.set_local_control_rig_float(
                self.sequence, self.rig, name, unreal.FrameNumber(FRAME), value, set_key=True)
        unreal.LevelSequenceEditorBlueprintLibrary.set_current_time(FRAME)
        unreal.LevelSequenceEditorBlueprintLibrary.force_update()

    def copy(self):
        """The mesh as it is posed, vertices in the order of the skeletal mesh."""
        options = unreal.GeometryScriptCopyMeshFromComponentOptions()
        result = unreal.GeometryScript_SceneUtils.copy_mesh_from_component(self.component, self.mesh, options, False)
        if result[-1] != unreal.GeometryScriptOutcomePins.SUCCESS:
            raise RuntimeError("the component's mesh cannot be copied")
        return self.mesh

    def points(self):
        positions = unreal.GeometryScript_MeshQueries.get_all_vertex_positions(self.copy(), False)[1]
        return [x for p in unreal.GeometryScript_List.convert_vector_list_to_array(positions) for x in (p.x, -p.y, p.z)]

    def polygons(self):
        triangles = unreal.GeometryScript_MeshQueries.get_all_triangle_indices(self.copy(), False)[1]
        # Turning y around turns polygons round too, and Unreal's run clockwise: as they are, they face outwards.
        return [[t.x, t.y, t.z] for t in unreal.GeometryScript_List.convert_triangle_list_to_array(triangles)]


def write_schema_of(path, name, ranges):
    """ranges: {name of a control: (minimum, maximum)}; 0, or the end nearest to it, is the default."""
    controls = [{"name": control, "min": low, "max": high, "default": min(max(0, low), high)}
                for control, (low, high) in ranges.items()]
    write_schema(path, name, "cm", "z", controls)


def evaluate(folder, component, clips=None):
    return evaluate_plan(folder, UnrealHost(component), clips=clips)
