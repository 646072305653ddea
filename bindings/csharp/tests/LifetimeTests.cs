using System;
using System.Runtime.CompilerServices;
using System.Threading;
using static FaceBaker.Tests.CheckMain;

namespace FaceBaker.Tests
{
    internal static class LifetimeTests
    {
        public static void DisposedTwiceAndUsedAfterwards()
        {
            Face face = Face.Load(Fixture("tiny.fbk"));
            var scratch = new Scratch(face);
            float[] controls = face.RestControls.ToArray(), positions = new float[3 * face.VertexCount];
            int restPositions = face.RestPositions.Length;
            face.Evaluate(controls, positions);
            face.Dispose();
            face.Dispose();
            Same(restPositions, face.RestPositions.Length, "copied arrays stay");
            Throws<ObjectDisposedException>(() => { string name = face.Controls[0].Name; });
            Throws<ObjectDisposedException>(() => face.Evaluate(controls, positions));
            Throws<ObjectDisposedException>(() => scratch.Evaluate(controls, positions));
            Throws<ObjectDisposedException>(() => new Scratch(face));
            scratch.Dispose();
            scratch.Dispose();
            Throws<ObjectDisposedException>(() => scratch.Evaluate(controls, positions));
            Throws<ObjectDisposedException>(() => { long count = scratch.ClampedCount; });
        }

        public static void FinalizersFreeWhatIsNotDisposed()
        {
            long before = ResidentBytes();
            for (int i = 0; i < 40; ++i)
            {
                MakeAndForget(50);
                GC.Collect();
                GC.WaitForPendingFinalizers();
            }
            // 2,000 faces with a scratch each; kept, they would take far more.
            using (Face face = Face.Load(Fixture("character.fbk")))
                That(ResidentBytes() - before < 500 * face.RuntimeBytes + (24 << 20), "memory grew by " +
                    (ResidentBytes() - before));
        }

        [MethodImpl(MethodImplOptions.NoInlining)]
        private static void MakeAndForget(int count)
        {
            for (int i = 0; i < count; ++i)
            {
                Face face = Face.Load(Fixture("character.fbk"));
                var scratch = new Scratch(face);
                scratch.Evaluate(face.RestControls, new float[3 * face.VertexCount]);
            }
        }

        private static long ResidentBytes()
        {
            foreach (string line in System.IO.File.ReadAllLines("/proc/self/status"))
                if (line.StartsWith("VmRSS:")) return 1024 * long.Parse(line.Substring(6, line.Length - 8).Trim());
            throw new Exception("no VmRSS");
        }

        public static void DisposingWhileOthersPoseIsSafe()
        {
            for (int round = 0; round < 20; ++round)
            {
                Face face = Face.Load(Fixture("character.fbk"));
                float[] controls = Widest(face);
                Exception failure = null;
                int posed = 0;
                var threads = new Thread[3];
                for (int t = 0; t < threads.Length; ++t)
                {
                    threads[t] = new Thread(() =>
                    {
                        var positions = new float[3 * face.VertexCount];
                        try
                        {
                            while (true)
                            {
                                face.Evaluate(controls, positions);
                                Interlocked.Increment(ref posed);
                            }
                        }
                        catch (ObjectDisposedException)
                        {
                        }
                        catch (Exception exception)
                        {
                            failure = exception;
                        }
                    });
                    threads[t].Start();
                }
                while (Volatile.Read(ref posed) < 10) Thread.Yield();
                face.Dispose();
                foreach (Thread thread in threads) thread.Join();
                That(failure == null, "" + failure);
            }
        }
    }
}
