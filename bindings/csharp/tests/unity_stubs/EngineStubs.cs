// Not Unity: the little of UnityEngine that the Unity package uses, written for its tests, so that the package compiles and its
// component can be called without the editor. Meshes keep what is written to them; nothing is drawn.
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

#pragma warning disable 1591, 649
namespace AOT
{
    [AttributeUsage(AttributeTargets.Method)]
    public sealed class MonoPInvokeCallbackAttribute : Attribute
    {
        public MonoPInvokeCallbackAttribute(Type type) { }
    }
}

namespace Unity.Collections
{
    public enum Allocator { Persistent = 4 }

    public unsafe struct NativeArray<T> : IDisposable where T : struct
    {
        internal IntPtr Memory;
        private int length;

        public NativeArray(int length, Allocator allocator)
        {
            this.length = length;
            Memory = Marshal.AllocHGlobal(length * Marshal.SizeOf(typeof(T)));
        }

        public int Length { get { return length; } }
        public bool IsCreated { get { return Memory != IntPtr.Zero; } }

        public void Dispose()
        {
            Marshal.FreeHGlobal(Memory);
            Memory = IntPtr.Zero;
        }
    }
}

namespace Unity.Collections.LowLevel.Unsafe
{
    public static class NativeArrayUnsafeUtility
    {
        public static unsafe void* GetUnsafePtr<T>(this NativeArray<T> array) where T : struct
        {
            return (void*)array.Memory;
        }
    }
}

namespace UnityEngine.Rendering
{
    public enum VertexAttribute { Position, Normal, Tangent, TexCoord0 = 4 }
    public enum VertexAttributeFormat { Float32 }
    public enum IndexFormat { UInt16, UInt32 }
    [Flags] public enum MeshUpdateFlags { DontValidateIndices = 1, DontNotifyMeshUsers = 4, DontRecalculateBounds = 8 }

    public struct VertexAttributeDescriptor
    {
        public readonly VertexAttribute Attribute;
        public readonly int Dimension, Stream;

        public VertexAttributeDescriptor(VertexAttribute attribute, VertexAttributeFormat format, int dimension, int stream)
        {
            Attribute = attribute;
            Dimension = dimension;
            Stream = stream;
        }
    }

    // Unity takes ranges and bounds as they are where DontRecalculateBounds is set.
    public struct SubMeshDescriptor
    {
        public int indexStart { get; set; }
        public int indexCount { get; set; }
        public int firstVertex { get; set; }
        public int vertexCount { get; set; }
        public Bounds bounds { get; set; }

        public SubMeshDescriptor(int indexStart, int indexCount) : this()
        {
            this.indexStart = indexStart;
            this.indexCount = indexCount;
        }
    }

    public class RenderPipelineAsset : Object
    {
        public Shader defaultShader { get { return new Shader(); } }
    }

    public static class GraphicsSettings
    {
        public static RenderPipelineAsset defaultRenderPipeline { get; set; }
    }
}

namespace UnityEngine
{
    using Rendering;
    using Unity.Collections;

    public sealed class SerializeField : Attribute { }
    public sealed class HideInInspector : Attribute { }
    public sealed class ExecuteAlways : Attribute { }
    public sealed class MinAttribute : Attribute { public MinAttribute(float min) { } }
    public sealed class RequireComponent : Attribute { public RequireComponent(Type one, Type two) { } }
    public sealed class AddComponentMenu : Attribute { public AddComponentMenu(string name) { } }

    [Flags] public enum HideFlags { HideAndDontSave = 61 }

    public struct Vector3
    {
        public float x, y, z;
        public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
    }

    public struct Matrix4x4
    {
        private float[] values;

        public float this[int row, int column]
        {
            get { return values[4 * row + column]; }
            set { (values ?? (values = new float[16]))[4 * row + column] = value; }
        }
    }

    public struct Color
    {
        public float r, g, b, a;
        public Color(float r, float g, float b, float a) { this.r = r; this.g = g; this.b = b; this.a = a; }
        public Color gamma { get { return this; } }
    }

    public struct Bounds
    {
        public Vector3 min, max;
        public void SetMinMax(Vector3 least, Vector3 most) { min = least; max = most; }
    }

    public static class Mathf
    {
        public static float Max(float one, float two) { return Math.Max(one, two); }
        public static float Sin(float angle) { return (float)Math.Sin(angle); }
    }

    public static class Time { public static float time { get; set; } }

    public static class Debug
    {
        public static readonly List<string> Errors = new List<string>(), Warnings = new List<string>();
        public static void LogWarning(object message, Object context) { Warnings.Add("" + message); }
        public static void LogError(object message, Object context) { Errors.Add("" + message); }
    }

    public class Object
    {
        public string name { get; set; }
        public HideFlags hideFlags { get; set; }
        public static void DestroyImmediate(Object gone) { }
    }

    public class ScriptableObject : Object
    {
        public static T CreateInstance<T>() where T : ScriptableObject, new() { return new T(); }
    }

    public static class Resources
    {
        internal static readonly List<Object> Made = new List<Object>();

        public static T[] FindObjectsOfTypeAll<T>() where T : Object
        {
            var found = new List<T>();
            foreach (Object made in Made)
                if (made is T) found.Add((T)made);
            return found.ToArray();
        }
    }

    public class Component : Object
    {
        public GameObject gameObject { get; internal set; }
        public Transform transform { get { return gameObject.transform; } }
        public T GetComponent<T>() where T : Component, new() { return gameObject.Component<T>(); }
    }

    public class Behaviour : Component
    {
        public bool enabled { get; set; }
        public bool isActiveAndEnabled { get { return enabled; } }
    }

    public class MonoBehaviour : Behaviour { }
    public class Transform : Component { public void SetParent(Transform parent, bool keepsWorld) { } }
    public class MeshFilter : Component { public Mesh sharedMesh { get; set; } }
    public class Renderer : Component
    {
        public bool isVisible { get; set; } = true; // in the stub's one frame
        public Material[] sharedMaterials { get; set; }
    }

    public class MeshRenderer : Renderer { }
    public class Shader : Object { public static Shader Find(string name) { return new Shader(); } }
    public class Texture : Object { }
    public class Texture2D : Texture { public Texture2D(int width, int height) { } }

    public class Material : Object
    {
        public Material(Shader shader) { }
        public Color color { get; set; }
        public Texture mainTexture { get; set; }
    }

    public static class ImageConversion
    {
        public static bool LoadImage(this Texture2D texture, byte[] data) { return data.Length > 0; }
    }

    public sealed class GameObject : Object
    {
        private readonly List<Component> components = new List<Component>();

        public GameObject(string name) { this.name = name; }
        public Transform transform { get { return Component<Transform>(); } }
        public T AddComponent<T>() where T : Component, new() { return Component<T>(); }

        internal T Component<T>() where T : Component, new()
        {
            foreach (Component component in components)
                if (component is T) return (T)component;
            var made = new T { gameObject = this, name = name };
            components.Add(made);
            Resources.Made.Add(made);
            return made;
        }
    }

    public class GUIContent { public GUIContent(string text, string tooltip) { } }
    public static class GUILayout { public static bool Button(string text) { return false; } }

    public sealed class Mesh : Object
    {
        public readonly float[][] Streams = new float[2][];
        public int[] Indices;
        public SubMeshDescriptor[] Parts = new SubMeshDescriptor[0];
        public int subMeshCount
        {
            get { return Parts.Length; }
            set { Array.Resize(ref Parts, value); }
        }

        public Bounds bounds { get; set; }

        public void MarkDynamic() { }

        public void SetVertexBufferParams(int vertexCount, params VertexAttributeDescriptor[] attributes)
        {
            var floats = new int[2];
            foreach (VertexAttributeDescriptor attribute in attributes) floats[attribute.Stream] += attribute.Dimension;
            for (int i = 0; i < 2; ++i) Streams[i] = new float[vertexCount * floats[i]];
        }

        public void SetVertexBufferData(float[] data, int from, int to, int count, int stream, MeshUpdateFlags flags)
        {
            Array.Copy(data, from, Streams[stream], to, count);
        }

        public void SetVertexBufferData(NativeArray<float> data, int from, int to, int count, int stream, MeshUpdateFlags flags)
        {
            Marshal.Copy(data.Memory, Streams[stream], to, count);
        }

        public void SetIndexBufferParams(int count, IndexFormat format) { Indices = new int[count]; }

        public void SetIndexBufferData(int[] data, int from, int to, int count, MeshUpdateFlags flags)
        {
            Array.Copy(data, from, Indices, to, count);
        }

        public void SetSubMesh(int index, SubMeshDescriptor part, MeshUpdateFlags flags) { Parts[index] = part; }
    }
}
