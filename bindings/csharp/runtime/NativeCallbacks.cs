using System;
using System.Collections.Generic;
using System.IO;
using System.Runtime.ExceptionServices;
using System.Runtime.InteropServices;
using System.Threading;
#if UNITY_5_3_OR_NEWER
using AOT;
#endif

namespace FaceBaker
{
#if !UNITY_5_3_OR_NEWER
    /// <summary>Marks static methods that native code calls. IL2CPP knows the attribute by its name; where Unity's own is
    /// there, that one is used.</summary>
    [AttributeUsage(AttributeTargets.Method)]
    internal sealed class MonoPInvokeCallbackAttribute : Attribute
    {
        public MonoPInvokeCallbackAttribute(Type type)
        {
            DelegateType = type;
        }

        public Type DelegateType { get; private set; }
    }
#endif

    /// <summary>What a native call hands to the callbacks below: reached by a GCHandle, which is the user pointer. No exception
    /// passes through native code: the first is kept, and thrown again after the call.</summary>
    internal abstract class CallbackState
    {
        private ExceptionDispatchInfo failure;

        public void Keep(Exception exception)
        {
            Interlocked.CompareExchange(ref failure, ExceptionDispatchInfo.Capture(exception), null);
        }

        public void Rethrow()
        {
            ExceptionDispatchInfo kept = Interlocked.Exchange(ref failure, null);
            if (kept != null) kept.Throw();
        }
    }

    /// <summary>Of a load: the stream that is read, if it is one, and who receives notes.</summary>
    internal sealed class LoadState : CallbackState
    {
        public Stream Stream;
        public byte[] Buffer;
        public Action<string> Note;
    }

    /// <summary>The functions that native code calls: static, without closures, so that IL2CPP can compile them ahead of time.
    /// The delegates live as long as the process.</summary>
    internal static unsafe class NativeCallbacks
    {
        private static readonly fb_read ReadDelegate = Read;
        private static readonly fb_log LogDelegate = Log;
        private static readonly fb_parallel_for ParallelForDelegate = ParallelFor;

        public static readonly IntPtr ReadPointer = Marshal.GetFunctionPointerForDelegate(ReadDelegate);
        public static readonly IntPtr LogPointer = Marshal.GetFunctionPointerForDelegate(LogDelegate);
        public static readonly IntPtr ParallelForPointer = Marshal.GetFunctionPointerForDelegate(ParallelForDelegate);

        private static T State<T>(void* user) where T : CallbackState
        {
            return (T)GCHandle.FromIntPtr((IntPtr)user).Target;
        }

        [MonoPInvokeCallback(typeof(fb_read))]
        private static long Read(void* user, void* to, ulong bytes)
        {
            LoadState state = State<LoadState>(user);
            try
            {
                int wanted = (int)Math.Min(bytes, (ulong)state.Buffer.Length);
                int count = state.Stream.Read(state.Buffer, 0, wanted);
                Marshal.Copy(state.Buffer, 0, (IntPtr)to, count);
                return count;
            }
            catch (Exception exception)
            {
                state.Keep(exception);
                return -1;
            }
        }

        [MonoPInvokeCallback(typeof(fb_log))]
        private static void Log(void* user, byte* message)
        {
            LoadState state = State<LoadState>(user);
            try
            {
                state.Note(Native.Text(message));
            }
            catch (Exception exception)
            {
                state.Keep(exception);
            }
        }

        [MonoPInvokeCallback(typeof(fb_parallel_for))]
        private static void ParallelFor(void* user, uint count, uint workers, IntPtr task, void* context)
        {
            ParallelState state = State<ParallelState>(user);
            try
            {
                state.ParallelFor.Run((int)count, (int)workers, new PoseTask(TaskOf(task), (IntPtr)context));
            }
            catch (Exception exception)
            {
                state.Keep(exception);
            }
        }

        // The library has few tasks, always the same: a delegate is made once for each.
        private static readonly Dictionary<IntPtr, fb_task> Tasks = new Dictionary<IntPtr, fb_task>();
        private static KeyValuePair<IntPtr, fb_task>[] lastTask = { default(KeyValuePair<IntPtr, fb_task>) };

        private static fb_task TaskOf(IntPtr pointer)
        {
            KeyValuePair<IntPtr, fb_task>[] last = Volatile.Read(ref lastTask);
            if (last[0].Key == pointer) return last[0].Value;
            lock (Tasks)
            {
                fb_task task;
                if (!Tasks.TryGetValue(pointer, out task))
                {
                    task = Marshal.GetDelegateForFunctionPointer<fb_task>(pointer);
                    Tasks.Add(pointer, task);
                    Volatile.Write(ref lastTask, new[] { new KeyValuePair<IntPtr, fb_task>(pointer, task) });
                }
                return task;
            }
        }
    }
}
