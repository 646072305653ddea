using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.Rendering;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;

namespace FaceBaker.Unity
{
    /// <summary>Poses a mesh of a face: fills the mesh of the MeshFilter beside it, in place, in every frame in which a control
    /// has changed. Nothing is allocated in a frame. For a character of several meshes give each a component, and let all
    /// but one follow it (<see cref="Leader"/>), so that the face is evaluated once.</summary>
    [ExecuteAlways]
    [RequireComponent(typeof(MeshFilter), typeof(MeshRenderer))]
    [AddComponentMenu("FaceBaker/Face")]
    public sealed class FaceBakerFace : MonoBehaviour
    {
        [SerializeField] private FaceBakerAsset asset;
        [SerializeField] private string meshName = "";
        [SerializeField] private FaceBakerFace leader;
        [SerializeField, HideInInspector] private float[] values = new float[0];
        [SerializeField, HideInInspector] private string[] names = new string[0]; // of the controls that have these values
        [SerializeField, Min(0)] private float levelOfDetail;
        [SerializeField] private bool updateWhenOffscreen;

        private Face face;
        private FaceBakerAsset opened; // where the face comes from
        private FaceInstance instance;
        private RenderMesh render;
        private UnityEngine.Mesh mesh;
        private NativeArray<float> vertices;
        private MeshRenderer shower;
        private int[][] indices; // of each level
        private SubMeshDescriptor[][] parts;
        private int poseCount, written = -1, shownLevel = -1;

        /// <summary>The archive. Setting it puts all controls at rest.</summary>
        public FaceBakerAsset Asset
        {
            get { return asset; }
            set
            {
                if (asset == value) return;
                Close();
                asset = value;
                ForgetValues();
                if (isActiveAndEnabled) Open();
            }
        }

        /// <summary>The component whose pose this one shows; null: its own.</summary>
        public FaceBakerFace Leader
        {
            get { return leader; }
            set { leader = value; written = -1; }
        }

        /// <summary>The mesh of the face by its name; "": the first.</summary>
        public string MeshName
        {
            get { return meshName; }
            set
            {
                if (meshName == value) return;
                Close();
                meshName = value;
                if (isActiveAndEnabled) Open();
            }
        }

        /// <summary>For importers: sets all three without loading anything, which the component does where it is enabled in a
        /// scene.</summary>
        public void Configure(FaceBakerAsset archive, string nameOfMesh, FaceBakerFace shownPose)
        {
            Close();
            asset = archive;
            meshName = nameOfMesh;
            leader = shownPose;
            ForgetValues();
        }

        /// <summary>For importers whose archives have changed: opens the faces of these components anew, all of them at once,
        /// because they share them. Controls of the same names keep their values.</summary>
        public static void Reload(IEnumerable<FaceBakerFace> components)
        {
            var open = new List<FaceBakerFace>();
            foreach (FaceBakerFace component in components)
                if (component.face != null || component.isActiveAndEnabled) open.Add(component);
            foreach (FaceBakerFace component in open) component.Close();
            foreach (FaceBakerFace component in open) component.Open();
        }

        /// <summary>The loaded face; null while the component is disabled, or without an asset.</summary>
        public Face Face { get { return face; } }

        /// <summary>0: the whole; see <see cref="FaceInstance.Lod"/>. The triangles of the level that it is rounded down to are
        /// drawn.</summary>
        public float LevelOfDetail
        {
            get { return levelOfDetail; }
            set { levelOfDetail = Mathf.Max(0, value); }
        }

        /// <summary>Whether it is posed while no camera sees it, too: for sockets and joints that are asked for all the same.
        /// </summary>
        public bool UpdateWhenOffscreen
        {
            get { return updateWhenOffscreen; }
            set { updateWhenOffscreen = value; }
        }

        /// <summary>The value of a control, from then on until it is set again.</summary>
        /// <exception cref="FaceBakerException">There is no such control; the message has the closest name.</exception>
        public void SetControl(string control, float value)
        {
            SetControl(RequireFace().FindControl(control), value);
        }

        /// <summary>The same by index, which allocates nothing: look indices up once.</summary>
        public void SetControl(int control, float value)
        {
            RequireFace();
            values[control] = value;
        }

        /// <summary>All control values, in the order of <see cref="FaceBaker.Face.Controls"/>.</summary>
        /// <exception cref="ArgumentException">There are not as many as the face has controls.</exception>
        public void SetControls(ReadOnlySpan<float> pose)
        {
            if (pose.Length != RequireFace().ControlCount) throw new ArgumentException("A pose has " + values.Length +
                " values.");
            pose.CopyTo(values);
        }

        /// <summary>The value that a control was set to.</summary>
        public float GetControl(int control)
        {
            RequireFace();
            return values[control];
        }

        /// <summary>Puts all controls at rest.</summary>
        public void ResetControls()
        {
            values = RequireFace().RestControls.ToArray();
        }

        /// <summary>Where a socket of the last pose is, in the space of this component, for what hangs on the face; by index of
        /// <see cref="FaceBaker.Face.Sockets"/>.</summary>
        public Matrix4x4 GetSocket(int socket)
        {
            RequireFace();
            return MatrixOf(Shown.instance.Sockets.Slice(12 * socket, 12));
        }

        /// <summary>Where a joint that the controls drive is in the last pose, in the space of this component, for what hangs on
        /// a jaw or an eye, and for bones; by index of <see cref="FaceBaker.Face.DrivenJoints"/>.</summary>
        public Matrix4x4 GetDrivenJoint(int joint)
        {
            RequireFace();
            return MatrixOf(Shown.instance.Joints.Slice(12 * joint, 12));
        }

        private unsafe Matrix4x4 MatrixOf(ReadOnlySpan<float> frameOfArchive)
        {
            float* rows = stackalloc float[12];
            render.Axes.ApplyFrame(frameOfArchive, new Span<float>(rows, 12));
            var frame = new Matrix4x4();
            for (int i = 0; i < 12; ++i) frame[i / 4, i % 4] = rows[i];
            frame[3, 3] = 1;
            return frame;
        }

        // Whose pose this one shows.
        private FaceBakerFace Shown { get { return leader != null && leader.face == face ? leader : this; } }

        private Face RequireFace()
        {
            if (face == null) Open();
            if (face == null) throw new InvalidOperationException(name + ": no face is loaded.");
            return face;
        }

        private void OnEnable()
        {
            Open();
        }

        private void OnDisable()
        {
            Close();
        }

        private void LateUpdate()
        {
            if (face != null && (updateWhenOffscreen || shower.isVisible)) Show();
        }

        private void OnBecameVisible()
        {
            if (face != null) Show();
        }

        private void Show()
        {
            FaceBakerFace from = Shown;
            if (!from.Pose()) return;
            if (written == from.poseCount) return;
            WriteMesh(from.instance);
            written = from.poseCount;
        }

        // Whether there is a pose.
        private bool Pose()
        {
            instance.SetControls(values);
            instance.Lod = levelOfDetail;
            try
            {
                if (instance.Pose()) ++poseCount;
                return true;
            }
            catch (FaceBakerException exception)
            {
                Debug.LogError(name + ": " + exception.Message, this);
                enabled = false;
                return false;
            }
        }

        private void Open()
        {
            if (asset == null || face != null) return;
            try
            {
                face = asset.Acquire();
                opened = asset;
                MatchValues();
                instance = new FaceInstance(face) { LevelOnly = true };
                render = new RenderMesh(face, meshName.Length == 0 ? 0 : face.FindMesh(meshName), AxisConversion.ToUnity(face));
                MakeMesh();
            }
            catch (FaceBakerException exception)
            {
                Debug.LogError(name + ": " + exception.Message, this);
                Close();
            }
        }

        private void ForgetValues()
        {
            values = new float[0];
            names = new string[0];
        }

        // Values go to the controls of their names, for the order of controls changes when a face is baked anew; other controls
        // are at rest. Values without names are of earlier versions of this package.
        private void MatchValues()
        {
            var kept = new Dictionary<string, float>();
            bool named = names.Length == values.Length;
            if (!named && values.Length != face.ControlCount) values = new float[0];
            for (int i = 0; i < values.Length; ++i) kept[named ? names[i] : face.Controls[i].Name] = values[i];
            values = face.RestControls.ToArray();
            names = new string[values.Length];
            foreach (Control control in face.Controls)
            {
                names[control.Index] = control.Name;
                float value;
                if (!kept.TryGetValue(control.Name, out value)) continue;
                values[control.Index] = value;
                kept.Remove(control.Name);
            }
            if (kept.Count > 0)
                Debug.LogWarning(name + ": the face no longer has the controls " + string.Join(", ", kept.Keys) + ".", this);
        }

        // Stream 0 is written in every pose, stream 1, texture coordinates, once.
        private unsafe void MakeMesh()
        {
            vertices = new NativeArray<float>(render.VertexCount * render.VertexFloats, Allocator.Persistent);
            mesh = new UnityEngine.Mesh { name = face.Name, hideFlags = HideFlags.HideAndDontSave };
            mesh.MarkDynamic();
            var position = new VertexAttributeDescriptor(VertexAttribute.Position, VertexAttributeFormat.Float32, 3, 0);
            var normal = new VertexAttributeDescriptor(VertexAttribute.Normal, VertexAttributeFormat.Float32, 3, 0);
            var tangent = new VertexAttributeDescriptor(VertexAttribute.Tangent, VertexAttributeFormat.Float32, 4, 0);
            var uv = new VertexAttributeDescriptor(VertexAttribute.TexCoord0, VertexAttributeFormat.Float32, 2, 1);
            if (render.HasTangents) mesh.SetVertexBufferParams(render.VertexCount, position, normal, tangent, uv);
            else mesh.SetVertexBufferParams(render.VertexCount, position, normal);
            if (render.HasTangents) mesh.SetVertexBufferData(render.Uvs.ToArray(), 0, 0, render.Uvs.Length, 1, Quiet);
            MakeLevels();
            shower = GetComponent<MeshRenderer>();
            if (Pose()) WriteMesh(instance);
            GetComponent<MeshFilter>().sharedMesh = mesh;
            written = -1;
        }

        // One index buffer has room for the triangles of any level.
        private void MakeLevels()
        {
            int most = 0;
            indices = new int[render.Levels.Count][];
            parts = new SubMeshDescriptor[indices.Length][];
            for (int level = 0; level < indices.Length; ++level)
            {
                indices[level] = render.Levels[level].Indices.ToArray();
                most = Math.Max(most, indices[level].Length);
                parts[level] = new SubMeshDescriptor[render.Parts.Count];
                for (int i = 0; i < parts[level].Length; ++i)
                    parts[level][i] = Describe(render.Levels[level].Parts[i], indices[level]);
            }
            mesh.SetIndexBufferParams(most, IndexFormat.UInt32);
            mesh.subMeshCount = render.Parts.Count;
            shownLevel = -1;
        }

        // With the range of vertices, which Unity leaves to the caller where it does not compute bounds.
        private static SubMeshDescriptor Describe(RenderPart part, int[] indices)
        {
            int first = int.MaxValue, last = -1;
            for (int i = part.FirstIndex; i < part.FirstIndex + part.IndexCount; ++i)
            {
                first = Math.Min(first, indices[i]);
                last = Math.Max(last, indices[i]);
            }
            return new SubMeshDescriptor(part.FirstIndex, part.IndexCount)
            {
                firstVertex = last < 0 ? 0 : first,
                vertexCount = last < 0 ? 0 : last - first + 1,
            };
        }

        // Bounds are those of the pose, which are known.
        private const MeshUpdateFlags Quiet = MeshUpdateFlags.DontRecalculateBounds | MeshUpdateFlags.DontValidateIndices |
                                              MeshUpdateFlags.DontNotifyMeshUsers;

        private unsafe void WriteMesh(FaceInstance from)
        {
            int level = from.Level;
            from.Write(render, new Span<float>(vertices.GetUnsafePtr(), vertices.Length));
            mesh.SetVertexBufferData(vertices, 0, 0, render.Levels[level].VertexCount * render.VertexFloats, 0, Quiet);
            if (level != shownLevel) mesh.SetIndexBufferData(indices[level], 0, 0, indices[level].Length, Quiet);
            shownLevel = level;
            float* corners = stackalloc float[6];
            render.Axes.ApplyBounds(from.Bounds, new Span<float>(corners, 6));
            var bounds = new Bounds();
            bounds.SetMinMax(new Vector3(corners[0], corners[1], corners[2]), new Vector3(corners[3], corners[4], corners[5]));
            for (int i = 0; i < parts[level].Length; ++i)
            {
                parts[level][i].bounds = bounds;
                mesh.SetSubMesh(i, parts[level][i], Quiet);
            }
            mesh.bounds = bounds;
        }

        private void Close()
        {
            if (mesh != null) DestroyImmediate(mesh);
            if (vertices.IsCreated) vertices.Dispose();
            if (face != null) opened.Release();
            mesh = null;
            opened = null;
            instance = null;
            render = null;
            face = null;
        }
    }
}
