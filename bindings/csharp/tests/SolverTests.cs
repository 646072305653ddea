using System;
using System.Collections.Generic;
using System.Threading;
using static FaceBaker.Tests.CheckMain;

namespace FaceBaker.Tests
{
    /// <summary>Derivatives and solving through the C# interface.</summary>
    internal static class SolverTests
    {
        // So far from rest to the maximum of every control.
        private static float[] PoseOf(Face face, float share)
        {
            var pose = new float[face.ControlCount];
            foreach (Control control in face.Controls)
                pose[control.Index] = control.Rest + share * (control.Maximum - control.Rest);
            return pose;
        }

        private static float[] PositionsOf(Face face, float[] pose)
        {
            var positions = new float[3 * face.VertexCount];
            face.Evaluate(pose, positions);
            return positions;
        }

        private static void Near(float expected, float found, double within, string what)
        {
            That(Math.Abs(expected - found) <= within, what + " is " + found + ", not near " + expected);
        }

        public static void DerivativesAreDifferencesOfPoses()
        {
            using (Face face = Face.Load(Fixture("tiny.fbk")))
            using (var solver = new Solver(face))
            {
                Same(face.VertexCount, solver.PointCount, "points");
                Same(3 * face.VertexCount, solver.RowCount, "rows");
                int controls = face.ControlCount;
                float[] pose = PoseOf(face, 0.4f), values = new float[solver.RowCount],
                    derivatives = new float[solver.RowCount * controls], before = PositionsOf(face, pose);
                solver.Jacobian(new PoseJacobian(pose) { Values = values, Derivatives = derivatives });
                foreach (Control control in face.Controls)
                {
                    float step = 2e-3f * (control.Maximum - control.Minimum);
                    var moved = (float[])pose.Clone();
                    moved[control.Index] += step;
                    float[] after = PositionsOf(face, moved);
                    for (int row = 0; row < values.Length; ++row)
                        Near((after[row] - before[row]) / step, derivatives[row * controls + control.Index], 0.02 * face.Diagonal,
                             "a derivative by " + control.Name);
                }
                for (int row = 0; row < values.Length; ++row) Near(before[row], values[row], 1e-5, "a coordinate");
            }
        }

        public static void SparseColumnsHoldWhatDenseOnesDo()
        {
            using (Face face = Face.Load(Fixture("driven.fbk")))
            {
                var sockets = new uint[face.Sockets.Count];
                var joints = new uint[face.DrivenJoints.Count];
                for (uint i = 0; i < sockets.Length; ++i) sockets[i] = i;
                for (uint i = 0; i < joints.Length; ++i) joints[i] = i;
                var options = new SolverOptions
                {
                    PointVertices = new uint[] { 3, 7, 11, 20, 20, 0 }, PointWeights = new[] { 0.5f, 0.25f, 0.25f, 1, 0, 0 },
                    Pairs = new uint[] { 0, 1 }, Sockets = sockets, Joints = joints
                };
                using (var solver = new Solver(face, options))
                {
                    Same(2, solver.PointCount, "points");
                    Same(1, solver.PairCount, "pairs");
                    Same(sockets.Length + joints.Length, solver.FrameCount, "frames");
                    Same(6 + 12 * solver.FrameCount, solver.RowCount, "rows");
                    float[] pose = PoseOf(face, 0.4f), dense = new float[3 * solver.RowCount];
                    var chosen = new uint[] { 0, 2, 3 };
                    var starts = new ulong[4];
                    solver.Jacobian(new PoseJacobian(pose) { Chosen = chosen, Derivatives = dense, ColumnStarts = starts });
                    int count = (int)starts[3];
                    That(count > 3 && count <= dense.Length, count + " entries");
                    var small = new uint[count - 1];
                    Same(Status.Limit, Throws<FaceBakerException>(() => solver.Jacobian(new PoseJacobian(pose) {
                        Chosen = chosen, ColumnStarts = starts, ColumnRows = small, ColumnValues = new float[count - 1]
                    })).Status, "too small");
                    var rows = new uint[count];
                    var values = new float[count];
                    solver.Jacobian(new PoseJacobian(pose) {
                        Chosen = chosen, ColumnStarts = starts, ColumnRows = rows, ColumnValues = values });
                    var again = new float[dense.Length];
                    for (int c = 0; c < 3; ++c)
                        for (ulong e = starts[c]; e < starts[c + 1]; ++e) again[rows[e] * 3 + c] = values[e];
                    SameBits(dense, again, "derivatives");
                }
            }
        }

        public static void APoseIsFoundAgain()
        {
            using (Face face = Face.Load(Fixture("tiny.fbk")))
            using (var solver = new Solver(face))
            {
                float[] targets = PositionsOf(face, PoseOf(face, 0.3f)), found = PoseOf(face, 0.25f),
                    decided = new float[face.ControlCount], differences = new float[face.VertexCount];
                targets[7] = float.NaN; // not measured
                SolveResult result = solver.Solve(new SolveTargets(found)
                {
                    Points = targets, Noise = (float)(1e-4 * face.Diagonal), Nearness = 0, Sparsity = 0, MaxIterations = 50,
                    Decided = decided, PointDifferences = differences
                });
                That(result.Converged && result.Iterations > 0, "it converges");
                Same(face.VertexCount - 1, result.PointCount, "points with targets");
                That(result.MaxDifference < 5e-3 * face.Diagonal, "it comes near: " + result.MaxDifference);
                That(result.RmsDifference <= result.MaxDifference, "the mean is not the largest");
                Same(result.MaxDifference, differences[result.WorstPoint], "the worst point");
                That(float.IsNaN(differences[2]), "no difference without a target");
                float[] there = PositionsOf(face, found);
                for (int i = 0; i < there.Length; ++i)
                    if (i / 3 != 2) Near(targets[i], there[i], 5e-3 * face.Diagonal, "a coordinate");
                foreach (float share in decided) That(share >= 0 && share <= 1, "a share of " + share);
                SolveResult nothing = solver.Solve(new SolveTargets(found));
                Same(-1, nothing.WorstPoint, "no worst point");
                Same(0, nothing.PointCount, "no targets");
            }
        }

        public static void ControlsThatMayNotMoveStay()
        {
            using (Face face = Face.Load(Fixture("tiny.fbk")))
            using (var solver = new Solver(face))
            {
                int brow = face.FindControl("brow_raise"), lid = face.FindControl("lid_close");
                bool[] movable = ControlSearch.MaskWithout(face, "brow", "lid_close");
                bool[] named = ControlSearch.MaskOf(face, "brow", "lid_close");
                for (int i = 0; i < movable.Length; ++i)
                {
                    Same(i != brow && i != lid, movable[i], "movable");
                    Same(!movable[i], named[i], "the other way round");
                }
                That(Throws<FaceBakerException>(() => ControlSearch.MaskOf(face, "jaw_opem")).Message.Contains("jaw_open"),
                     "the closest name");
                float[] start = PoseOf(face, 0.25f), found = PoseOf(face, 0.25f), targets = PositionsOf(face, PoseOf(face, 0.4f));
                solver.Solve(new SolveTargets(found) { Points = targets, Movable = movable });
                for (int i = 0; i < found.Length; ++i)
                    Same(movable[i], found[i] != start[i], face.Controls[i].Name + " moves");
            }
        }

        public static void TargetsComeFromTheAxesOfAnEngine()
        {
            using (Face face = Face.Load(Fixture("tiny.fbk")))
            using (var solver = new Solver(face))
                foreach (string up in new[] { "y", "z" })
                {
                    AxisConversion axes = AxisConversion.ToUnity(up, "cm");
                    float[] pose = PoseOf(face, 0.25f), targets = PositionsOf(face, pose);
                    var toFace = new float[12];
                    axes.WriteInverse(toFace);
                    var box = new float[6];
                    for (int v = 0; v < face.VertexCount; ++v)
                    {
                        var point = new[] { targets[3 * v], targets[3 * v + 1], targets[3 * v + 2], 0, 0, 0 };
                        Array.Copy(point, 0, point, 3, 3);
                        axes.ApplyBounds(point, box);
                        // The engine's head has moved.
                        for (int i = 0; i < 3; ++i) targets[3 * v + i] = box[i] + (i == 1 ? 0.02f : 0);
                    }
                    var motion = new float[12];
                    SolveResult result = solver.Solve(new SolveTargets(pose)
                    {
                        Points = targets, ToFace = toFace, FindMotion = true, Motion = motion,
                        Noise = (float)(1e-4 * face.Diagonal), Nearness = 0, Sparsity = 0
                    });
                    That(result.MaxDifference < 5e-3 * face.Diagonal, "it comes near: " + result.MaxDifference);
                    // 2 cm upwards.
                    Near(0, motion[3], 0.02, "x");
                    Near(up == "y" ? 2 : 0, motion[7], 0.02, "y");
                    Near(up == "z" ? 2 : 0, motion[11], 0.02, "z");
                }
        }

        public static void WhatIsWrongIsNamed()
        {
            using (Face face = Face.Load(Fixture("tiny.fbk")))
            using (var solver = new Solver(face))
            {
                float[] targets = face.RestPositions.ToArray(), found = PoseOf(face, 0.2f), kept = PoseOf(face, 0.2f),
                    shorter = new float[4];
                targets[4] = float.PositiveInfinity;
                var exception = Throws<FaceBakerException>(() => solver.Solve(new SolveTargets(found) { Points = targets }));
                Same(Status.NotFinite, exception.Status, "infinite");
                That(exception.Message.Contains("point 1"), exception.Message);
                targets[4] = 0;
                exception = Throws<FaceBakerException>(
                    () => solver.Solve(new SolveTargets(found) { Points = targets, Sparsity = -1 }));
                That(exception.Message.Contains("sparsity"), exception.Message);
                foreach (Action call in new Action[] {
                    () => solver.Solve(new SolveTargets(shorter)),
                    () => solver.Solve(new SolveTargets(found) { Points = shorter }),
                    () => solver.Solve(new SolveTargets(found) { Distances = shorter }),
                    () => solver.Solve(new SolveTargets(found) { Motion = new float[12] }),
                    () => solver.Solve(new SolveTargets(found) { FindMotion = true }),
                    () => solver.Solve(new SolveTargets(found) { MaxIterations = -1 }),
                    () => solver.Jacobian(new PoseJacobian(shorter)),
                    () => solver.Jacobian(new PoseJacobian(found) { Downwards = new bool[4] }),
                    () => solver.Jacobian(new PoseJacobian(found) { ColumnStarts = new ulong[5] }),
                    () => solver.Jacobian(new PoseJacobian(found) { ColumnRows = new uint[5] }),
                    () => new Solver(face, new SolverOptions { PointVertices = new uint[4] }),
                    () => new Solver(face, new SolverOptions { PointWeights = new float[3] }),
                    () => new Solver(null) })
                    Throws<ArgumentException>(call);
                foreach (var wrong in new Dictionary<string, SolverOptions> {
                    { "vertex 30", new SolverOptions { PointVertices = new uint[] { 30, 0, 0 } } },
                    { "pair 0", new SolverOptions { Pairs = new uint[] { 0, 30 } } },
                    { "socket 9", new SolverOptions { Sockets = new uint[] { 9 } } } })
                {
                    exception = Throws<FaceBakerException>(() => new Solver(face, wrong.Value));
                    That(exception.Message.Contains(wrong.Key), exception.Message);
                }
                Throws<FaceBakerException>(() => solver.Jacobian(new PoseJacobian(found) { Chosen = new uint[] { 2, 1 } }));
                Throws<FaceBakerException>(() => solver.Jacobian(new PoseJacobian(found) { Derivatives = new float[5] }));
                SameBits(kept, found, "controls");
                using (var none = new Solver(face, new SolverOptions { PointVertices = new uint[0] }))
                    Same(0, none.RowCount, "rows of no points");
            }
        }

        public static void ASolverOutlivesItsFace()
        {
            Face face = Face.Load(Fixture("tiny.fbk"));
            float[] targets = PositionsOf(face, PoseOf(face, 0.3f)), found = PoseOf(face, 0), again = PoseOf(face, 0);
            var solver = new Solver(face);
            solver.Solve(new SolveTargets(found) { Points = targets });
            face.Dispose();
            solver.Solve(new SolveTargets(again) { Points = targets });
            SameBits(found, again, "controls");
            Throws<ObjectDisposedException>(() => new Solver(face));
            solver.Dispose();
            solver.Dispose();
            Throws<ObjectDisposedException>(() => solver.Solve(new SolveTargets(again) { Points = targets }));
            Throws<ObjectDisposedException>(() => solver.Jacobian(new PoseJacobian(again)));
        }

        public static void EachThreadHasASolver()
        {
            using (Face face = Face.Load(Fixture("character.fbk")))
            {
                var failures = new List<string>();
                var threads = new Thread[3];
                for (int t = 0; t < threads.Length; ++t)
                {
                    float[] targets = PositionsOf(face, PoseOf(face, 0.1f * (t + 1))), expected = PoseOf(face, 0);
                    using (var alone = new Solver(face)) alone.Solve(new SolveTargets(expected) { Points = targets });
                    threads[t] = new Thread(() =>
                    {
                        using (var solver = new Solver(face))
                            for (int i = 0; i < 50; ++i)
                            {
                                float[] found = PoseOf(face, 0);
                                solver.Solve(new SolveTargets(found) { Points = targets });
                                if (found.AsSpan().SequenceEqual(expected)) continue;
                                lock (failures) failures.Add("round " + i);
                            }
                    });
                }
                foreach (Thread thread in threads) thread.Start();
                foreach (Thread thread in threads) thread.Join();
                That(failures.Count == 0, string.Join(", ", failures));
            }
        }
    }
}
