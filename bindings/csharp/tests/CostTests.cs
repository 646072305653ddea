using System;
using System.Diagnostics;
using System.Runtime.InteropServices;
using System.Text;
using static FaceBaker.Tests.CheckMain;

namespace FaceBaker.Tests
{
    /// <summary>What a pose costs beyond the C call: no garbage, and less than a microsecond.</summary>
    internal static class CostTests
    {
        [DllImport("timecalls", CallingConvention = CallingConvention.Cdecl)]
        private static extern double time_evaluate(byte[] path, uint calls);

        private static long AllocatedBy(Action action, out int collections)
        {
            action(); // what is made once: code, delegates, scratches
            action();
            int before = GC.CollectionCount(0);
            long allocated = GC.GetAllocatedBytesForCurrentThread();
            action();
            allocated = GC.GetAllocatedBytesForCurrentThread() - allocated;
            collections = GC.CollectionCount(0) - before;
            return allocated;
        }

        public static void NothingIsAllocated()
        {
            using (Face face = Face.Load(Fixture("driven.fbk")))
            using (var scratch = new Scratch(face, 2))
            using (var turns = new ParallelForHandle(new OneByOne()))
            using (var crowd = new Crowd(new[] { face, face, face }, 2))
            {
                const int poses = 1000, batch = 32;
                var instance = new FaceInstance(face);
                crowd.SetNormals(1, true);
                float[] controls = Widest(face), positions = new float[3 * face.VertexCount],
                    normals = new float[positions.Length];
                float[] batchControls = new float[batch * face.ControlCount],
                    batchPositions = new float[batch * positions.Length];
                float[] sockets = new float[12 * face.Sockets.Count], coefficients = new float[face.CoefficientCount];
                var joints = new float[12 * face.DrivenJoints.Count];
                var mesh = new RenderMesh(face, 0, AxisConversion.ToUnity(face));
                var vertices = new float[mesh.VertexCount * mesh.VertexFloats];
                Action everything = () =>
                {
                    for (int i = 0; i < poses; ++i)
                    {
                        controls[0] = i * 0.001f;
                        scratch.Evaluate(controls, positions);
                        face.Evaluate(controls, positions);
                        scratch.EvaluateCoefficients(controls, coefficients);
                        scratch.EvaluateBatch(new PoseBatch(1, controls) { Positions = positions, Normals = normals,
                            Sockets = sockets, Joints = joints });
                        face.EvaluateBatch(new PoseBatch(1, controls) { Positions = positions, Lod = 1 });
                        instance[0] = controls[0];
                        instance.Pose();
                        instance.Write(mesh, vertices);
                        controls.CopyTo(crowd.Controls(0));
                        crowd.SetLod(1, i % 3, true);
                        crowd.SetSeen(2, i % 2 == 0);
                        crowd.Evaluate(1);
                        if (crowd.Positions(1).Length != crowd.Normals(1).Length) throw new Exception();
                        if (face.RestPositions.Length != positions.Length || face.Controls.Count == 0) throw new Exception();
                    }
                    for (int i = 0; i < 20; ++i)
                        scratch.EvaluateBatch(new PoseBatch(batch, batchControls) { Positions = batchPositions,
                            ParallelFor = turns });
                };
                int collections, none;
                Same(0L, AllocatedBy(everything, out collections), "bytes allocated");
                Same(0, collections, "collections");
                Same(16L * 1000, AllocatedBy(() => { for (int i = 0; i < 1000; ++i) GC.KeepAlive(new object()); }, out none),
                     "bytes of 1,000 objects, which the count sees");
                Console.WriteLine("        0 bytes allocated by " + poses + " poses of each kind");
            }
        }

        // glibc's struct mallinfo2.
        [StructLayout(LayoutKind.Sequential)]
        private struct AllocatorFigures
        {
            public UIntPtr Arena, FreeChunks, FastBins, MappedRegions, MappedBytes, Unused, FastBytes, UsedBytes, FreeBytes, Top;
        }

        [DllImport("libc.so.6", CallingConvention = CallingConvention.Cdecl)]
        private static extern AllocatorFigures mallinfo2();

        private static long NativeBytes()
        {
            AllocatorFigures figures = mallinfo2();
            return (long)((ulong)figures.UsedBytes + (ulong)figures.MappedBytes);
        }

        // A scratch of the fixture takes 4 kB, of the quickstart's face 0.5 MB.
        public static void CharactersHaveNoWorkingMemoryOfTheirOwn()
        {
            const int count = 100;
            using (Face face = Face.Load(Fixture("levels.fbk")))
            {
                new FaceInstance(face).Pose();
                var faces = new Face[count];
                for (int i = 0; i < count; ++i) faces[i] = face;
                long before = NativeBytes();
                var scratches = new Scratch[count];
                for (int i = 0; i < count; ++i) scratches[i] = new Scratch(face);
                That(NativeBytes() - before > 2000 * count, "the measure includes scratches");
                foreach (Scratch scratch in scratches) scratch.Dispose();
                before = NativeBytes();
                using (var crowd = new Crowd(faces, 2))
                {
                    for (int i = 0; i < count; ++i) crowd.SetNormals(i, true);
                    crowd.Evaluate();
                    long outputs = sizeof(float) * (face.ControlCount + 6 * face.VertexCount);
                    long each = (NativeBytes() - before) / count - outputs;
                    That(each < 1000, each + " bytes a face of a crowd beside its outputs");
                }
                var instances = new FaceInstance[count];
                before = NativeBytes();
                long managed = GC.GetAllocatedBytesForCurrentThread();
                for (int i = 0; i < count; ++i)
                {
                    instances[i] = new FaceInstance(face);
                    instances[i].Pose();
                }
                managed = GC.GetAllocatedBytesForCurrentThread() - managed;
                That(NativeBytes() - before < 50000, NativeBytes() - before + " bytes of instances in the library");
                FaceInstance one = instances[0];
                int numbers = one.Controls.Length + one.Positions.Length + one.Normals.Length + one.Tangents.Length +
                    one.Sockets.Length + one.Joints.Length + one.Bounds.Length;
                That(managed / count - sizeof(float) * numbers < 1000, managed / count + " bytes an instance");
            }
        }

        public static void SolvingAllocatesNothing()
        {
            using (Face face = Face.Load(Fixture("driven.fbk")))
            using (var solver = new Solver(face))
            {
                float[] pose = Widest(face), targets = new float[3 * face.VertexCount], found = new float[pose.Length],
                    before = new float[pose.Length], decided = new float[pose.Length], motion = new float[12],
                    derivatives = new float[solver.RowCount * pose.Length], differences = new float[face.VertexCount];
                face.Evaluate(pose, targets);
                bool[] movable = ControlSearch.MaskWithout(face, face.Controls[0].Name);
                Action everything = () =>
                {
                    for (int i = 0; i < 20; ++i)
                    {
                        solver.Jacobian(new PoseJacobian(pose) { Derivatives = derivatives, Downwards = movable });
                        solver.Solve(new SolveTargets(found) { Points = targets, Before = before, Smoothness = 10,
                            Movable = movable, FindMotion = true, Motion = motion, Decided = decided,
                            PointDifferences = differences });
                    }
                };
                int collections;
                Same(0L, AllocatedBy(everything, out collections), "bytes allocated");
                Same(0, collections, "collections");
            }
        }

        private sealed class OneByOne : IParallelFor
        {
            public void Run(int count, int workers, PoseTask task)
            {
                for (int i = 0; i < count; ++i) task.Run(i, 0);
            }
        }

        public static void ACallCostsLessThanAMicrosecondMore()
        {
            string path = Fixture("tiny.fbk");
            byte[] utf8 = Encoding.UTF8.GetBytes(path + "\0");
            using (Face face = Face.Load(path))
            using (var scratch = new Scratch(face))
            {
                const int rounds = 300, calls = 1000;
                float[] controls = Widest(face), positions = new float[3 * face.VertexCount];
                double[] ours = new double[rounds], pooled = new double[rounds], theirs = new double[rounds];
                for (int round = 0; round < rounds; ++round)
                {
                    theirs[round] = time_evaluate(utf8, calls);
                    That(theirs[round] > 0, "the C calls succeed");
                    long begin = Stopwatch.GetTimestamp();
                    for (int i = 0; i < calls; ++i) scratch.Evaluate(controls, positions);
                    long middle = Stopwatch.GetTimestamp();
                    for (int i = 0; i < calls; ++i) face.Evaluate(controls, positions);
                    long end = Stopwatch.GetTimestamp();
                    double tick = 1e9 / Stopwatch.Frequency / calls;
                    ours[round] = (middle - begin) * tick;
                    pooled[round] = (end - middle) * tick;
                }
                double c = Median(theirs), one = Median(ours), two = Median(pooled);
                Console.WriteLine("        ns a call, medians of {0} interleaved rounds: C {1:0}, Scratch.Evaluate {2:0}, Face.Evaluate {3:0}",
                                  rounds, c, one, two);
                That(one - c < 1000, "Scratch.Evaluate takes less than 1 us more than C");
                That(two - c < 1000, "Face.Evaluate takes less than 1 us more than C");
            }
        }

        private static double Median(double[] values)
        {
            Array.Sort(values);
            return values[values.Length / 2];
        }
    }
}
