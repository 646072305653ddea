using System;
using System.Runtime.InteropServices;

namespace FaceBaker
{
    /// <summary>A host's scheduler, for batches: Unity's job system, a thread pool of one's own. See
    /// <see cref="ParallelForHandle"/>.</summary>
    public interface IParallelFor
    {
        /// <summary>Calls task.Run(index, worker) once for every index below count, with worker below workers and never two at
        /// once with the same worker, from any threads; returns when all calls have. An exception is thrown again by the call
        /// that poses.</summary>
        void Run(int count, int workers, PoseTask task);
    }

    /// <summary>Poses of a batch, to be run by a scheduler; valid during <see cref="IParallelFor.Run"/>.</summary>
    public struct PoseTask
    {
        private readonly fb_task task;
        private readonly IntPtr context;

        internal PoseTask(fb_task task, IntPtr context)
        {
            this.task = task;
            this.context = context;
        }

        /// <summary>Runs a part. Does not throw.</summary>
        public unsafe void Run(int index, int worker)
        {
            task((void*)context, (uint)index, (uint)worker);
        }
    }

    internal sealed class ParallelState : CallbackState
    {
        public IParallelFor ParallelFor;
    }

    /// <summary>A scheduler as batches take it: made once, used for any number of batches, of one thread at a time; dispose it
    /// when no batch uses it. Without one, batches run on OpenMP's threads where the library was built with it, and else on the
    /// calling thread.</summary>
    public sealed class ParallelForHandle : IDisposable
    {
        private GCHandle handle;

        /// <summary>A handle of a scheduler.</summary>
        /// <exception cref="ArgumentNullException">parallelFor is null.</exception>
        public ParallelForHandle(IParallelFor parallelFor)
        {
            if (parallelFor == null) throw new ArgumentNullException(nameof(parallelFor));
            State = new ParallelState { ParallelFor = parallelFor };
            handle = GCHandle.Alloc(State);
        }

        /// <summary>Frees the handle where it was not disposed.</summary>
        ~ParallelForHandle()
        {
            if (handle.IsAllocated) handle.Free();
        }

        internal ParallelState State { get; private set; }

        /// <exception cref="ObjectDisposedException">It was disposed.</exception>
        internal IntPtr User
        {
            get
            {
                if (!handle.IsAllocated) throw new ObjectDisposedException(nameof(ParallelForHandle));
                return GCHandle.ToIntPtr(handle);
            }
        }

        /// <summary>Frees the handle. May be called again.</summary>
        public void Dispose()
        {
            if (handle.IsAllocated) handle.Free();
            GC.SuppressFinalize(this);
        }
    }
}
