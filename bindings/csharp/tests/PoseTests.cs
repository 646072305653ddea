using System;
using System.Collections.Generic;
using System.Threading;
using static FaceBaker.Tests.CheckMain;

namespace FaceBaker.Tests
{
    internal static class PoseTests
    {
        public static void PosesHaveTheBitsOfTheCInterface()
        {
            bool several = false;
            foreach (KeyValuePair<string, DumpedPoses> pair in Dumped())
                using (Face face = Face.Load(pair.Key))
                using (var scratch = new Scratch(face))
                {
                    DumpedPoses expected = pair.Value;
                    var positions = new float[3 * face.VertexCount];
                    for (int p = 0; p < expected.Poses; ++p)
                    {
                        scratch.Evaluate(expected.ControlsOf(p), positions);
                        SameBits(expected.PositionsOf(p), positions, pair.Key);
                        Array.Clear(positions, 0, positions.Length);
                        face.Evaluate(expected.ControlsOf(p), positions);
                        SameBits(expected.PositionsOf(p), positions, pair.Key);
                    }
                    several |= face.Meshes.Count > 1;
                }
            That(several, "one of the faces has several meshes");
        }

        public static void AllOutputsHaveTheBitsOfTheCInterface()
        {
            bool tangents = false, sockets = false, driven = false;
            foreach (KeyValuePair<string, DumpedPoses> pair in Dumped())
                using (Face face = Face.Load(pair.Key))
                {
                    DumpedPoses expected = pair.Value;
                    var positions = new float[3 * face.VertexCount];
                    var normals = new float[positions.Length];
                    var tangent = new float[positions.Length * expected.Tangents];
                    var socket = new float[expected.Sockets];
                    var channels = new float[expected.Channels];
                    var joints = new float[expected.Joints];
                    for (int p = 0; p < expected.Poses; ++p)
                    {
                        face.EvaluateBatch(new PoseBatch(1, expected.ControlsOf(p)) {
                            Positions = positions, Normals = normals, Tangents = tangent, Sockets = socket,
                                Channels = channels, Joints = joints });
                        SameBits(expected.PositionsOf(p), positions, pair.Key + " positions");
                        SameBits(expected.NormalsOf(p), normals, pair.Key + " normals");
                        SameBits(expected.TangentsOf(p), tangent, pair.Key + " tangents");
                        SameBits(expected.SocketsOf(p), socket, pair.Key + " sockets");
                        SameBits(expected.ChannelsOf(p), channels, pair.Key + " channels");
                        SameBits(expected.JointsOf(p), joints, pair.Key + " driven joints");
                    }
                    tangents |= tangent.Length > 0;
                    sockets |= socket.Length > 0;
                    driven |= joints.Length > 0;
                }
            That(tangents && sockets && driven, "there were tangents, sockets and driven joints");
        }

        public static void DrivenJointsTakeVerticesWhereTheyAre()
        {
            int faces = 0;
            foreach (KeyValuePair<string, DumpedPoses> pair in Dumped())
                using (Face face = Face.Load(pair.Key))
                {
                    if (face.DrivenJoints.Count == 0) continue;
                    ++faces;
                    float[] before = new float[3 * face.VertexCount], joints = new float[12 * face.DrivenJoints.Count];
                    double farthest = 0;
                    for (int p = 0; p < pair.Value.Poses; ++p)
                    {
                        face.EvaluateBatch(new PoseBatch(1, pair.Value.ControlsOf(p)) {
                            Positions = before, Joints = joints, Unskinned = true });
                        ReadOnlySpan<float> after = pair.Value.PositionsOf(p);
                        for (int v = 0; v < face.VertexCount; ++v)
                        {
                            double[] skinned = SkinnedByHand(face, v, before, joints);
                            for (int k = 0; k < 3; ++k)
                            {
                                That(Math.Abs(skinned[k] - after[3 * v + k]) < 1e-4 * face.Diagonal,
                                     "vertex " + v + " of " + pair.Key + " is " + skinned[k] + " and not " + after[3 * v + k]);
                                farthest = Math.Max(farthest, Math.Abs(before[3 * v + k] - after[3 * v + k]));
                            }
                        }
                    }
                    That(farthest > 0.01 * face.Diagonal, "joints move vertices");
                }
            That(faces >= 2, faces + " faces have driven joints");
        }

        // p + the sum of weight x (frame x (inverse of rest) x p - p); axes of these faces are orthogonal and of length 1.
        private static double[] SkinnedByHand(Face face, int vertex, float[] positions, float[] frames)
        {
            var skinned = new double[] { positions[3 * vertex], positions[3 * vertex + 1], positions[3 * vertex + 2] };
            for (int i = vertex * face.DrivenInfluences; i < (vertex + 1) * face.DrivenInfluences; ++i)
            {
                int joint = face.DrivenSkinJoints[i];
                IReadOnlyList<float> rest = face.DrivenJoints[joint].Rest;
                var local = new double[3];
                for (int axis = 0; axis < 3; ++axis)
                    for (int row = 0; row < 3; ++row)
                        local[axis] += rest[4 * row + axis] * ((double)positions[3 * vertex + row] - rest[4 * row + 3]);
                for (int row = 0; row < 3; ++row)
                {
                    double at = frames[12 * joint + 4 * row + 3];
                    for (int axis = 0; axis < 3; ++axis) at += frames[12 * joint + 4 * row + axis] * local[axis];
                    skinned[row] += face.DrivenSkinWeights[i] * (at - positions[3 * vertex + row]);
                }
            }
            return skinned;
        }

        public static void ThreadsShareAFace()
        {
            foreach (KeyValuePair<string, DumpedPoses> pair in Dumped())
                using (Face face = Face.Load(pair.Key))
                {
                    Exception failure = null;
                    var threads = new Thread[6];
                    for (int t = 0; t < threads.Length; ++t)
                    {
                        bool own = t % 2 == 0; // with a scratch of its own, or the face's
                        threads[t] = new Thread(() =>
                        {
                            try
                            {
                                PoseAll(face, pair.Value, own);
                            }
                            catch (Exception exception)
                            {
                                failure = exception;
                            }
                        });
                        threads[t].Start();
                    }
                    foreach (Thread thread in threads) thread.Join();
                    That(failure == null, "" + failure);
                }
        }

        private static void PoseAll(Face face, DumpedPoses expected, bool own)
        {
            var positions = new float[3 * face.VertexCount];
            using (Scratch scratch = own ? new Scratch(face) : null)
                for (int round = 0; round < 20; ++round)
                    for (int p = 0; p < expected.Poses; ++p)
                    {
                        if (own) scratch.Evaluate(expected.ControlsOf(p), positions);
                        else face.Evaluate(expected.ControlsOf(p), positions);
                        SameBits(expected.PositionsOf(p), positions, "positions");
                    }
        }

        public static void WrongBuffersAndNumbersAreRefused()
        {
            using (Face face = Face.Load(Fixture("tiny.fbk")))
            using (var scratch = new Scratch(face))
            {
                var controls = face.RestControls.ToArray();
                var positions = new float[3 * face.VertexCount];
                Throws<ArgumentException>(() => scratch.Evaluate(new float[controls.Length + 1], positions));
                Throws<ArgumentException>(() => scratch.Evaluate(controls, new float[positions.Length - 1]));
                Throws<ArgumentException>(() => scratch.EvaluateCoefficients(controls, new float[face.CoefficientCount + 1]));
                controls[1] = float.NaN;
                var exception = Throws<FaceBakerException>(() => scratch.Evaluate(controls, positions));
                Same(Status.NotFinite, exception.Status, "status");
                That(exception.Message.Contains(face.Controls[1].Name), exception.Message);
                controls[1] = float.PositiveInfinity;
                scratch.Evaluate(controls, positions);
                Same(1L, scratch.ClampedCount, "clamped values");
                controls[1] = face.Controls[1].Maximum;
                var clamped = (float[])positions.Clone();
                scratch.Evaluate(controls, positions);
                SameBits(clamped, positions, "clamped");
                Throws<ArgumentOutOfRangeException>(() => new Scratch(face, 0));
                Throws<ArgumentNullException>(() => new Scratch(null));
            }
        }

        public static void TheBasisGivesDisplacements()
        {
            foreach (string name in new[] { "tiny.fbk", "character.fbk", "driven.fbk" })
                using (Face face = Face.Load(Fixture(name)))
                using (var scratch = new Scratch(face))
                {
                    float[] coefficients = new float[face.CoefficientCount], rows = new float[3 * face.VertexCount];
                    float[] positions = new float[rows.Length], controls = Widest(face);
                    scratch.EvaluateCoefficients(controls, coefficients);
                    scratch.EvaluateBatch(new PoseBatch(1, controls) { Positions = positions, BakedOrder = true,
                        Displacements = true });
                    int row = 0;
                    foreach (RowBlock block in face.RowBlocks)
                    {
                        Same(row, block.FirstRow, "first row");
                        for (int c = 0; c < block.Columns.Length; ++c)
                            for (int r = 0; r < block.RowCount; ++r)
                                rows[row + r] += coefficients[block.Columns[c]] * block.Values[c * block.RowCount + r];
                        row += block.RowCount;
                    }
                    Same(rows.Length, row, "rows");
                    for (int i = 0; i < row; ++i)
                        That(Math.Abs(rows[i] - positions[i]) < 1e-3 * face.Diagonal, "displacement " + i + " of " + name);
                }
        }

        public static void CoefficientsAndExpectedErrors()
        {
            using (Face face = Face.Load(Fixture("tiny.fbk")))
            using (var scratch = new Scratch(face))
            {
                var coefficients = new float[face.CoefficientCount];
                scratch.EvaluateCoefficients(face.RestControls, coefficients);
                That(Array.TrueForAll(coefficients, value => value == 0), "coefficients are 0 at rest");
                scratch.EvaluateCoefficients(Widest(face), coefficients);
                That(!Array.TrueForAll(coefficients, value => value == 0), "coefficients are not 0 elsewhere");
                if (face.ErrorRegions.Count == 0)
                    Throws<FaceBakerException>(() => scratch.ExpectedError(face.RestControls, new float[1]));
            }
            bool found = false;
            foreach (string file in Golden("accepted"))
                using (Face face = Face.Load(file))
                {
                    if (face.ErrorRegions.Count == 0) continue;
                    found = true;
                    using (var scratch = new Scratch(face))
                    {
                        var errors = new float[1 + face.ErrorRegions.Count];
                        scratch.ExpectedError(Widest(face), errors);
                        That(errors[0] > 0, "an error");
                        Same(face.VertexCount, face.ErrorVertexRegions.Length, "regions of vertices");
                    }
                }
            That(found, "a face with expected errors");
        }
    }
}
