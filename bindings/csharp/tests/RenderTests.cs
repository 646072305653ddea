using System;
using System.Collections.Generic;
using static FaceBaker.Tests.CheckMain;

namespace FaceBaker.Tests
{
    internal static class RenderTests
    {
        public static void RenderMeshesHaveEveryPolygon()
        {
            foreach (KeyValuePair<string, DumpedPoses> pair in Dumped())
                using (Face face = Face.Load(pair.Key))
                    for (int m = 0; m < face.Meshes.Count; ++m)
                    {
                        var plain = new RenderMesh(face, m, AxisConversion.None);
                        var unity = new RenderMesh(face, m, AxisConversion.ToUnity(face));
                        FaceMesh mesh = face.Meshes[m];
                        int triangles = mesh.CornerCount - 2 * mesh.PolygonCount;
                        Same(3 * triangles, plain.Indices.Length, "indices");
                        int indices = 0;
                        foreach (RenderPart part in plain.Parts)
                        {
                            Same(indices, part.FirstIndex, "first index");
                            indices += part.IndexCount;
                        }
                        Same(plain.Indices.Length, indices, "indices of parts");
                        for (int i = 0; i < plain.Indices.Length; i += 3)
                        {
                            Same(plain.Indices[i], unity.Indices[i], "first corner");
                            Same(plain.Indices[i + 1], unity.Indices[i + 2], "turned round");
                        }
                        foreach (int source in plain.Sources)
                            That(source >= mesh.FirstVertex && source < mesh.FirstVertex + mesh.VertexCount,
                                "vertex of the mesh");
                        CheckCorners(face, mesh, plain);
                    }
        }

        // The corners of the first triangle of every polygon.
        private static void CheckCorners(Face face, FaceMesh mesh, RenderMesh render)
        {
            int corner = mesh.FirstCorner, index = 0;
            for (int p = mesh.FirstPolygon; p < mesh.FirstPolygon + mesh.PolygonCount; ++p)
            {
                for (int i = 0; i < 3; ++i)
                {
                    int vertex = render.Indices[index + i];
                    Same((int)face.PolygonCorners[corner + i], render.Sources[vertex], "vertex of a corner");
                    if (face.UvCorners.Length == 0) continue;
                    int uv = (int)face.UvCorners[corner + i];
                    SameBits(face.Uvs.Slice(2 * uv, 2), render.Uvs.Slice(2 * vertex, 2), "texture coordinates");
                }
                corner += (int)face.PolygonSizes[p];
                index += 3 * ((int)face.PolygonSizes[p] - 2);
            }
        }

        public static void FramesAreConvertedAsPositionsAre()
        {
            // A frame takes (1, 2, 3) somewhere; converted, it takes what (1, 2, 3) becomes to what that becomes.
            float[] frame = { 0, -1, 0, 4, 1, 0, 0, 5, 0, 0, 1, 6 };
            float[] moved = { -2 + 4, 1 + 5, 3 + 6 };
            foreach (AxisConversion axes in new[] { AxisConversion.None, AxisConversion.ToUnity("y", "cm"),
                                                    AxisConversion.ToUnity("z", "mm"), AxisConversion.ToUnity("z", "m") })
            {
                float[] converted = new float[12], at = Converted(axes, 1, 2, 3), expected = new float[3];
                axes.ApplyFrame(frame, converted);
                for (int row = 0; row < 3; ++row)
                    for (int k = 0; k < 4; ++k) expected[row] += converted[4 * row + k] * (k < 3 ? at[k] : 1);
                float[] wanted = Converted(axes, moved[0], moved[1], moved[2]);
                for (int k = 0; k < 3; ++k) That(Math.Abs(expected[k] - wanted[k]) < 1e-5, "axis " + k);
            }
            float[] up = Converted(AxisConversion.ToUnity("z", "cm"), 0, 0, 1);
            That(up[0] == 0 && up[1] == 0.01f && up[2] == 0, "z up becomes y up, in metres");
            up = Converted(AxisConversion.ToUnity("y", "m"), 1, 2, 3);
            That(up[0] == -1 && up[1] == 2 && up[2] == 3, "x is negated");
        }

        private static float[] Converted(AxisConversion axes, float x, float y, float z)
        {
            var box = new float[6];
            axes.ApplyBounds(new[] { x, y, z, x, y, z }, box);
            return new[] { box[0], box[1], box[2] };
        }

        public static void AnInstancePosesAndWritesVertices()
        {
            foreach (KeyValuePair<string, DumpedPoses> pair in Dumped())
                using (Face face = Face.Load(pair.Key))
                {
                    var instance = new FaceInstance(face);
                    That(instance.Pose(), "the first pose");
                    That(!instance.Pose(), "nothing was set");
                    SameBits(face.RestPositions, instance.Positions, "rest");
                    for (int p = 0; p < pair.Value.Poses; ++p)
                    {
                        instance.SetControls(pair.Value.ControlsOf(p));
                        instance.Pose();
                        SameBits(pair.Value.PositionsOf(p), instance.Positions, "positions");
                        SameBits(pair.Value.TangentsOf(p), instance.Tangents, "tangents");
                        SameBits(pair.Value.SocketsOf(p), instance.Sockets, "sockets");
                    }
                    var plain = new RenderMesh(face, 0, AxisConversion.None);
                    var unity = new RenderMesh(face, 0, AxisConversion.ToUnity(face));
                    float[] one = new float[plain.VertexCount * plain.VertexFloats], two = new float[one.Length];
                    instance.Write(plain, one);
                    instance.Write(unity, two);
                    float scale = AxisConversion.MetresPer(face.Units);
                    bool zUp = face.UpAxis == "z";
                    for (int v = 0; v < plain.VertexCount; ++v)
                    {
                        int at = v * plain.VertexFloats;
                        SameBits(instance.Positions.Slice(3 * plain.Sources[v], 3), new ReadOnlySpan<float>(one, at, 3),
                            "position");
                        Same(-(one[at] * scale), two[at], "x");
                        Same((zUp ? one[at + 2] : one[at + 1]) * scale, two[at + 1], "y");
                        Same(one[at + 3], -two[at + 3], "x of the normal");
                        if (plain.HasTangents) Same(one[at + 9], -two[at + 9], "sign");
                    }
                    Throws<ArgumentException>(() => instance.Write(plain, new float[one.Length - 1]));
                    Throws<ArgumentException>(() => instance.SetControls(new float[face.ControlCount + 1]));
                    instance[0] = float.NaN;
                    Throws<FaceBakerException>(() => instance.Pose());
                    instance[0] = face.Controls[0].Rest;
                    That(instance.Pose(), "it goes on");
                }
        }
    }
}
