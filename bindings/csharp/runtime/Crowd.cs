using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace FaceBaker
{
    /// <summary>Faces of any kinds that one call poses, each on one thread: write their <see cref="Controls"/>, call
    /// <see cref="Evaluate"/>, read their <see cref="Positions"/>. Its numbers lie in memory of their own, which the garbage
    /// collector does not move. For one thread at a time. It keeps what it needs of its faces, also after those were
    /// disposed.</summary>
    public sealed unsafe class Crowd : IDisposable
    {
        private readonly ModelHandle[] models;
        private readonly Scratch[] scratches;
        private readonly int[] controlCounts, coordinateCounts;
        private readonly fb_batch_desc* batches;
        private readonly fb_many_item* items;
        private int held;
        private bool disposed;

        /// <summary>A crowd of these faces, all at rest; a face may come several times. Those that take longest are best
        /// first, as threads take them in their order.</summary>
        /// <exception cref="ArgumentNullException">faces, or one of them, is null.</exception>
        /// <exception cref="FaceBakerException">Memory is short.</exception>
        /// <exception cref="ObjectDisposedException">A face was disposed.</exception>
        public Crowd(IReadOnlyList<Face> faces)
        {
            if (faces == null) throw new ArgumentNullException(nameof(faces));
            int count = faces.Count;
            models = new ModelHandle[count];
            scratches = new Scratch[count];
            controlCounts = new int[count];
            coordinateCounts = new int[count];
            try
            {
                batches = (fb_batch_desc*)Allocate((long)count * sizeof(fb_batch_desc));
                items = (fb_many_item*)Allocate((long)count * sizeof(fb_many_item));
                for (int i = 0; i < count; ++i) batches[i] = fb_batch_desc.Filled();
                for (int i = 0; i < count; ++i) Add(i, faces[i]);
            }
            catch
            {
                Dispose();
                throw;
            }
        }

        /// <summary>Frees what was not disposed.</summary>
        ~Crowd()
        {
            Free();
        }

        /// <summary>How many faces there are.</summary>
        public int Count
        {
            get { return models.Length; }
        }

        /// <summary>The control values of a face, to be written, in the order of <see cref="Face.Controls"/>.</summary>
        /// <exception cref="IndexOutOfRangeException">There is no such face.</exception>
        /// <exception cref="ObjectDisposedException">The crowd was disposed.</exception>
        public Span<float> Controls(int face)
        {
            int count = controlCounts[face];
            RequireAlive();
            return new Span<float>(batches[face].controls, count);
        }

        /// <summary>The positions of a face of the last <see cref="Evaluate"/>: xyz interleaved, in
        /// <see cref="Face.Units"/>.</summary>
        /// <exception cref="IndexOutOfRangeException">There is no such face.</exception>
        /// <exception cref="ObjectDisposedException">The crowd was disposed.</exception>
        public ReadOnlySpan<float> Positions(int face)
        {
            int count = coordinateCounts[face];
            RequireAlive();
            return new ReadOnlySpan<float>(batches[face].positions, count);
        }

        /// <summary>Poses all faces, with the same bits as <see cref="Scratch.Evaluate"/>, on the threads of a scheduler, or
        /// without one on those of OpenMP where the library has it: at most `threads`, 0 for one a face or as many as OpenMP
        /// would use. Allocates nothing.</summary>
        /// <exception cref="ArgumentOutOfRangeException">threads is below 0.</exception>
        /// <exception cref="FaceBakerException">A control is NaN, or the scheduler does not run each task once; the message
        /// names the first such face. The others are posed.</exception>
        /// <exception cref="ObjectDisposedException">The crowd or the scheduler was disposed.</exception>
        public void Evaluate(int threads = 0, ParallelForHandle parallelFor = null)
        {
            if (threads < 0) throw new ArgumentOutOfRangeException(nameof(threads), threads, "It may not be below 0.");
            RequireAlive();
            fb_many_desc desc = fb_many_desc.Filled();
            desc.threads = (uint)threads;
            desc.items = items;
            desc.item_count = (uint)models.Length;
            if (parallelFor != null)
            {
                desc.parallel_for = NativeCallbacks.ParallelForPointer;
                desc.parallel_user = (void*)parallelFor.User;
            }
            int status = Native.fb_evaluate_many(&desc, null);
            if (parallelFor != null) parallelFor.State.Rethrow();
            Native.Check(status);
            GC.KeepAlive(this);
        }

        /// <summary>Frees the memory. May be called again.</summary>
        public void Dispose()
        {
            Free();
            foreach (Scratch scratch in scratches)
                if (scratch != null) scratch.Dispose();
            GC.SuppressFinalize(this);
        }

        private void Add(int i, Face face)
        {
            if (face == null) throw new ArgumentNullException("faces", "Face " + i + " is null.");
            scratches[i] = new Scratch(face);
            controlCounts[i] = face.ControlCount;
            coordinateCounts[i] = 3 * face.VertexCount;
            float* controls = (float*)Allocate((long)sizeof(float) * controlCounts[i]);
            batches[i].controls = controls;
            batches[i].positions = Allocate((long)sizeof(float) * coordinateCounts[i]);
            batches[i].poses = 1;
            batches[i].control_floats = (ulong)controlCounts[i];
            batches[i].position_floats = (ulong)coordinateCounts[i];
            face.RestControls.CopyTo(Controls(i));
            bool added = false;
            face.Handle.DangerousAddRef(ref added);
            models[i] = face.Handle;
            held = i + 1;
            items[i].model = face.Handle.DangerousGetHandle();
            items[i].scratch = scratches[i].Pointer;
            items[i].batch = &batches[i];
        }

        private static void* Allocate(long bytes)
        {
            return (void*)Marshal.AllocHGlobal(new IntPtr(Math.Max(bytes, 1)));
        }

        private void Free()
        {
            if (disposed) return;
            disposed = true;
            for (int i = 0; i < held; ++i) models[i].DangerousRelease();
            for (int i = 0; batches != null && items != null && i < models.Length; ++i)
            {
                Marshal.FreeHGlobal((IntPtr)batches[i].controls);
                Marshal.FreeHGlobal((IntPtr)batches[i].positions);
            }
            Marshal.FreeHGlobal((IntPtr)items);
            Marshal.FreeHGlobal((IntPtr)batches);
        }

        private void RequireAlive()
        {
            if (disposed) throw new ObjectDisposedException(nameof(Crowd));
        }
    }
}
