using System;
using System.Collections.Generic;
using System.Threading;
using static FaceBaker.Tests.CheckMain;

namespace FaceBaker.Tests
{
    internal static class BatchTests
    {
        public static void BatchesHaveTheBitsOfSinglePoses()
        {
            foreach (KeyValuePair<string, DumpedPoses> pair in Dumped())
                using (Face face = Face.Load(pair.Key))
                using (var scratch = new Scratch(face, 2))
                using (var turns = new ParallelForHandle(new InTurn()))
                using (var threads = new ParallelForHandle(new OnThreads()))
                    foreach (ParallelForHandle parallelFor in new[] { null, turns, threads })
                        CheckBatch(face, scratch, parallelFor, pair.Value);
        }

        private static void CheckBatch(Face face, Scratch scratch, ParallelForHandle parallelFor, DumpedPoses expected)
        {
            const int repeats = 16;
            int count = repeats * expected.Poses, coordinates = 3 * face.VertexCount;
            var controls = new float[count * face.ControlCount];
            for (int p = 0; p < count; ++p)
                expected.ControlsOf(p % expected.Poses).CopyTo(new Span<float>(controls, p * face.ControlCount,
                    face.ControlCount));
            var positions = new float[count * coordinates];
            scratch.EvaluateBatch(new PoseBatch(count, controls) { Positions = positions, ParallelFor = parallelFor });
            for (int p = 0; p < count; ++p)
                SameBits(expected.PositionsOf(p % expected.Poses), new ReadOnlySpan<float>(positions, p * coordinates,
                    coordinates), "pose");
        }

        public static void ASchedulerIsCalledAndItsExceptionsPass()
        {
            using (Face face = Face.Load(Fixture("tiny.fbk")))
            using (var scratch = new Scratch(face, 2))
            {
                var controls = new float[64 * face.ControlCount];
                var positions = new float[64 * 3 * face.VertexCount];
                var scheduler = new InTurn();
                using (var handle = new ParallelForHandle(scheduler))
                    scratch.EvaluateBatch(new PoseBatch(64, controls) { Positions = positions, ParallelFor = handle });
                That(scheduler.Calls > 0, "the scheduler was called");
                using (var handle = new ParallelForHandle(new InTurn { Fail = true }))
                {
                    string message = Throws<InvalidOperationException>(() => scratch.EvaluateBatch(
                        new PoseBatch(64, controls) { Positions = positions, ParallelFor = handle })).Message;
                    Same("the scheduler broke", message, "message");
                }
                using (var handle = new ParallelForHandle(new InTurn { Skip = true }))
                    Same(Status.InvalidArgument, Throws<FaceBakerException>(() => scratch.EvaluateBatch(
                        new PoseBatch(64, controls) { Positions = positions, ParallelFor = handle })).Status, "status");
                var closed = new ParallelForHandle(scheduler);
                closed.Dispose();
                closed.Dispose();
                Throws<ObjectDisposedException>(() => scratch.EvaluateBatch(
                    new PoseBatch(64, controls) { Positions = positions, ParallelFor = closed }));
                Throws<ArgumentNullException>(() => new ParallelForHandle(null));
            }
        }

        public static void ACrowdHasTheBitsOfItsFaces()
        {
            using (Face tiny = Face.Load(Fixture("tiny.fbk")))
            using (Face levels = Face.Load(Fixture("levels.fbk")))
            using (var handle = new ParallelForHandle(new OnThreads()))
            {
                var faces = new[] { levels, tiny, tiny };
                using (var crowd = new Crowd(faces))
                {
                    Same(3, crowd.Count, "faces");
                    foreach (ParallelForHandle parallelFor in new[] { null, handle })
                        for (int frame = 1; frame <= 3; ++frame)
                        {
                            for (int i = 0; i < 3; ++i)
                                crowd.Controls(i).Fill(0.1f * frame * (i + 1));
                            crowd.Evaluate(frame - 1, parallelFor);
                            for (int i = 0; i < 3; ++i)
                            {
                                var expected = new float[3 * faces[i].VertexCount];
                                faces[i].Evaluate(crowd.Controls(i), expected);
                                SameBits(expected, crowd.Positions(i), "face");
                            }
                        }
                    crowd.Controls(1).Fill(float.NaN);
                    FaceBakerException error = Throws<FaceBakerException>(() => crowd.Evaluate());
                    That(error.Message.StartsWith("item 1: "), error.Message);
                    Throws<ArgumentOutOfRangeException>(() => crowd.Evaluate(-1));
                    Throws<IndexOutOfRangeException>(() => crowd.Controls(3));
                    crowd.Dispose();
                    Throws<ObjectDisposedException>(() => crowd.Evaluate());
                    Throws<ObjectDisposedException>(() => crowd.Positions(0).ToArray());
                }
                Throws<ArgumentNullException>(() => new Crowd(null));
                Throws<ArgumentNullException>(() => new Crowd(new[] { tiny, null }));
                using (var none = new Crowd(new Face[0])) none.Evaluate();
            }
        }

        public static void FacesOfACrowdHaveLevelsNormalsAndAreSeenOrNot()
        {
            using (Face tiny = Face.Load(Fixture("tiny.fbk")))
            using (Face levels = Face.Load(Fixture("levels.fbk")))
            using (var crowd = new Crowd(new[] { levels, tiny, levels, levels }, 2))
            {
                for (int i = 0; i < crowd.Count; ++i) crowd.Controls(i).Fill(0.2f * (i + 1));
                crowd.SetNormals(2, true);
                crowd.SetNormals(3, true);
                crowd.SetLod(2, 1.5f);
                crowd.SetLod(3, 9, true);
                Same(1.5f, crowd.Lod(2), "level");
                crowd.Evaluate(3); // of two there are
                int all = 3 * levels.VertexCount, few = 3 * levels.Levels[2].VertexCount;
                That(few < all, "the last level has fewer vertices");
                CheckFace(crowd, 0, levels, new PoseBatch(1, crowd.Controls(0)) { Positions = new float[all] });
                CheckFace(crowd, 2, levels, new PoseBatch(1, crowd.Controls(2)) { Positions = new float[all],
                    Normals = new float[all], Lod = 1.5f });
                CheckFace(crowd, 3, levels, new PoseBatch(1, crowd.Controls(3)) { Positions = new float[few],
                    Normals = new float[few], Lod = 2, LevelOnly = true, BakedOrder = true });
                Same(0L, crowd.ClampedCount(0), "clamped");
                crowd.Controls(0).Fill(99);
                float before = crowd.Positions(1)[4];
                crowd.Controls(1).Fill(float.NaN);
                crowd.SetSeen(1, false);
                crowd.SetNormals(2, false);
                crowd.Evaluate();
                Same((long)levels.ControlCount, crowd.ClampedCount(0), "clamped");
                Same(before, crowd.Positions(1)[4], "the pose of a face that nobody sees");
                Same(0, crowd.Normals(2).Length, "normals that are not computed");
                crowd.SetSeen(1, true);
                That(Throws<FaceBakerException>(() => crowd.Evaluate()).Message.StartsWith("item 1: "), "it is posed again");
                Throws<ArgumentOutOfRangeException>(() => crowd.SetLod(0, -1));
                Throws<ArgumentOutOfRangeException>(() => crowd.SetLod(0, float.NaN));
                Throws<ArgumentOutOfRangeException>(() => new Crowd(new[] { tiny }, -1));
                Throws<IndexOutOfRangeException>(() => crowd.SetSeen(4, true));
                Throws<IndexOutOfRangeException>(() => crowd.Normals(-1));
            }
        }

        // batch: the outputs that the face has in the crowd.
        private static void CheckFace(Crowd crowd, int face, Face model, in PoseBatch batch)
        {
            model.EvaluateBatch(in batch);
            SameBits(batch.Positions, crowd.Positions(face), "positions of face " + face);
            SameBits(batch.Normals, crowd.Normals(face), "normals of face " + face);
        }

        public static void OptionsReachTheLibrary()
        {
            using (Face face = Face.Load(Fixture("levels.fbk")))
            {
                float[] controls = Widest(face);
                int coordinates = 3 * face.VertexCount;
                float[] whole = new float[coordinates], other = new float[coordinates], bounds = new float[6];
                face.EvaluateBatch(new PoseBatch(1, controls) { Positions = whole, Bounds = bounds });
                That(bounds[0] < bounds[3], "bounds");
                face.EvaluateBatch(new PoseBatch(1, controls) { Positions = other, Displacements = true });
                for (int i = 0; i < coordinates; ++i)
                    That(Math.Abs(face.RestPositions[i] + other[i] - whole[i]) < 1e-4 * face.Diagonal, "displacements");
                face.EvaluateBatch(new PoseBatch(1, controls) { Positions = other, BakedOrder = true });
                for (int i = 0; i < face.VertexCount; ++i)
                {
                    int source = face.VertexOrder.Length == 0 ? i : (int)face.VertexOrder[i];
                    SameBits(new ReadOnlySpan<float>(whole, 3 * source, 3), new ReadOnlySpan<float>(other, 3 * i, 3),
                        "baked order");
                }
                int fewer = face.Levels[1].VertexCount;
                var level = new float[3 * fewer];
                face.EvaluateBatch(new PoseBatch(1, controls) { Positions = level, Lod = 1, LevelOnly = true,
                    BakedOrder = true });
                var strided = new float[4 * face.VertexCount];
                face.EvaluateBatch(new PoseBatch(1, controls) { Positions = strided, PositionVertexStride = 4 });
                for (int i = 0; i < face.VertexCount; ++i)
                    SameBits(new ReadOnlySpan<float>(whole, 3 * i, 3), new ReadOnlySpan<float>(strided, 4 * i, 3), "strides");
                var halves = new ushort[coordinates];
                face.EvaluateBatch(new PoseBatch(1, controls) { HalfPositions = halves });
                That(Array.Exists(halves, half => half != 0), "halves");
                Throws<ArgumentException>(() => face.EvaluateBatch(
                    new PoseBatch(1, controls) { HalfPositions = halves, Normals = new float[coordinates] }));
                Throws<FaceBakerException>(() => face.EvaluateBatch(new PoseBatch(1, controls) { Positions = whole,
                    Lod = -1 }));
                Throws<FaceBakerException>(() => face.EvaluateBatch(new PoseBatch(2, controls) { Positions = whole }));
                Throws<ArgumentOutOfRangeException>(() => face.EvaluateBatch(new PoseBatch(-1,
                    controls) { Positions = whole }));
                face.EvaluateBatch(new PoseBatch(0, ReadOnlySpan<float>.Empty));
            }
            using (Face face = Face.Load(Fixture("character.fbk")))
            {
                float[] controls = Widest(face), positions = new float[3 * face.VertexCount];
                face.EvaluateBatch(new PoseBatch(1, controls) { Positions = positions, Meshes = new uint[] { 1 } });
                FaceMesh first = face.Meshes[0], second = face.Meshes[1];
                That(Array.TrueForAll(new ReadOnlySpan<float>(positions, 0, 3 * first.VertexCount).ToArray(), x => x == 0),
                    "mesh 0");
                That(Array.Exists(new ReadOnlySpan<float>(positions, 3 * second.FirstVertex, 3 * second.VertexCount).ToArray(),
                                  x => x != 0), "mesh 1");
                Throws<FaceBakerException>(() => face.EvaluateBatch(
                    new PoseBatch(1, controls) { Positions = positions, Meshes = new uint[] { 99 } }));
                face.EvaluateBatch(new PoseBatch(1, controls) { Positions = positions, WithoutRegions = true });
            }
        }

        private sealed class InTurn : IParallelFor
        {
            public bool Fail, Skip;
            public int Calls;

            public void Run(int count, int workers, PoseTask task)
            {
                ++Calls;
                for (int i = Skip ? 1 : 0; i < count; ++i) task.Run(i, i % workers);
                if (Fail) throw new InvalidOperationException("the scheduler broke");
            }
        }

        private sealed class OnThreads : IParallelFor
        {
            public void Run(int count, int workers, PoseTask task)
            {
                int next = -1;
                var threads = new Thread[workers];
                for (int w = 0; w < workers; ++w)
                {
                    int worker = w;
                    threads[w] = new Thread(() =>
                    {
                        for (int i = Interlocked.Increment(ref next); i < count; i = Interlocked.Increment(ref next))
                            task.Run(i, worker);
                    });
                    threads[w].Start();
                }
                foreach (Thread thread in threads) thread.Join();
            }
        }
    }
}
