using System;
using System.Runtime.InteropServices;
using System.Text;

namespace FaceBaker
{
    /// <summary>The functions of libfacebaker. The rest of this class is generated from the headers.</summary>
    internal static unsafe partial class Native
    {
#if !UNITY_EDITOR && (UNITY_IOS || UNITY_TVOS || UNITY_VISIONOS)
        private const string Library = "__Internal";
#else
        private const string Library = "facebaker";
#endif
        /// <summary>A string of the library as UTF-16; "" for null.</summary>
        public static string Text(byte* utf8)
        {
            if (utf8 == null) return "";
            int length = 0;
            while (utf8[length] != 0) ++length;
            return length == 0 ? "" : Encoding.UTF8.GetString(utf8, length);
        }

        /// <summary>A zero-terminated UTF-8 string to hand to the library.</summary>
        /// <exception cref="ArgumentNullException">text is null.</exception>
        /// <exception cref="ArgumentException">text contains a zero, at which the library would cut it.</exception>
        public static byte[] Utf8(string text, string parameter)
        {
            if (text == null) throw new ArgumentNullException(parameter);
            if (text.IndexOf('\0') >= 0) throw new ArgumentException("The text contains a zero character.", parameter);
            var bytes = new byte[Encoding.UTF8.GetByteCount(text) + 1];
            Encoding.UTF8.GetBytes(text, 0, text.Length, bytes, 0);
            return bytes;
        }

        /// <summary>Throws what a status says, with the library's message of this thread.</summary>
        public static void Check(int status)
        {
            if (status != FB_OK) Throw(status);
        }

        /// <summary>A new array with `count` values of the library's.</summary>
        public static float[] Copy(float* from, int count)
        {
            var copy = new float[count];
            if (count > 0) Marshal.Copy((IntPtr)from, copy, 0, count);
            return copy;
        }

        /// <summary>A new array with `count` values of the library's.</summary>
        public static byte[] Copy(byte* from, int count)
        {
            var copy = new byte[count];
            if (count > 0) Marshal.Copy((IntPtr)from, copy, 0, count);
            return copy;
        }

        /// <summary>A new array with `count` values of the library's.</summary>
        public static uint[] Copy(uint* from, int count)
        {
            var copy = new uint[count];
            if (count > 0) new ReadOnlySpan<uint>(from, count).CopyTo(copy);
            return copy;
        }

        /// <summary>A new array with `count` values of the library's.</summary>
        public static ushort[] Copy(ushort* from, int count)
        {
            var copy = new ushort[count];
            if (count > 0) new ReadOnlySpan<ushort>(from, count).CopyTo(copy);
            return copy;
        }

        private static void Throw(int status)
        {
            string message = Text(fb_last_error());
            if (message.Length == 0) message = Text(fb_status_name(status));
            throw new FaceBakerException((Status)status, message);
        }
    }

    /// <summary>A reference to a model of the library, released when it is disposed or finalized.</summary>
    internal sealed class ModelHandle : SafeHandle
    {
        public ModelHandle() : base(IntPtr.Zero, true) { }

        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }

        protected override bool ReleaseHandle()
        {
            Native.fb_release(handle);
            return true;
        }
    }

    /// <summary>A scratch of the library. It holds a reference to its model of its own, so that the order in which the two
    /// are finalized does not matter.</summary>
    internal sealed class ScratchHandle : SafeHandle
    {
        public ScratchHandle() : base(IntPtr.Zero, true) { }

        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }

        protected override bool ReleaseHandle()
        {
            Native.fb_scratch_destroy(handle);
            return true;
        }
    }

    internal sealed class SolverHandle : SafeHandle
    {
        public SolverHandle() : base(IntPtr.Zero, true) { }

        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }

        protected override bool ReleaseHandle()
        {
            Native.fb_solver_destroy(handle);
            return true;
        }
    }
}
