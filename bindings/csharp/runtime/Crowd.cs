using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace FaceBaker
{
    /// <summary>Faces of any kinds that one call poses, each on one thread: write their <see cref="Controls"/>, call
    /// <see cref="Evaluate"/>, read their <see cref="Positions"/>. Working memory belongs to its threads, for each kind of face:
    /// a face takes none but its controls and outputs. Its numbers lie in memory of their own, which the garbage collector does
    /// not move. For one thread at a time. It keeps what it needs of its faces, also after those were disposed.</summary>
    public sealed unsafe class Crowd : IDisposable
    {
        private readonly ModelHandle[] models;
        private readonly int[] controlCounts;
        private readonly int[][] levelVertices; // of each face, the vertices of its levels
        private readonly int workers;
        private readonly List<Scratch> scratches = new List<Scratch>(); // one a kind of face
        private readonly fb_batch_desc* batches;
        private readonly fb_many_item* items;
        private readonly ulong* clamped;
        private readonly IntPtr* shared; // the library's scratches
        private int held;
        private bool disposed;

        /// <summary>A crowd of these faces, all at rest; a face may come several times. Those that take longest are best
        /// first, as threads take them in their order. threads: on how many it poses at most; 0: one a processor.</summary>
        /// <exception cref="ArgumentNullException">faces, or one of them, is null.</exception>
        /// <exception cref="ArgumentOutOfRangeException">threads is below 0.</exception>
        /// <exception cref="FaceBakerException">Memory is short.</exception>
        /// <exception cref="ObjectDisposedException">A face was disposed.</exception>
        public Crowd(IReadOnlyList<Face> faces, int threads = 0)
        {
            if (faces == null) throw new ArgumentNullException(nameof(faces));
            RequireThreads(threads);
            int count = faces.Count;
            workers = Math.Max(1, Math.Min(count, threads > 0 ? threads : Environment.ProcessorCount));
            models = new ModelHandle[count];
            controlCounts = new int[count];
            levelVertices = new int[count][];
            try
            {
                batches = (fb_batch_desc*)Allocate((long)count * sizeof(fb_batch_desc));
                items = (fb_many_item*)Allocate((long)count * sizeof(fb_many_item));
                clamped = (ulong*)Allocate((long)count * sizeof(ulong));
                shared = (IntPtr*)Allocate((long)count * sizeof(IntPtr));
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
            RequireFace(face);
            return new Span<float>(batches[face].controls, controlCounts[face]);
        }

        /// <summary>The positions of a face of the last <see cref="Evaluate"/> that posed it: xyz interleaved, in
        /// <see cref="Face.Units"/>; see <see cref="SetLod"/>.</summary>
        /// <exception cref="IndexOutOfRangeException">There is no such face.</exception>
        /// <exception cref="ObjectDisposedException">The crowd was disposed.</exception>
        public ReadOnlySpan<float> Positions(int face)
        {
            RequireFace(face);
            return new ReadOnlySpan<float>(batches[face].positions, 3 * WrittenVertices(face));
        }

        /// <summary>Its unit normals, laid out like positions; empty where they are not computed.</summary>
        /// <exception cref="IndexOutOfRangeException">There is no such face.</exception>
        /// <exception cref="ObjectDisposedException">The crowd was disposed.</exception>
        public ReadOnlySpan<float> Normals(int face)
        {
            RequireFace(face);
            int numbers = batches[face].normals == null ? 0 : 3 * WrittenVertices(face);
            return new ReadOnlySpan<float>(batches[face].normals, numbers);
        }

        /// <summary>Whether normals of a face are computed from the next <see cref="Evaluate"/> on; they are not at
        /// first.</summary>
        /// <exception cref="IndexOutOfRangeException">There is no such face.</exception>
        /// <exception cref="ObjectDisposedException">The crowd was disposed.</exception>
        public void SetNormals(int face, bool computed)
        {
            RequireFace(face);
            int numbers = 3 * levelVertices[face][0];
            if (computed == (batches[face].normals != null)) return;
            void* before = batches[face].normals;
            batches[face].normals = computed ? Allocate((long)sizeof(float) * numbers) : null;
            batches[face].normal_numbers = computed ? (ulong)numbers : 0;
            if (computed) new Span<float>(batches[face].normals, numbers).Clear();
            Marshal.FreeHGlobal((IntPtr)before);
        }

        /// <summary>The level of detail of a face: 0, the whole, at first; see <see cref="PoseBatch.Lod"/>. levelOnly: positions
        /// and normals are those of the vertices of the level that it is rounded down to, in baked order (<see
        /// cref="Face.VertexOrder"/>), which takes less time; else of all vertices, in the source's order.</summary>
        /// <exception cref="ArgumentOutOfRangeException">lod is below 0 or no number.</exception>
        /// <exception cref="IndexOutOfRangeException">There is no such face.</exception>
        /// <exception cref="ObjectDisposedException">The crowd was disposed.</exception>
        public void SetLod(int face, float lod, bool levelOnly = false)
        {
            if (!(lod >= 0)) throw new ArgumentOutOfRangeException(nameof(lod), lod, "It may not be below 0.");
            RequireFace(face);
            batches[face].lod = Math.Min(lod, levelVertices[face].Length - 1);
            batches[face].level_only = levelOnly ? 1u : 0u;
            batches[face].vertex_order = (uint)(levelOnly ? Native.FB_ORDER_BAKED : Native.FB_ORDER_SOURCE);
        }

        /// <summary>The level of detail of a face.</summary>
        /// <exception cref="IndexOutOfRangeException">There is no such face.</exception>
        /// <exception cref="ObjectDisposedException">The crowd was disposed.</exception>
        public float Lod(int face)
        {
            RequireFace(face);
            return batches[face].lod;
        }

        /// <summary>Whether somebody sees a face; all are seen at first. One that is not is left out: it keeps its last
        /// pose.</summary>
        /// <exception cref="IndexOutOfRangeException">There is no such face.</exception>
        /// <exception cref="ObjectDisposedException">The crowd was disposed.</exception>
        public void SetSeen(int face, bool seen)
        {
            RequireFace(face);
            batches[face].poses = seen ? 1u : 0u;
        }

        /// <summary>Control values of a face that the last <see cref="Evaluate"/> clamped to their ranges.</summary>
        /// <exception cref="IndexOutOfRangeException">There is no such face.</exception>
        /// <exception cref="ObjectDisposedException">The crowd was disposed.</exception>
        public long ClampedCount(int face)
        {
            RequireFace(face);
            return (long)clamped[face];
        }

        /// <summary>Poses all faces that are seen, with the same bits as <see cref="Scratch.Evaluate"/>, on the threads of a
        /// scheduler, or without one on those of OpenMP where the library has it: at most `threads`, and not more than the
        /// crowd has; 0 for as many as it has, or as OpenMP would use. Allocates nothing.</summary>
        /// <exception cref="ArgumentOutOfRangeException">threads is below 0.</exception>
        /// <exception cref="FaceBakerException">A control is NaN, or the scheduler does not run each task once; the message
        /// names the first such face. The others are posed.</exception>
        /// <exception cref="ObjectDisposedException">The crowd or the scheduler was disposed.</exception>
        public void Evaluate(int threads = 0, ParallelForHandle parallelFor = null)
        {
            RequireThreads(threads);
            RequireAlive();
            fb_many_desc desc = fb_many_desc.Filled();
            desc.threads = (uint)Math.Min(threads, workers);
            desc.items = items;
            desc.item_count = (uint)models.Length;
            desc.scratches = shared;
            desc.scratch_count = (uint)scratches.Count;
            desc.clamped = clamped;
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
            foreach (Scratch scratch in scratches) scratch.Dispose();
            GC.SuppressFinalize(this);
        }

        private void Add(int i, Face face)
        {
            if (face == null) throw new ArgumentNullException("faces", "Face " + i + " is null.");
            int same = Array.IndexOf(models, face.Handle, 0, i);
            if (same < 0)
            {
                var scratch = new Scratch(face, workers, false);
                shared[scratches.Count] = scratch.Pointer;
                scratches.Add(scratch);
            }
            levelVertices[i] = same < 0 ? LevelVertices(face.Handle) : levelVertices[same];
            controlCounts[i] = face.ControlCount;
            int coordinates = 3 * face.VertexCount;
            batches[i].controls = (float*)Allocate((long)sizeof(float) * controlCounts[i]);
            batches[i].positions = Allocate((long)sizeof(float) * coordinates);
            batches[i].poses = 1;
            batches[i].control_floats = (ulong)controlCounts[i];
            batches[i].position_floats = (ulong)coordinates;
            face.RestControls.CopyTo(new Span<float>(batches[i].controls, controlCounts[i]));
            bool added = false;
            face.Handle.DangerousAddRef(ref added);
            models[i] = face.Handle;
            held = i + 1;
            items[i].model = face.Handle.DangerousGetHandle();
            items[i].scratch = IntPtr.Zero;
            items[i].batch = &batches[i];
            clamped[i] = 0;
        }

        private static int[] LevelVertices(ModelHandle model)
        {
            var vertices = new int[Native.fb_level_count(model)];
            for (int i = 0; i < vertices.Length; ++i)
            {
                fb_level level = fb_level.Filled();
                Native.Check(Native.fb_level_at(model, (uint)i, &level));
                vertices[i] = (int)level.vertex_count;
            }
            return vertices;
        }

        private int WrittenVertices(int face)
        {
            return levelVertices[face][batches[face].level_only == 0 ? 0 : (int)batches[face].lod];
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
            for (int i = 0; batches != null && items != null && clamped != null && shared != null && i < models.Length; ++i)
            {
                Marshal.FreeHGlobal((IntPtr)batches[i].controls);
                Marshal.FreeHGlobal((IntPtr)batches[i].positions);
                Marshal.FreeHGlobal((IntPtr)batches[i].normals);
            }
            Marshal.FreeHGlobal((IntPtr)shared);
            Marshal.FreeHGlobal((IntPtr)clamped);
            Marshal.FreeHGlobal((IntPtr)items);
            Marshal.FreeHGlobal((IntPtr)batches);
        }

        private static void RequireThreads(int threads)
        {
            if (threads < 0) throw new ArgumentOutOfRangeException(nameof(threads), threads, "It may not be below 0.");
        }

        private void RequireFace(int face)
        {
            if (face < 0 || face >= models.Length) throw new IndexOutOfRangeException("There is no face " + face + ".");
            RequireAlive();
        }

        private void RequireAlive()
        {
            if (disposed) throw new ObjectDisposedException(nameof(Crowd));
        }
    }
}
