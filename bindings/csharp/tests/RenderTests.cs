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
                        Same(face.Levels.Count, plain.Levels.Count, "levels");
                        Same(plain.VertexCount, plain.Levels[0].VertexCount, "vertices of the whole");
                        for (int i = 0; i < plain.Levels.Count; ++i)
                        {
                            RenderLevel level = plain.Levels[i], turned = unity.Levels[i];
                            FaceMesh mesh = face.Levels[i].Meshes[m];
                            That(i == 0 || level.VertexCount <= plain.Levels[i - 1].VertexCount, "coarser levels have less");
                            CheckParts(mesh, level, plain.Parts);
                            for (int k = 0; k < level.Indices.Length; k += 3)
                            {
                                Same(level.Indices[k], turned.Indices[k], "first corner");
                                Same(level.Indices[k + 1], turned.Indices[k + 2], "turned round");
                            }
                            CheckCorners(face, face.Levels[i], mesh, plain, level);
                        }
                        FaceMesh whole = face.Meshes[m];
                        foreach (int source in plain.Sources)
                            That(source >= whole.FirstVertex && source < whole.FirstVertex + whole.VertexCount,
                                "vertex of the mesh");
                    }
        }

        private static void CheckParts(FaceMesh mesh, RenderLevel level, IReadOnlyList<RenderPart> whole)
        {
            Same(3 * (mesh.CornerCount - 2 * mesh.PolygonCount), level.Indices.Length, "indices");
            Same(whole.Count, level.Parts.Count, "parts");
            int indices = 0;
            for (int i = 0; i < whole.Count; ++i)
            {
                Same(indices, level.Parts[i].FirstIndex, "first index");
                Same(whole[i].Material, level.Parts[i].Material, "material");
                indices += level.Parts[i].IndexCount;
            }
            Same(level.Indices.Length, indices, "indices of parts");
        }

        // The corners of the first triangle of every polygon.
        private static void CheckCorners(Face face, FaceLevel level, FaceMesh mesh, RenderMesh render, RenderLevel drawn)
        {
            int corner = mesh.FirstCorner, index = 0;
            for (int p = mesh.FirstPolygon; p < mesh.FirstPolygon + mesh.PolygonCount; ++p)
            {
                for (int i = 0; i < 3; ++i)
                {
                    int vertex = drawn.Indices[index + i];
                    That(vertex < drawn.VertexCount, "a vertex that is written");
                    Same((int)level.PolygonCorners[corner + i], render.Sources[vertex], "vertex of a corner");
                    if (level.UvCorners.Length == 0) continue;
                    int uv = (int)level.UvCorners[corner + i];
                    SameBits(face.Uvs.Slice(2 * uv, 2), render.Uvs.Slice(2 * vertex, 2), "texture coordinates");
                }
                corner += (int)level.PolygonSizes[p];
                index += 3 * ((int)level.PolygonSizes[p] - 2);
            }
        }

        // Poses of a level alone give the same vertices to draw.
        private static void CheckLevelOnly(FaceInstance instance, RenderMesh render)
        {
            for (int level = 0; level < render.Levels.Count; ++level)
            {
                float[] all = new float[render.Levels[level].VertexCount * render.VertexFloats], alone = new float[all.Length];
                instance.Lod = level;
                instance.LevelOnly = false;
                instance.Pose();
                instance.Write(render, all);
                Same(3 * render.Face.VertexCount, instance.Positions.Length, "coordinates of all vertices");
                instance.LevelOnly = true;
                That(instance.Pose(), "it is posed anew");
                instance.Write(render, alone);
                SameBits(all, alone, "vertices of level " + level);
                Same(3 * render.Face.Levels[level].VertexCount, instance.Normals.Length, "coordinates of the level");
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
                    instance.Lod = 1.5f;
                    instance.Pose();
                    Same(Math.Min(1, face.Levels.Count - 1), instance.Level, "level");
                    var few = new float[plain.Levels[instance.Level].VertexCount * plain.VertexFloats];
                    instance.Write(plain, few);
                    SameBits(instance.Positions.Slice(3 * plain.Sources[0], 3), new ReadOnlySpan<float>(few, 0, 3), "position");
                    CheckLevelOnly(instance, plain);
                    instance.LevelOnly = false;
                    instance.Lod = 0;
                    instance[0] = float.NaN;
                    Throws<FaceBakerException>(() => instance.Pose());
                    instance[0] = face.Controls[0].Rest;
                    That(instance.Pose(), "it goes on");
                }
        }
    }
}
