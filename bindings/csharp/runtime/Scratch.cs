using System;
using System.Runtime.CompilerServices;
using System.Runtime.InteropServices;

namespace FaceBaker
{
    /// <summary>Working memory of evaluations: one a thread, for any number of characters that share a face. A call with it while another runs is refused. Evaluating allocates
    /// nothing. It keeps what it needs of its face, also after that was disposed.</summary>
    public sealed unsafe class Scratch : IDisposable
    {
        private readonly ModelHandle model;
        private readonly ScratchHandle handle;
        private readonly int controls, coordinates;

        /// <summary>A scratch for single poses of a face; batches have the same bits, in more time.</summary>
        /// <exception cref="ArgumentNullException">face is null.</exception>
        /// <exception cref="FaceBakerException">Memory is short.</exception>
        /// <exception cref="ObjectDisposedException">The face was disposed.</exception>
        public Scratch(Face face) : this(face, 1, false)
        {
        }

        /// <summary>A scratch for batches, on up to so many threads at once, in about four times the memory for each.</summary>
        /// <exception cref="ArgumentNullException">face is null.</exception>
        /// <exception cref="ArgumentOutOfRangeException">workers is below 1.</exception>
        /// <exception cref="FaceBakerException">Memory is short.</exception>
        /// <exception cref="ObjectDisposedException">The face was disposed.</exception>
        public Scratch(Face face, int workers) : this(face, workers, true)
        {
        }

        // several: with room to evaluate several poses together.
        internal Scratch(Face face, int workers, bool several)
        {
            if (face == null) throw new ArgumentNullException(nameof(face));
            if (workers < 1) throw new ArgumentOutOfRangeException(nameof(workers), workers, "There is at least one worker.");
            Face = face;
            model = face.Handle;
            controls = face.ControlCount;
            coordinates = 3 * face.VertexCount;
            Native.Check(several ? Native.fb_scratch_create(model, (uint)workers, out handle)
                                 : Native.fb_scratch_create_single(model, (uint)workers, out handle));
        }

        /// <summary>The face that it poses.</summary>
        public Face Face { get; private set; }

        /// <summary>The library's scratch, as long as this object is kept and not disposed.</summary>
        internal IntPtr Pointer
        {
            get { return handle.DangerousGetHandle(); }
        }

        /// <summary>Control values that the last evaluation clamped to their ranges, over all poses of a batch.</summary>
        public long ClampedCount
        {
            get { return (long)Native.fb_clamped_count(handle); }
        }

        /// <summary>One pose, on the calling thread. controls: <see cref="Face.ControlCount"/> floats in the order of
        /// <see cref="Face.Controls"/>; what is outside of a control's range is clamped to it. positions: 3 x
        /// <see cref="Face.VertexCount"/> floats, xyz interleaved, in <see cref="Face.Units"/>. Allocates nothing.</summary>
        /// <exception cref="ArgumentException">A span has the wrong length.</exception>
        /// <exception cref="FaceBakerException">A control is NaN; or another thread uses this scratch.</exception>
        public void Evaluate(ReadOnlySpan<float> controls, Span<float> positions)
        {
            if (controls.Length != this.controls) WrongLength(nameof(controls), controls.Length, this.controls);
            if (positions.Length != coordinates) WrongLength(nameof(positions), positions.Length, coordinates);
            fixed (float* from = &MemoryMarshal.GetReference(controls), to = &MemoryMarshal.GetReference(positions))
                Native.Check(Native.fb_evaluate(model, handle, from, to));
        }

        /// <summary>The coefficients of a pose alone, for hosts whose GPU moves the vertices: <see
        /// cref="Face.CoefficientCount"/> floats.</summary>
        /// <exception cref="ArgumentException">A span has the wrong length.</exception>
        /// <exception cref="FaceBakerException">A control is NaN; or another thread uses this scratch.</exception>
        public void EvaluateCoefficients(ReadOnlySpan<float> controls, Span<float> coefficients)
        {
            if (controls.Length != this.controls) WrongLength(nameof(controls), controls.Length, this.controls);
            if (coefficients.Length != Face.CoefficientCount)
                WrongLength(nameof(coefficients), coefficients.Length, Face.CoefficientCount);
            fixed (float* from = &MemoryMarshal.GetReference(controls), to = &MemoryMarshal.GetReference(coefficients))
                Native.Check(Native.fb_evaluate_coefficients(model, handle, from, to));
        }

        /// <summary>What error to expect of a pose, without posing it. errors: 1 + <see cref="Face.ErrorRegions"/> floats, in
        /// units: the root mean square distance of the face's vertices from the rig's, then of each region's. Returns how many
        /// controls are outside of what was trained.</summary>
        /// <exception cref="ArgumentException">A span has the wrong length.</exception>
        /// <exception cref="FaceBakerException">The face has no expected errors; a control is NaN.</exception>
        public int ExpectedError(ReadOnlySpan<float> controls, Span<float> errors)
        {
            if (controls.Length != this.controls) WrongLength(nameof(controls), controls.Length, this.controls);
            if (errors.Length != 1 + Face.ErrorRegions.Count)
                WrongLength(nameof(errors), errors.Length, 1 + Face.ErrorRegions.Count);
            uint outside;
            fixed (float* from = &MemoryMarshal.GetReference(controls), to = &MemoryMarshal.GetReference(errors))
                Native.Check(Native.fb_expected_error(model, handle, from, to, &outside));
            return (int)outside;
        }

        /// <summary>Many poses, or one with normals, tangents, sockets, levels of detail, ... Each has the same bits as by
        /// <see cref="Evaluate"/>. Allocates nothing.</summary>
        /// <exception cref="FaceBakerException">A buffer is too small, a number is not allowed, or a control is NaN; the
        /// message names it. Nothing was written then.</exception>
        public void EvaluateBatch(in PoseBatch batch)
        {
            bool half = batch.HalfPositions.Length + batch.HalfNormals.Length + batch.HalfTangents.Length > 0;
            if (half && batch.Positions.Length + batch.Normals.Length + batch.Tangents.Length > 0)
                throw new ArgumentException("Positions, normals and tangents are all floats or all halves.", nameof(batch));
            fb_batch_desc desc = fb_batch_desc.Filled();
            Describe(in batch, half, ref desc);
            fixed (float* controls = &MemoryMarshal.GetReference(batch.Controls),
                   positions = &MemoryMarshal.GetReference(batch.Positions),
                   normals = &MemoryMarshal.GetReference(batch.Normals),
                   tangents = &MemoryMarshal.GetReference(batch.Tangents), sockets = &MemoryMarshal.GetReference(batch.Sockets),
                   channels = &MemoryMarshal.GetReference(batch.Channels), bounds = &MemoryMarshal.GetReference(batch.Bounds),
                   errors = &MemoryMarshal.GetReference(batch.ExpectedErrors),
                   joints = &MemoryMarshal.GetReference(batch.Joints))
            fixed (ushort* halfPositions = &MemoryMarshal.GetReference(batch.HalfPositions),
                   halfNormals = &MemoryMarshal.GetReference(batch.HalfNormals),
                   halfTangents = &MemoryMarshal.GetReference(batch.HalfTangents))
            fixed (uint* outside = &MemoryMarshal.GetReference(batch.Outside),
                   regions = &MemoryMarshal.GetReference(batch.Regions), meshes = &MemoryMarshal.GetReference(batch.Meshes))
            {
                desc.controls = controls;
                desc.positions = half ? Or(halfPositions, batch.HalfPositions.Length) : Or(positions, batch.Positions.Length);
                desc.normals = half ? Or(halfNormals, batch.HalfNormals.Length) : Or(normals, batch.Normals.Length);
                desc.tangents = half ? Or(halfTangents, batch.HalfTangents.Length) : Or(tangents, batch.Tangents.Length);
                desc.sockets = (float*)Or(sockets, batch.Sockets.Length);
                desc.channels = (float*)Or(channels, batch.Channels.Length);
                desc.joints = (float*)Or(joints, batch.Joints.Length);
                desc.bounds = (float*)Or(bounds, batch.Bounds.Length);
                desc.expected_errors = (float*)Or(errors, batch.ExpectedErrors.Length);
                desc.outside = (uint*)Or(outside, batch.Outside.Length);
                uint none;
                desc.regions = batch.WithoutRegions ? &none : (uint*)Or(regions, batch.Regions.Length);
                desc.meshes = (uint*)Or(meshes, batch.Meshes.Length);
                int status = Native.fb_evaluate_batch(model, handle, &desc);
                if (batch.ParallelFor != null) batch.ParallelFor.State.Rethrow();
                Native.Check(status);
            }
        }

        // Null for an empty span, whose reference may be any.
        private static void* Or(void* pointer, int length)
        {
            return length > 0 ? pointer : null;
        }

        // All but the pointers.
        private static void Describe(in PoseBatch batch, bool half, ref fb_batch_desc desc)
        {
            desc.poses = Number(batch.Poses);
            desc.threads = (uint)Number(batch.Threads);
            desc.control_floats = (ulong)batch.Controls.Length;
            desc.control_stride = Number(batch.ControlStride);
            desc.format = half ? Native.FB_FLOAT16 : (uint)Native.FB_FLOAT32;
            desc.position_floats = (ulong)(half ? batch.HalfPositions.Length : batch.Positions.Length);
            desc.pose_stride = Number(batch.PositionPoseStride);
            desc.vertex_stride = Number(batch.PositionVertexStride);
            desc.normal_numbers = (ulong)(half ? batch.HalfNormals.Length : batch.Normals.Length);
            desc.normal_pose_stride = Number(batch.NormalPoseStride);
            desc.normal_vertex_stride = Number(batch.NormalVertexStride);
            desc.tangent_numbers = (ulong)(half ? batch.HalfTangents.Length : batch.Tangents.Length);
            desc.tangent_pose_stride = Number(batch.TangentPoseStride);
            desc.tangent_vertex_stride = Number(batch.TangentVertexStride);
            desc.socket_floats = (ulong)batch.Sockets.Length;
            desc.socket_pose_stride = Number(batch.SocketPoseStride);
            desc.channel_floats = (ulong)batch.Channels.Length;
            desc.channel_pose_stride = Number(batch.ChannelPoseStride);
            desc.joint_floats = (ulong)batch.Joints.Length;
            desc.joint_pose_stride = Number(batch.JointPoseStride);
            desc.expected_error_floats = (ulong)batch.ExpectedErrors.Length;
            desc.expected_error_pose_stride = Number(batch.ExpectedErrorPoseStride);
            if (batch.Outside.Length > 0 && batch.Outside.Length < batch.Poses)
                WrongLength(nameof(batch.Outside), batch.Outside.Length, batch.Poses);
            desc.bounds_floats = (ulong)batch.Bounds.Length;
            desc.bounds_pose_stride = Number(batch.BoundsPoseStride);
            desc.region_count = batch.WithoutRegions ? 0 : (ulong)batch.Regions.Length;
            desc.mesh_count = (ulong)batch.Meshes.Length;
            desc.lod = batch.Lod;
            desc.level_only = batch.LevelOnly ? 1u : 0u;
            desc.vertex_order = (uint)(batch.BakedOrder ? Native.FB_ORDER_BAKED : Native.FB_ORDER_SOURCE);
            desc.displacements = batch.Displacements ? 1u : 0u;
            desc.unskinned = batch.Unskinned ? 1u : 0u;
            if (batch.ParallelFor == null) return;
            desc.parallel_for = NativeCallbacks.ParallelForPointer;
            desc.parallel_user = (void*)batch.ParallelFor.User;
        }

        private static ulong Number(long value)
        {
            if (value < 0) throw new ArgumentOutOfRangeException("batch", value, "Counts and strides may not be below 0.");
            return (ulong)value;
        }

        [MethodImpl(MethodImplOptions.NoInlining)]
        private static void WrongLength(string name, int length, int expected)
        {
            throw new ArgumentException("The span has " + length + " numbers in place of " + expected + ".", name);
        }

        /// <summary>Frees the memory. May be called again; evaluating fails with ObjectDisposedException afterwards. A scratch
        /// that is not disposed is freed by the garbage collector.</summary>
        public void Dispose()
        {
            handle.Dispose();
        }
    }
}
