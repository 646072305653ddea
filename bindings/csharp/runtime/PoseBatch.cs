using System;

namespace FaceBaker
{
    /// <summary>Poses to evaluate at once, or one with more than positions, and where they are written. Spans that are empty
    /// are no output. It is made on the stack and allocates nothing:
    /// <code>scratch.EvaluateBatch(new PoseBatch(1, controls) { Positions = positions, Normals = normals });</code> Buffers
    /// are of poses x stride; strides count numbers (floats, or ushorts in half buffers), and 0 is no gap. A buffer that is
    /// too small is refused before anything is written. Buffers may not overlap. The same bits on every machine.</summary>
    public ref struct PoseBatch
    {
        /// <summary>A batch without outputs. controls: poses x <see cref="Face.ControlCount"/> floats.</summary>
        public PoseBatch(int poses, ReadOnlySpan<float> controls) : this()
        {
            Poses = poses;
            Controls = controls;
        }

        /// <summary>How many poses; may be 0.</summary>
        public int Poses;
        /// <summary>Control values, pose after pose.</summary>
        public ReadOnlySpan<float> Controls;
        /// <summary>From a pose to the next in <see cref="Controls"/>; 0: <see cref="Face.ControlCount"/>.</summary>
        public long ControlStride;
        /// <summary>Threads at most; 0: all workers of the scratch.</summary>
        public int Threads;
        /// <summary>Who runs the poses; null: see <see cref="ParallelForHandle"/>. Not called where one thread is
        /// enough.</summary>
        public ParallelForHandle ParallelFor;

        /// <summary>Positions, xyz interleaved, in <see cref="Face.Units"/>.</summary>
        public Span<float> Positions;
        /// <summary>Positions as IEEE 754 binary16, in place of <see cref="Positions"/>; normals and tangents are then,
        /// too.</summary>
        public Span<ushort> HalfPositions;
        /// <summary>From a pose to the next; 0: without gap.</summary>
        public long PositionPoseStride;
        /// <summary>From a vertex to the next, at least 3; 0: 3. Gaps are not written.</summary>
        public long PositionVertexStride;

        /// <summary>Unit normals, laid out like positions.</summary>
        public Span<float> Normals;
        /// <summary>Normals as binary16.</summary>
        public Span<ushort> HalfNormals;
        /// <summary>As for positions.</summary>
        public long NormalPoseStride;
        /// <summary>As for positions.</summary>
        public long NormalVertexStride;

        /// <summary>Unit tangents, 3 numbers a vertex, perpendicular to normals; see <see cref="Face.TangentSigns"/>. Refused
        /// for a face without texture coordinates.</summary>
        public Span<float> Tangents;
        /// <summary>Tangents as binary16.</summary>
        public Span<ushort> HalfTangents;
        /// <summary>As for positions.</summary>
        public long TangentPoseStride;
        /// <summary>As for positions.</summary>
        public long TangentVertexStride;

        /// <summary>Frames of <see cref="Face.Sockets"/>, 12 floats each: three rows of a matrix.</summary>
        public Span<float> Sockets;
        /// <summary>From a pose to the next; 0: without gap.</summary>
        public long SocketPoseStride;
        /// <summary>Frames of <see cref="Face.DrivenJoints"/>, likewise. Refused for a face without driven joints.</summary>
        public Span<float> Joints;
        /// <summary>From a pose to the next; 0: without gap.</summary>
        public long JointPoseStride;
        /// <summary>Values of <see cref="Face.Channels"/>, one float each.</summary>
        public Span<float> Channels;
        /// <summary>From a pose to the next; 0: without gap.</summary>
        public long ChannelPoseStride;
        /// <summary>Of each pose 1 + <see cref="Face.ErrorRegions"/> floats: the error to expect, of the face and each region.
        /// </summary>
        public Span<float> ExpectedErrors;
        /// <summary>From a pose to the next; 0: without gap.</summary>
        public long ExpectedErrorPoseStride;
        /// <summary>Of each pose how many controls are outside of what was trained.</summary>
        public Span<uint> Outside;
        /// <summary>Of each pose 6 floats: the smallest x, y, z, and the largest.</summary>
        public Span<float> Bounds;
        /// <summary>From a pose to the next; 0: without gap.</summary>
        public long BoundsPoseStride;

        /// <summary>Indices of the regions whose networks run; empty: all.</summary>
        public ReadOnlySpan<uint> Regions;
        /// <summary>No network runs, whatever <see cref="Regions"/> says.</summary>
        public bool WithoutRegions;
        /// <summary>Indices of the meshes that are posed; empty: all.</summary>
        public ReadOnlySpan<uint> Meshes;
        /// <summary>Level of detail: 0 is the whole; see <see cref="Face.Levels"/>. Fractions lie between two levels.</summary>
        public float Lod;
        /// <summary>Only vertices of the level are written, the first in baked order; needs <see cref="BakedOrder"/>.</summary>
        public bool LevelOnly;
        /// <summary>Vertices in the order of <see cref="Face.VertexOrder"/>, which is quicker.</summary>
        public bool BakedOrder;
        /// <summary>Displacements from the rest pose in place of positions, before driven joints move the vertices.</summary>
        public bool Displacements;
        /// <summary>Positions, normals and tangents are those before driven joints move the vertices, for a host that does so
        /// itself: see <see cref="Face.DrivenSkinWeights"/>. Bounds and sockets are of what is seen.</summary>
        public bool Unskinned;
    }
}
