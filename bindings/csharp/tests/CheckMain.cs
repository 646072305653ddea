using System;
using System.Collections.Generic;
using System.IO;
using System.Reflection;

namespace FaceBaker.Tests
{
    /// <summary>Runs the public static methods of all classes whose names end with Tests, each a test that fails by an
    /// exception, on a build folder of
    /// FaceBaker and a folder of poses by dump_poses.</summary>
    internal static class CheckMain
    {
        private static string build, poses;

        public static int Main(string[] arguments)
        {
            if (arguments.Length != 2)
            {
                Console.Error.WriteLine("usage: tests.exe BUILD POSES");
                return 2;
            }
            build = arguments[0];
            poses = arguments[1];
            int failures = 0, count = 0;
            foreach (Type type in typeof(CheckMain).Assembly.GetTypes())
            {
                if (!type.Name.EndsWith("Tests")) continue;
                foreach (MethodInfo method in type.GetMethods(BindingFlags.Static | BindingFlags.Public | BindingFlags.DeclaredOnly))
                {
                    ++count;
                    try
                    {
                        method.Invoke(null, null);
                        Console.WriteLine("ok      " + type.Name + "." + method.Name);
                    }
                    catch (TargetInvocationException exception)
                    {
                        ++failures;
                        Console.WriteLine("FAILED  " + type.Name + "." + method.Name + ": " + exception.InnerException);
                    }
                }
            }
            Console.WriteLine(count + " tests, " + failures + " failed");
            return failures == 0 ? 0 : 1;
        }

        public static string Fixture(string name)
        {
            return Path.Combine(build, "fixtures", name);
        }

        public static string[] Golden(string kind)
        {
            return Directory.GetFiles(Path.Combine(build, "golden", kind), "*.fbk");
        }

        /// <summary>Pairs of an archive and the poses that the C interface gives of it.</summary>
        public static IEnumerable<KeyValuePair<string, DumpedPoses>> Dumped()
        {
            int count = 0;
            foreach (string file in Directory.GetFiles(poses, "*.poses"))
            {
                string archive = File.ReadAllText(Path.ChangeExtension(file, ".path")).Trim();
                yield return new KeyValuePair<string, DumpedPoses>(archive, new DumpedPoses(file));
                ++count;
            }
            That(count >= 4, "there are poses of " + count + " archives");
        }

        public static void That(bool holds, string what)
        {
            if (!holds) throw new Exception("not so: " + what);
        }

        public static void Same<T>(T expected, T found, string what)
        {
            That(EqualityComparer<T>.Default.Equals(expected, found), what + " is " + found + " in place of " + expected);
        }

        /// <summary>The same bits.</summary>
        public static void SameBits(ReadOnlySpan<float> expected, ReadOnlySpan<float> found, string what)
        {
            Same(expected.Length, found.Length, what + ", length");
            for (int i = 0; i < expected.Length; ++i)
                if (BitConverter.DoubleToInt64Bits(expected[i]) != BitConverter.DoubleToInt64Bits(found[i]))
                    throw new Exception(what + "[" + i + "] is " + found[i] + " in place of " + expected[i]);
        }

        public static T Throws<T>(Action action) where T : Exception
        {
            try
            {
                action();
            }
            catch (T exception)
            {
                That(exception.Message.Length > 0, "the exception has a message");
                return exception;
            }
            throw new Exception("no " + typeof(T).Name + " was thrown");
        }

        public static float[] Widest(Face face)
        {
            var controls = new float[face.ControlCount];
            for (int i = 0; i < controls.Length; ++i) controls[i] = face.Controls[i].Maximum;
            return controls;
        }
    }

    /// <summary>What dump_poses has written.</summary>
    internal sealed class DumpedPoses
    {
        public readonly int Poses, Controls, Vertices, Sockets, Channels, Tangents, Joints;
        private readonly float[] numbers;

        public DumpedPoses(string file)
        {
            byte[] bytes = File.ReadAllBytes(file);
            var header = new int[7];
            Buffer.BlockCopy(bytes, 0, header, 0, 28);
            Poses = header[0];
            Controls = header[1];
            Vertices = header[2];
            Sockets = header[3];
            Channels = header[4];
            Tangents = header[5];
            Joints = header[6];
            numbers = new float[(bytes.Length - 28) / 4];
            Buffer.BlockCopy(bytes, 28, numbers, 0, 4 * numbers.Length);
            CheckMain.Same(Poses * PoseFloats, numbers.Length, "numbers in " + file);
        }

        private int PoseFloats
        {
            get { return Controls + Vertices * (6 + 3 * Tangents) + Sockets + Channels + Joints; }
        }

        public ReadOnlySpan<float> ControlsOf(int pose) { return Part(pose, 0, Controls); }
        public ReadOnlySpan<float> PositionsOf(int pose) { return Part(pose, Controls, 3 * Vertices); }
        public ReadOnlySpan<float> NormalsOf(int pose) { return Part(pose, Controls + 3 * Vertices, 3 * Vertices); }
        public ReadOnlySpan<float> TangentsOf(int pose) { return Part(pose, Controls + 6 * Vertices, 3 * Vertices * Tangents); }
        public ReadOnlySpan<float> SocketsOf(int pose) { return Part(pose, PoseFloats - Joints - Channels - Sockets, Sockets); }
        public ReadOnlySpan<float> ChannelsOf(int pose) { return Part(pose, PoseFloats - Joints - Channels, Channels); }
        public ReadOnlySpan<float> JointsOf(int pose) { return Part(pose, PoseFloats - Joints, Joints); }

        private ReadOnlySpan<float> Part(int pose, int first, int count)
        {
            return new ReadOnlySpan<float>(numbers, pose * PoseFloats + first, count);
        }
    }
}
