using System;
using System.Collections.Generic;

namespace FaceBaker
{
    /// <summary>Consecutive triangles of a <see cref="RenderLevel"/> that have one material.</summary>
    public struct RenderPart
    {
        internal RenderPart(int material, int firstIndex, int indexCount)
        {
            Material = material;
            FirstIndex = firstIndex;
            IndexCount = indexCount;
        }

        /// <summary>Index of a material of the face; -1: none.</summary>
        public readonly int Material;
        /// <summary>Of <see cref="RenderLevel.Indices"/>.</summary>
        public readonly int FirstIndex;
        /// <summary>Three a triangle.</summary>
        public readonly int IndexCount;
    }

    /// <summary>What of a <see cref="RenderMesh"/> is drawn at a level of detail.</summary>
    public sealed class RenderLevel
    {
        private readonly int[] indices;

        internal RenderLevel(int vertexCount, int bakedVertices, int[] indices, RenderPart[] parts)
        {
            VertexCount = vertexCount;
            BakedVertices = bakedVertices;
            this.indices = indices;
            Parts = Array.AsReadOnly(parts);
        }

        /// <summary>Its triangles have the first so many of the mesh's vertices.</summary>
        public int VertexCount { get; private set; }
        /// <summary>These are among the face's first so many in baked order.</summary>
        internal int BakedVertices { get; private set; }
        /// <summary>Vertices of triangles, in three each; there may be none.</summary>
        public ReadOnlySpan<int> Indices { get { return indices; } }
        /// <summary>The triangles by material: as many parts, of the same materials, at every level.</summary>
        public IReadOnlyList<RenderPart> Parts { get; private set; }
    }

    /// <summary>A mesh of a face as renderers take it, at every level of detail: triangles, and a vertex for each pair of
    /// position and texture coordinate that corners have. Vertices of coarse levels come first, so that one buffer serves all.
    /// Made once, immutable; poses are written by <see cref="Write"/>.</summary>
    public sealed unsafe class RenderMesh
    {
        private readonly int[] sources, bakedSources; // in the source's order, and in baked order
        private readonly float[] uvs, signs;

        /// <summary>The mesh at an index of <see cref="Face.Meshes"/>, in an engine's axes.</summary>
        /// <exception cref="ArgumentNullException">face is null.</exception>
        /// <exception cref="ArgumentOutOfRangeException">There is no such mesh.</exception>
        public RenderMesh(Face face, int mesh, AxisConversion axes)
        {
            if (face == null) throw new ArgumentNullException(nameof(face));
            if (mesh < 0 || mesh >= face.Meshes.Count) throw new ArgumentOutOfRangeException(nameof(mesh));
            Face = face;
            Axes = axes;
            Mesh = face.Meshes[mesh];
            var made = new Corners(face, Mesh, axes.LeftHanded);
            var levels = new RenderLevel[face.Levels.Count];
            for (int i = levels.Length; i-- > 0;) levels[i] = made.Add(face.Levels[i], mesh);
            Levels = Array.AsReadOnly(levels);
            sources = made.Sources.ToArray();
            bakedSources = made.BakedSources.ToArray();
            uvs = made.Uvs.ToArray();
            HasTangents = uvs.Length > 0;
            signs = new float[HasTangents ? sources.Length : 0];
            // Mirrored axes turn cross products round, and so the sign.
            for (int i = 0; i < signs.Length; ++i) signs[i] = face.TangentSigns[sources[i]] * (axes.LeftHanded ? -1 : 1);
        }

        /// <summary>The face.</summary>
        public Face Face { get; private set; }
        /// <summary>The mesh of the face.</summary>
        public FaceMesh Mesh { get; private set; }
        /// <summary>How axes and units are converted.</summary>
        public AxisConversion Axes { get; private set; }
        /// <summary>Vertices to render.</summary>
        public int VertexCount { get { return sources.Length; } }
        /// <summary>Tangents are written: the face has texture coordinates.</summary>
        public bool HasTangents { get; private set; }
        /// <summary>Floats of a vertex that <see cref="Write"/> writes: position 3, normal 3, and tangent 4 if there are
        /// any.</summary>
        public int VertexFloats { get { return HasTangents ? 10 : 6; } }
        /// <summary>The face's vertex that each vertex is.</summary>
        public ReadOnlySpan<int> Sources { get { return sources; } }
        /// <summary>Two floats a vertex; empty without texture coordinates.</summary>
        public ReadOnlySpan<float> Uvs { get { return uvs; } }
        /// <summary>What is drawn at each of <see cref="Face.Levels"/>.</summary>
        public IReadOnlyList<RenderLevel> Levels { get; private set; }
        /// <summary>Those of level 0.</summary>
        public ReadOnlySpan<int> Indices { get { return Levels[0].Indices; } }
        /// <summary>Those of level 0.</summary>
        public IReadOnlyList<RenderPart> Parts { get { return Levels[0].Parts; } }

        /// <summary>Writes posed vertices, interleaved: position, normal, tangent with its sign. positions, normals and
        /// tangents are of the whole face, as a batch gives them; tangents may be empty where there are none. bakedOrder:
        /// they are in baked order, and need not have others than those of the level. vertices: of those that a level draws, <see
        /// cref="RenderLevel.VertexCount"/> x <see cref="VertexFloats"/>. Allocates nothing.</summary>
        /// <exception cref="ArgumentException">A span is too short.</exception>
        /// <exception cref="ArgumentOutOfRangeException">There is no such level.</exception>
        public void Write(ReadOnlySpan<float> positions, ReadOnlySpan<float> normals, ReadOnlySpan<float> tangents,
                          Span<float> vertices, int level = 0, bool bakedOrder = false)
        {
            int count = Levels[level].VertexCount;
            int needed = 3 * (bakedOrder ? Levels[level].BakedVertices : Face.VertexCount);
            if (positions.Length < needed) throw new ArgumentException("Too few positions.", nameof(positions));
            if (normals.Length < needed) throw new ArgumentException("Too few normals.", nameof(normals));
            if (HasTangents && tangents.Length < needed) throw new ArgumentException("Too few tangents.", nameof(tangents));
            if (vertices.Length < count * VertexFloats)
                throw new ArgumentException("Too few vertices.", nameof(vertices));
            fixed (int* source = bakedOrder ? bakedSources : sources)
            fixed (float* sign = signs, position = &Reference(positions), normal = &Reference(normals),
                   tangent = &Reference(tangents), vertex = &Reference(vertices))
                WriteVertices(source, count, position, normal, HasTangents ? tangent : null, sign, Axes, vertex);
        }

        private static ref float Reference(ReadOnlySpan<float> span)
        {
            return ref System.Runtime.InteropServices.MemoryMarshal.GetReference(span);
        }

        /// <summary>The same on pointers alone, for jobs that Burst compiles. sources, signs: of each vertex; tangents: null
        /// for none.</summary>
        public static void WriteVertices(int* sources, int count, float* positions, float* normals, float* tangents,
                                         float* signs, AxisConversion axes, float* vertices)
        {
            for (int i = 0; i < count; ++i)
            {
                int from = 3 * sources[i];
                axes.Apply(positions + from, axes.Scale, vertices);
                axes.Apply(normals + from, 1, vertices + 3);
                vertices += 6;
                if (tangents == null) continue;
                axes.Apply(tangents + from, 1, vertices);
                vertices[3] = signs[i];
                vertices += 4;
            }
        }

        // Corners of polygons become vertices, level after level.
        private sealed class Corners
        {
            private readonly Face face;
            private readonly FaceMesh whole;
            private readonly bool turned;
            private readonly Dictionary<ulong, int> known = new Dictionary<ulong, int>();
            private readonly int[] baked; // of each of the face's vertices, where it is in baked order
            private int bakedVertices;
            public readonly List<int> Sources = new List<int>(), BakedSources = new List<int>();
            public readonly List<float> Uvs = new List<float>();

            public Corners(Face face, FaceMesh whole, bool turned)
            {
                this.face = face;
                this.whole = whole;
                this.turned = turned;
                baked = new int[face.VertexCount];
                ReadOnlySpan<uint> order = face.VertexOrder;
                for (int i = 0; i < baked.Length; ++i) baked[order.Length == 0 ? i : (int)order[i]] = i;
            }

            private int VertexOf(uint source, long uv)
            {
                ulong key = (ulong)source << 32 | (uint)uv;
                int vertex;
                if (known.TryGetValue(key, out vertex)) return vertex;
                vertex = Sources.Count;
                known.Add(key, vertex);
                Sources.Add((int)source);
                BakedSources.Add(baked[source]);
                bakedVertices = Math.Max(bakedVertices, baked[source] + 1);
                if (uv >= 0)
                {
                    Uvs.Add(face.Uvs[2 * (int)uv]);
                    Uvs.Add(face.Uvs[2 * (int)uv + 1]);
                }
                return vertex;
            }

            public RenderLevel Add(FaceLevel level, int meshIndex)
            {
                FaceMesh mesh = level.Meshes[meshIndex];
                var triangles = new List<int>[whole.Runs.Count];
                for (int i = 0; i < triangles.Length; ++i) triangles[i] = new List<int>();
                int polygon = mesh.FirstPolygon, corner = mesh.FirstCorner, next = 0;
                foreach (MaterialRun run in mesh.Runs)
                {
                    int part = PartOf(run.Material, next);
                    for (int end = polygon + run.PolygonCount; polygon < end; ++polygon)
                    {
                        int size = (int)level.PolygonSizes[polygon];
                        if (part >= 0) AddPolygon(level, corner, size, triangles[part]);
                        corner += size;
                    }
                    if (part >= 0) next = part + 1;
                }
                var indices = new List<int>();
                var parts = new RenderPart[triangles.Length];
                for (int i = 0; i < parts.Length; ++i)
                {
                    parts[i] = new RenderPart(whole.Runs[i].Material, indices.Count, triangles[i].Count);
                    indices.AddRange(triangles[i]);
                }
                return new RenderLevel(Sources.Count, bakedVertices, indices.ToArray(), parts);
            }

            // The run of the whole mesh that a level's run belongs to: the next one of its material, or else the first.
            private int PartOf(int material, int from)
            {
                int count = whole.Runs.Count;
                for (int i = 0; i < count; ++i)
                    if (whole.Runs[(from + i) % count].Material == material) return (from + i) % count;
                return -1;
            }

            // As a fan.
            private void AddPolygon(FaceLevel level, int corner, int size, List<int> triangles)
            {
                int first = VertexAt(level, corner), last = VertexAt(level, corner + 1);
                for (int i = 2; i < size; ++i)
                {
                    int other = VertexAt(level, corner + i);
                    triangles.Add(first);
                    triangles.Add(turned ? other : last);
                    triangles.Add(turned ? last : other);
                    last = other;
                }
            }

            private int VertexAt(FaceLevel level, int corner)
            {
                return VertexOf(level.PolygonCorners[corner], level.UvCorners.Length > 0 ? (long)level.UvCorners[corner] : -1);
            }
        }
    }
}
