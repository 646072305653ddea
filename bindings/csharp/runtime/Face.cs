using System;
using System.Collections.Generic;
using System.IO;
using System.Runtime.InteropServices;

namespace FaceBaker
{
    /// <summary>A baked face, loaded from an .fbk archive. It never changes; any number of threads may pose one face at once.
    /// Its lists and arrays are copied from the library when they are first asked for, so they stay valid after it is
    /// disposed. Disposing frees the memory at once; a face that is not disposed is freed by the garbage collector.</summary>
    public sealed unsafe partial class Face : IDisposable
    {
        private const int StreamBufferBytes = 64 << 10;
        private readonly ScratchPool singles = new ScratchPool(false), several = new ScratchPool(true);

        private Face(ModelHandle handle)
        {
            Handle = handle;
            VertexCount = (int)Native.fb_vertex_count(handle);
            ControlCount = (int)Native.fb_control_count(handle);
            CoefficientCount = (int)Native.fb_coefficient_count(handle);
            Name = Native.Text(Native.fb_name(handle));
            Units = Native.Text(Native.fb_units(handle));
            UpAxis = Native.Text(Native.fb_up_axis(handle));
            Diagonal = Native.fb_diagonal(handle);
            GC.KeepAlive(handle); // until its strings are copied
        }

        internal ModelHandle Handle { get; private set; }

        /// <summary>The version of libfacebaker, "major.minor.patch".</summary>
        public static string LibraryVersion
        {
            get { return Native.Text(Native.fb_version_string()); }
        }

        /// <summary>Loads an archive from a file. Files from strangers are safe.</summary>
        /// <exception cref="FaceBakerException">There is no such file; it cannot be read; it is no archive, damaged, of another
        /// version or larger than the options allow. The message says which.</exception>
        /// <exception cref="DllNotFoundException">libfacebaker is not found.</exception>
        public static Face Load(string path, LoadOptions options = null)
        {
            byte[] utf8 = Native.Utf8(path, nameof(path));
            return Load(new LoadState(), options, (fb_load_desc* desc, LoadState state, out ModelHandle model) =>
            {
                fixed (byte* name = utf8) return Native.fb_load(name, desc, out model);
            });
        }

        /// <summary>The same from the bytes of an archive, which are not needed after the call.</summary>
        public static Face Load(byte[] bytes, LoadOptions options = null)
        {
            if (bytes == null) throw new ArgumentNullException(nameof(bytes));
            return Load(new LoadState(), options, (fb_load_desc* desc, LoadState state, out ModelHandle model) =>
            {
                byte nothing = 0;
                fixed (byte* first = bytes)
                    return Native.fb_load_memory(first == null ? &nothing : first, (UIntPtr)bytes.Length, desc, out model);
            });
        }

        /// <summary>The same from a stream, which is read from where it is to the archive's end and not beyond, and not
        /// closed.</summary>
        public static Face Load(Stream stream, LoadOptions options = null)
        {
            if (stream == null) throw new ArgumentNullException(nameof(stream));
            var reading = new LoadState { Stream = stream, Buffer = new byte[StreamBufferBytes] };
            return Load(reading, options, (fb_load_desc* desc, LoadState state, out ModelHandle model) =>
            {
                GCHandle user = GCHandle.Alloc(state);
                try
                {
                    return Native.fb_load_stream(NativeCallbacks.ReadPointer, (void*)GCHandle.ToIntPtr(user), desc, out model);
                }
                finally
                {
                    user.Free();
                }
            });
        }

        private delegate int Loader(fb_load_desc* desc, LoadState state, out ModelHandle model);

        private static Face Load(LoadState state, LoadOptions options, Loader loader)
        {
            fb_load_desc desc = (options ?? new LoadOptions()).Described();
            GCHandle logUser = default(GCHandle);
            if (options != null && options.Note != null)
            {
                state.Note = options.Note;
                logUser = GCHandle.Alloc(state);
                desc.log = NativeCallbacks.LogPointer;
                desc.log_user = (void*)GCHandle.ToIntPtr(logUser);
            }
            ModelHandle model = null;
            try
            {
                int status = loader(&desc, state, out model);
                state.Rethrow();
                Native.Check(status);
                return new Face(model);
            }
            catch
            {
                if (model != null) model.Dispose();
                throw;
            }
            finally
            {
                if (logUser.IsAllocated) logUser.Free();
            }
        }

        /// <summary>Vertices of the mesh.</summary>
        public int VertexCount { get; private set; }

        /// <summary>Floats in a pose.</summary>
        public int ControlCount { get; private set; }

        /// <summary>Columns of the basis; see <see cref="Scratch.EvaluateCoefficients"/>.</summary>
        public int CoefficientCount { get; private set; }

        /// <summary>Name of the character.</summary>
        public string Name { get; private set; }

        /// <summary>Of positions: "cm", "m", ...</summary>
        public string Units { get; private set; }

        /// <summary>"y" or "z". Axes are right-handed.</summary>
        public string UpAxis { get; private set; }

        /// <summary>Length of the diagonal of the rest mesh's bounding box, in units.</summary>
        public double Diagonal { get; private set; }

        /// <summary>Bytes of memory that the model takes to evaluate poses, without scratches.</summary>
        public long RuntimeBytes
        {
            get { return (long)Native.fb_runtime_bytes(Handle); }
        }

        /// <summary>The instruction set that poses are evaluated with, such as "avx2". Results do not depend on it.</summary>
        public string InstructionSet
        {
            get { return Native.Text(Native.fb_instruction_set(Handle)); }
        }

        /// <summary>The index of a control by its name, or else its ARKit name, or else its FACS name.</summary>
        /// <exception cref="FaceBakerException">There is none; the message has the closest name.</exception>
        public int FindControl(string name)
        {
            return Find(name, Native.fb_find_control);
        }

        /// <summary>The index of a control by the hash of its name, as <c>facebaker header</c> writes it.</summary>
        /// <exception cref="FaceBakerException">There is none.</exception>
        public int FindControl(ulong hash)
        {
            uint index;
            Native.Check(Native.fb_find_control_hash(Handle, hash, &index));
            return (int)index;
        }

        /// <summary>Blends two poses as controls, from at share 0 and to at 1, clamped to their ranges. An empty `to` is the
        /// mirror of `from`. `blended` may be either.</summary>
        /// <exception cref="ArgumentException">A pose has too few values.</exception>
        /// <exception cref="FaceBakerException">A control or the share is NaN.</exception>
        public void Blend(ReadOnlySpan<float> from, ReadOnlySpan<float> to, float share, Span<float> blended)
        {
            RequirePose(from.Length, nameof(from));
            if (to.Length > 0) RequirePose(to.Length, nameof(to));
            RequirePose(blended.Length, nameof(blended));
            fixed (float* first = from, second = to, result = blended)
                Native.Check(Native.fb_blend_controls(Handle, first, to.Length > 0 ? second : null, share, result));
        }

        /// <summary>The index of a mesh by its name.</summary>
        /// <exception cref="FaceBakerException">There is none; the message has those there are.</exception>
        public int FindMesh(string name)
        {
            return Find(name, Native.fb_find_mesh);
        }

        /// <summary>The index of a socket by its name.</summary>
        /// <exception cref="FaceBakerException">There is none; the message has those there are.</exception>
        public int FindSocket(string name)
        {
            return Find(name, Native.fb_find_socket);
        }

        /// <summary>The index of a channel by its name.</summary>
        /// <exception cref="FaceBakerException">There is none; the message has those there are.</exception>
        public int FindChannel(string name)
        {
            return Find(name, Native.fb_find_channel);
        }

        /// <summary>The index of a joint by its name.</summary>
        /// <exception cref="FaceBakerException">There is none; the message has those there are.</exception>
        public int FindJoint(string name)
        {
            return Find(name, Native.fb_find_joint);
        }

        /// <summary>The index of a driven joint by its name.</summary>
        /// <exception cref="FaceBakerException">There is none; the message has those there are.</exception>
        public int FindDrivenJoint(string name)
        {
            return Find(name, Native.fb_find_driven_joint);
        }

        private delegate int Finder(ModelHandle model, byte* name, uint* index);

        private void RequirePose(int length, string name)
        {
            if (length < ControlCount)
                throw new ArgumentException(length + " values, but a pose has " + ControlCount + ".", name);
        }

        private int Find(string name, Finder finder)
        {
            byte[] utf8 = Native.Utf8(name, nameof(name));
            uint index;
            fixed (byte* text = utf8) Native.Check(finder(Handle, text, &index));
            return (int)index;
        }

        /// <summary>One pose, with a scratch that nobody else uses: see <see cref="Scratch.Evaluate"/>. From any thread;
        /// allocates nothing, but where more threads pose at once than ever before.</summary>
        public void Evaluate(ReadOnlySpan<float> controls, Span<float> positions)
        {
            Scratch scratch = singles.Take(this);
            try
            {
                scratch.Evaluate(controls, positions);
            }
            finally
            {
                singles.Give(scratch);
            }
        }

        /// <summary>The same with all that a batch can give: see <see cref="Scratch.EvaluateBatch"/>. Runs on the calling
        /// thread; for more threads use a <see cref="Scratch"/> with as many workers.</summary>
        public void EvaluateBatch(in PoseBatch batch)
        {
            ScratchPool scratches = batch.Poses > 1 ? several : singles;
            Scratch scratch = scratches.Take(this);
            try
            {
                scratch.EvaluateBatch(in batch);
            }
            finally
            {
                scratches.Give(scratch);
            }
        }

        /// <summary>Frees the memory, but for what scratches of one's own keep until they are disposed. May be called again.
        /// What is not copied yet fails with ObjectDisposedException afterwards.</summary>
        public void Dispose()
        {
            Handle.Dispose();
            singles.Close();
            several.Close();
        }
    }
}
