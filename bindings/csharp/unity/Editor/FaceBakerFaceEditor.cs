using System.Collections.Generic;
using UnityEditor;
using UnityEngine;

namespace FaceBaker.Unity.Editor
{
    /// <summary>The inspector of a face: a slider for each control, by group, with a search field and a reset button.</summary>
    [CustomEditor(typeof(FaceBakerFace))]
    public sealed class FaceBakerFaceEditor : UnityEditor.Editor
    {
        private readonly HashSet<string> open = new HashSet<string>();
        private string search = "";

        /// <summary>Called by Unity.</summary>
        public override void OnInspectorGUI()
        {
            DrawDefaultInspector();
            var component = (FaceBakerFace)target;
            if (component.Face == null) return;
            if (component.Leader != null)
            {
                EditorGUILayout.HelpBox("This mesh shows the pose of " + component.Leader.name + ".", MessageType.Info);
                return;
            }
            search = EditorGUILayout.TextField("Search", search);
            if (GUILayout.Button("Put all controls at rest"))
            {
                Undo.RecordObject(component, "Reset controls");
                component.ResetControls();
                EditorUtility.SetDirty(component);
            }
            foreach (KeyValuePair<string, List<Control>> group in ControlSearch.ByGroup(component.Face.Controls, search))
                DrawGroup(component, group.Key, group.Value);
        }

        private void DrawGroup(FaceBakerFace component, string name, List<Control> controls)
        {
            string title = name.Length > 0 ? name : "Controls";
            bool shown = EditorGUILayout.Foldout(open.Contains(name) || search.Length > 0, title);
            if (search.Length == 0)
            {
                if (shown) open.Add(name);
                else open.Remove(name);
            }
            if (!shown) return;
            foreach (Control control in controls)
            {
                EditorGUI.BeginChangeCheck();
                float value = EditorGUILayout.Slider(new GUIContent(control.Name, control.ArKit + " " + control.Facs),
                                                     component.GetControl(control.Index), control.Minimum, control.Maximum);
                if (!EditorGUI.EndChangeCheck()) continue;
                Undo.RecordObject(component, "Set " + control.Name);
                component.SetControl(control.Index, value);
                EditorUtility.SetDirty(component);
            }
        }
    }
}
