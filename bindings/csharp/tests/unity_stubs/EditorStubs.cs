// Not Unity: the little of UnityEditor that the Unity package uses; see EngineStubs.cs.
using System;
using System.Collections.Generic;
using UnityEngine;

#pragma warning disable 1591, 649
namespace UnityEditor
{
    public enum MessageType { Info }

    public class CustomEditor : Attribute { public CustomEditor(Type type) { } }

    public class Editor
    {
        public UnityEngine.Object target;
        public virtual void OnInspectorGUI() { }
        public bool DrawDefaultInspector() { return true; }
    }

    public static class EditorGUILayout
    {
        public static readonly List<string> Drawn = new List<string>();
        public static string TextField(string label, string text) { return text; }
        public static bool Foldout(bool open, string title) { Drawn.Add(title); return true; }
        public static void HelpBox(string text, MessageType type) { Drawn.Add(text); }

        public static float Slider(GUIContent label, float value, float least, float most)
        {
            EditorGUI.Changed = true;
            return most;
        }
    }

    public static class EditorGUI
    {
        public static bool Changed;
        public static void BeginChangeCheck() { Changed = false; }
        public static bool EndChangeCheck() { return Changed; }
    }

    public static class Undo { public static void RecordObject(UnityEngine.Object changed, string name) { } }
    public static class EditorUtility
    {
        public static void SetDirty(UnityEngine.Object changed) { }
        public static bool IsPersistent(UnityEngine.Object asked) { return false; }
    }

    public class AssetPostprocessor { }

    public static class AssetDatabase
    {
        public static readonly Dictionary<UnityEngine.Object, string> Paths = new Dictionary<UnityEngine.Object, string>();

        public static string GetAssetPath(UnityEngine.Object asset)
        {
            string path;
            return asset != null && Paths.TryGetValue(asset, out path) ? path : "";
        }
    }

    public static class EditorApplication
    {
        public static int Queued;
        public static void QueuePlayerLoopUpdate() { ++Queued; }
    }
}

namespace UnityEditor.AssetImporters
{
    public sealed class ScriptedImporterAttribute : Attribute { public ScriptedImporterAttribute(int version,
        string extension) { } }

    public abstract class ScriptedImporter
    {
        public abstract void OnImportAsset(AssetImportContext context);
    }

    public sealed class AssetImportContext
    {
        public readonly Dictionary<string, UnityEngine.Object> Objects = new Dictionary<string, UnityEngine.Object>();
        public readonly List<string> Errors = new List<string>(), Warnings = new List<string>();
        public UnityEngine.Object Main;

        public string assetPath { get; set; }
        public void AddObjectToAsset(string identifier, UnityEngine.Object made) { Objects.Add(identifier, made); }
        public void SetMainObject(UnityEngine.Object made) { Main = made; }
        public void LogImportError(string message) { Errors.Add(message); }
        public void LogImportWarning(string message) { Warnings.Add(message); }
    }
}
