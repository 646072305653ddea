using System;
using System.Collections.Generic;

namespace FaceBaker
{
    /// <summary>Consecutive triangles of a <see cref="RenderMesh"/> that have one material.</summary>
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
        /// <summary>Of <see cref="RenderMesh.Indices"/>.</summary>
        public readonly int FirstIndex;
        /// <summary>Three a triangle.</summary>
        public readonly int IndexCount;
    }

    /// <summary>A mesh of a face as renderers take it: triangles, and a vertex for each pair of position and texture coordinate
    /// that corners have. Made once, immutable; poses are written by <see cref="Write"/>.</summary>
    public sealed unsafe class RenderMesh
    {
        private readonly int[] sources, indices;
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
            var made = new Corners(face, Mesh);
            indices = made.Triangles(axes.LeftHanded, out IReadOnlyList<RenderPart> parts);
            Parts = parts;
            sources = made.Sources.ToArray();
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
        /// <summary>Vertices of triangles, in three each.</summary>
        public ReadOnlySpan<int> Indices { get { return indices; } }
        /// <summary>The triangles by material.</summary>
        public IReadOnlyList<RenderPart> Parts { get; private set; }

        /// <summary>Writes posed vertices, interleaved: position, normal, tangent with its sign. positions, normals and
        /// tangents are of the whole face, as a batch gives them; tangents may be empty where there are none. vertices: <see
        /// cref="VertexCount"/> x <see cref="VertexFloats"/>. Allocates nothing.</summary>
        /// <exception cref="ArgumentException">A span is too short.</exception>
        public void Write(ReadOnlySpan<float> positions, ReadOnlySpan<float> normals, ReadOnlySpan<float> tangents,
                          Span<float> vertices)
        {
            int needed = 3 * Face.VertexCount;
            if (positions.Length < needed) throw new ArgumentException("Too few positions.", nameof(positions));
            if (normals.Length < needed) throw new ArgumentException("Too few normals.", nameof(normals));
            if (HasTangents && tangents.Length < needed) throw new ArgumentException("Too few tangents.", nameof(tangents));
            if (vertices.Length < VertexCount * VertexFloats)
                throw new ArgumentException("Too few vertices.", nameof(vertices));
            fixed (int* source = sources)
            fixed (float* sign = signs, position = &Reference(positions), normal = &Reference(normals),
                   tangent = &Reference(tangents), vertex = &Reference(vertices))
                WriteVertices(source, VertexCount, position, normal, HasTangents ? tangent : null, sign, Axes, vertex);
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

        // Corners of polygons become vertices.
        private sealed class Corners
        {
            private readonly Face face;
            private readonly FaceMesh mesh;
            private readonly Dictionary<ulong, int> known = new Dictionary<ulong, int>();
            private readonly List<int> vertices = new List<int>(); // of each corner
            public readonly List<int> Sources = new List<int>();
            public readonly List<float> Uvs = new List<float>();

            public Corners(Face face, FaceMesh mesh)
            {
                this.face = face;
                this.mesh = mesh;
                ReadOnlySpan<uint> corners = face.PolygonCorners, uvCorners = face.UvCorners;
                for (int i = mesh.FirstCorner; i < mesh.FirstCorner + mesh.CornerCount; ++i)
                    vertices.Add(VertexOf(corners[i], uvCorners.Length > 0 ? (long)uvCorners[i] : -1));
            }

            private int VertexOf(uint source, long uv)
            {
                ulong key = (ulong)source << 32 | (uint)uv;
                int vertex;
                if (known.TryGetValue(key, out vertex)) return vertex;
                vertex = Sources.Count;
                known.Add(key, vertex);
                Sources.Add((int)source);
                if (uv >= 0)
                {
                    Uvs.Add(face.Uvs[2 * (int)uv]);
                    Uvs.Add(face.Uvs[2 * (int)uv + 1]);
                }
                return vertex;
            }

            // Polygons as fans.
            public int[] Triangles(bool turned, out IReadOnlyList<RenderPart> parts)
            {
                var triangles = new List<int>();
                var made = new List<RenderPart>();
                int polygon = mesh.FirstPolygon, corner = 0;
                foreach (MaterialRun run in mesh.Runs)
                {
                    int first = triangles.Count;
                    for (int end = polygon + run.PolygonCount; polygon < end; ++polygon)
                    {
                        int size = (int)face.PolygonSizes[polygon];
                        for (int i = 2; i < size; ++i)
                        {
                            triangles.Add(vertices[corner]);
                            triangles.Add(vertices[corner + (turned ? i : i - 1)]);
                            triangles.Add(vertices[corner + (turned ? i - 1 : i)]);
                        }
                        corner += size;
                    }
                    made.Add(new RenderPart(run.Material, first, triangles.Count - first));
                }
                parts = made.AsReadOnly();
                return triangles.ToArray();
            }
        }
    }
}
