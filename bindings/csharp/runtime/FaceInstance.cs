using System;

namespace FaceBaker
{
    /// <summary>One of any number of characters that share a face: its control values, and its last pose with normals, tangents
    /// and bounds. It takes no memory but for these: working memory is the face's, for each thread that poses. Of one thread at a
    /// time. Posing allocates nothing.</summary>
    public sealed class FaceInstance
    {
        private readonly float[] controls, positions, normals, tangents, sockets, joints;
        private readonly float[] bounds = new float[6];
        private readonly int[] levelVertices;
        private bool posed, levelOnly, baked;
        private float lod;
        private int numbers; // of positions

        /// <summary>At rest, not posed yet.</summary>
        /// <exception cref="ArgumentNullException">face is null.</exception>
        public FaceInstance(Face face)
        {
            if (face == null) throw new ArgumentNullException(nameof(face));
            Face = face;
            levelVertices = new int[face.Levels.Count];
            for (int i = 0; i < levelVertices.Length; ++i) levelVertices[i] = face.Levels[i].VertexCount;
            controls = face.RestControls.ToArray();
            positions = new float[3 * face.VertexCount];
            numbers = positions.Length;
            normals = new float[positions.Length];
            sockets = new float[12 * face.Sockets.Count];
            joints = new float[12 * face.DrivenJoints.Count];
            tangents = new float[face.TangentSigns.Length == 0 ? 0 : positions.Length];
        }

        /// <summary>The face.</summary>
        public Face Face { get; private set; }

        /// <summary>The value of a control by its index. Values out of its range are clamped when it poses.</summary>
        public float this[int control]
        {
            get { return controls[control]; }
            set
            {
                if (controls[control] == value) return;
                controls[control] = value;
                posed = false;
            }
        }

        /// <summary>All control values.</summary>
        public ReadOnlySpan<float> Controls { get { return controls; } }

        /// <summary>Sets all control values.</summary>
        /// <exception cref="ArgumentException">There are not as many as the face has controls.</exception>
        public void SetControls(ReadOnlySpan<float> values)
        {
            if (values.Length != controls.Length)
                throw new ArgumentException("A pose has " + controls.Length + " values.", nameof(values));
            if (values.SequenceEqual(controls)) return;
            values.CopyTo(controls);
            posed = false;
        }

        /// <summary>Level of detail, 0 or more; see <see cref="PoseBatch.Lod"/>.</summary>
        public float Lod
        {
            get { return lod; }
            set
            {
                if (lod == value) return;
                lod = value;
                posed = false;
            }
        }

        /// <summary>Whether poses are of the vertices of <see cref="Level"/> alone, in baked order (<see
        /// cref="FaceBaker.Face.VertexOrder"/>), which takes half of the time at coarse levels; else of all, in the source's
        /// order.</summary>
        public bool LevelOnly
        {
            get { return levelOnly; }
            set
            {
                if (levelOnly == value) return;
                levelOnly = value;
                posed = false;
            }
        }

        /// <summary>The level of the last pose, whose triangles are drawn: <see cref="Lod"/> rounded down.</summary>
        public int Level { get; private set; }

        /// <summary>Positions of the last pose: 3 x <see cref="FaceBaker.Face.VertexCount"/> floats, in the archive's axes and
        /// units; with <see cref="LevelOnly"/> 3 x that of the level.</summary>
        public ReadOnlySpan<float> Positions { get { return new ReadOnlySpan<float>(positions, 0, numbers); } }
        /// <summary>Its normals.</summary>
        public ReadOnlySpan<float> Normals { get { return new ReadOnlySpan<float>(normals, 0, numbers); } }
        /// <summary>Its tangents; empty for a face without texture coordinates.</summary>
        public ReadOnlySpan<float> Tangents
        {
            get { return new ReadOnlySpan<float>(tangents, 0, Math.Min(numbers, tangents.Length)); }
        }
        /// <summary>Frames of its sockets, 12 floats each, in the archive's axes and units; see <see
        /// cref="AxisConversion.ApplyFrame"/>.</summary>
        public ReadOnlySpan<float> Sockets { get { return sockets; } }
        /// <summary>Frames of its driven joints, likewise.</summary>
        public ReadOnlySpan<float> Joints { get { return joints; } }
        /// <summary>Its smallest x, y, z and its largest.</summary>
        public ReadOnlySpan<float> Bounds { get { return bounds; } }

        /// <summary>Poses, if anything was set since it last did; returns whether it did.</summary>
        /// <exception cref="FaceBakerException">A control is NaN; the last pose stays.</exception>
        /// <exception cref="ObjectDisposedException">The face was disposed.</exception>
        public bool Pose()
        {
            if (posed) return false;
            Face.EvaluateBatch(new PoseBatch(1, controls)
            {
                Positions = positions, Normals = normals, Tangents = tangents, Sockets = sockets, Joints = joints,
                Bounds = bounds, Lod = lod, LevelOnly = levelOnly, BakedOrder = levelOnly
            });
            Level = (int)Math.Min(lod, levelVertices.Length - 1);
            baked = levelOnly;
            numbers = levelOnly ? 3 * levelVertices[Level] : positions.Length;
            posed = true;
            return true;
        }

        /// <summary>Writes the last pose of a mesh, of the vertices of its <see cref="Level"/>, as <see cref="RenderMesh.Write"/>
        /// does.</summary>
        public void Write(RenderMesh mesh, Span<float> vertices)
        {
            mesh.Write(Positions, Normals, Tangents, vertices, Level, baked);
        }
    }
}
