using System;
using System.Runtime.CompilerServices;
using System.Runtime.InteropServices;

namespace FaceBaker
{
    /// <summary>From a face back to its controls: how points of it move with its controls, and the controls that bring points
    /// where they should be. It has working memory of its own: one a thread. A call with it while another runs is refused. Its
    /// calls allocate nothing. It keeps what it needs of its face, also after that was disposed.</summary>
    public sealed unsafe class Solver : IDisposable
    {
        private const int FrameFloats = 12;
        private readonly SolverHandle handle;
        private readonly int controls;

        /// <summary>A solver of all vertices, or of what the options say. Takes some milliseconds, and a tenth of a second for
        /// all vertices of a large face.</summary>
        /// <exception cref="ArgumentNullException">face is null.</exception>
        /// <exception cref="ArgumentException">An array has the wrong length.</exception>
        /// <exception cref="FaceBakerException">There is no such vertex, point, socket or joint, a weight is not finite, or
        /// memory is short; the message says which.</exception>
        /// <exception cref="ObjectDisposedException">The face was disposed.</exception>
        public Solver(Face face, SolverOptions options = null)
        {
            if (face == null) throw new ArgumentNullException(nameof(face));
            if (options == null) options = new SolverOptions();
            Face = face;
            controls = face.ControlCount;
            PairCount = CountOf(options.Pairs, 2, nameof(options.Pairs));
            FrameCount = CountOf(options.Sockets, 1, "") + CountOf(options.Joints, 1, "");
            int points = CountOf(options.PointVertices, 3, nameof(options.PointVertices));
            if (options.PointWeights != null)
                Demand(options.PointWeights.Length, 3 * points, nameof(options.PointWeights));
            handle = Create(face, options, points);
            PointCount = (int)Native.fb_solver_point_count(handle);
            RowCount = (int)Native.fb_solver_row_count(handle);
        }

        private SolverHandle Create(Face face, SolverOptions options, int points)
        {
            fb_solver_desc desc = fb_solver_desc.Filled();
            uint nothing = 0;
            SolverHandle made;
            fixed (uint* vertices = options.PointVertices, pairs = options.Pairs, sockets = options.Sockets,
                   joints = options.Joints)
            fixed (float* weights = options.PointWeights)
            {
                // Null says that every vertex is a point; an array without elements, that none is.
                desc.point_vertices = options.PointVertices != null && points == 0 ? &nothing : vertices;
                desc.point_count = (uint)points;
                desc.point_weights = weights;
                desc.pairs = pairs;
                desc.pair_count = (uint)PairCount;
                desc.sockets = sockets;
                desc.socket_count = (uint)CountOf(options.Sockets, 1, "");
                desc.joints = joints;
                desc.joint_count = (uint)CountOf(options.Joints, 1, "");
                desc.lod = options.Lod;
                Native.Check(Native.fb_solver_create(face.Handle, &desc, out made));
            }
            return made;
        }

        /// <summary>The face.</summary>
        public Face Face { get; private set; }

        /// <summary>Its points.</summary>
        public int PointCount { get; private set; }

        /// <summary>Its pairs of points.</summary>
        public int PairCount { get; private set; }

        /// <summary>Its frames, of sockets and then of joints.</summary>
        public int FrameCount { get; private set; }

        /// <summary>The numbers that it follows: 3 a point, then 12 a frame.</summary>
        public int RowCount { get; private set; }

        /// <summary>Finds the derivatives of what is followed by the controls. Allocates nothing.</summary>
        /// <exception cref="ArgumentException">A span has the wrong length.</exception>
        /// <exception cref="FaceBakerException">A control is NaN; there is no such control to choose, or they do not ascend;
        /// a buffer is too small, with <see cref="Status.Limit"/> that of the sparse output; or another thread uses this
        /// solver.</exception>
        public void Jacobian(in PoseJacobian pose)
        {
            Demand(pose.Controls.Length, controls, nameof(pose.Controls));
            DemandOrNone(pose.Downwards.Length, controls, nameof(pose.Downwards));
            DemandOrNone(pose.Values.Length, RowCount, nameof(pose.Values));
            int chosenCount = pose.Chosen.Length > 0 ? pose.Chosen.Length : controls;
            DemandOrNone(pose.ColumnStarts.Length, chosenCount + 1, nameof(pose.ColumnStarts));
            Demand(pose.ColumnValues.Length, pose.ColumnRows.Length, nameof(pose.ColumnValues));
            fb_jacobian_desc desc = fb_jacobian_desc.Filled();
            fixed (float* from = &MemoryMarshal.GetReference(pose.Controls),
                   values = &MemoryMarshal.GetReference(pose.Values),
                   derivatives = &MemoryMarshal.GetReference(pose.Derivatives),
                   columnValues = &MemoryMarshal.GetReference(pose.ColumnValues))
            fixed (uint* chosen = &MemoryMarshal.GetReference(pose.Chosen),
                   columnRows = &MemoryMarshal.GetReference(pose.ColumnRows))
            fixed (bool* downwards = &MemoryMarshal.GetReference(pose.Downwards))
            fixed (ulong* columnStarts = &MemoryMarshal.GetReference(pose.ColumnStarts))
            {
                desc.controls = from;
                desc.chosen_count = (uint)pose.Chosen.Length;
                desc.chosen = (uint*)Or(chosen, pose.Chosen.Length);
                desc.downwards = (byte*)Or(downwards, pose.Downwards.Length);
                desc.values = (float*)Or(values, pose.Values.Length);
                desc.derivatives = (float*)Or(derivatives, pose.Derivatives.Length);
                desc.derivative_floats = (ulong)pose.Derivatives.Length;
                desc.column_starts = (ulong*)Or(columnStarts, pose.ColumnStarts.Length);
                desc.column_rows = (uint*)Or(columnRows, pose.ColumnRows.Length);
                desc.column_values = (float*)Or(columnValues, pose.ColumnValues.Length);
                desc.column_entries = (ulong)pose.ColumnRows.Length;
                Native.Check(Native.fb_jacobian(handle, &desc));
            }
        }

        /// <summary>Finds controls for targets: a clip frame after frame, each from that before it. Allocates nothing.</summary>
        /// <exception cref="ArgumentException">A span has the wrong length.</exception>
        /// <exception cref="FaceBakerException">A target is infinite or farther than 10^6 of the diagonal, a control NaN, a
        /// weight or preference negative or not finite; <see cref="SolveTargets.ToFace"/> does not scale alike in all
        /// directions; or another thread uses this solver. The message says which; nothing was written then.</exception>
        public SolveResult Solve(in SolveTargets targets)
        {
            DemandLengths(in targets);
            fb_solve_desc desc = fb_solve_desc.Filled();
            Describe(in targets, &desc);
            fb_solve_result result = fb_solve_result.Filled();
            fixed (float* found = &MemoryMarshal.GetReference(targets.Controls),
                   points = &MemoryMarshal.GetReference(targets.Points),
                   pointWeights = &MemoryMarshal.GetReference(targets.PointWeights),
                   distances = &MemoryMarshal.GetReference(targets.Distances),
                   distanceWeights = &MemoryMarshal.GetReference(targets.DistanceWeights),
                   frames = &MemoryMarshal.GetReference(targets.Frames),
                   frameWeights = &MemoryMarshal.GetReference(targets.FrameWeights),
                   near = &MemoryMarshal.GetReference(targets.Near), before = &MemoryMarshal.GetReference(targets.Before),
                   motion = &MemoryMarshal.GetReference(targets.Motion),
                   decided = &MemoryMarshal.GetReference(targets.Decided),
                   differences = &MemoryMarshal.GetReference(targets.PointDifferences))
            fixed (bool* movable = &MemoryMarshal.GetReference(targets.Movable))
            {
                desc.controls = found;
                desc.points = (float*)Or(points, targets.Points.Length);
                desc.point_weights = (float*)Or(pointWeights, targets.PointWeights.Length);
                desc.distances = (float*)Or(distances, targets.Distances.Length);
                desc.distance_weights = (float*)Or(distanceWeights, targets.DistanceWeights.Length);
                desc.frames = (float*)Or(frames, targets.Frames.Length);
                desc.frame_weights = (float*)Or(frameWeights, targets.FrameWeights.Length);
                desc.near_controls = (float*)Or(near, targets.Near.Length);
                desc.before = (float*)Or(before, targets.Before.Length);
                desc.movable = (byte*)Or(movable, targets.Movable.Length);
                desc.motion = (float*)Or(motion, targets.Motion.Length);
                desc.decided = (float*)Or(decided, targets.Decided.Length);
                desc.point_differences = (float*)Or(differences, targets.PointDifferences.Length);
                Native.Check(Native.fb_solve(handle, &desc, &result));
            }
            return new SolveResult(in result);
        }

        private void DemandLengths(in SolveTargets targets)
        {
            Demand(targets.Controls.Length, controls, nameof(targets.Controls));
            DemandOrNone(targets.Points.Length, 3 * PointCount, nameof(targets.Points));
            DemandOrNone(targets.PointWeights.Length, PointCount, nameof(targets.PointWeights));
            DemandOrNone(targets.Distances.Length, PairCount, nameof(targets.Distances));
            DemandOrNone(targets.DistanceWeights.Length, PairCount, nameof(targets.DistanceWeights));
            DemandOrNone(targets.Frames.Length, FrameFloats * FrameCount, nameof(targets.Frames));
            DemandOrNone(targets.FrameWeights.Length, FrameCount, nameof(targets.FrameWeights));
            DemandOrNone(targets.ToFace.Length, FrameFloats, nameof(targets.ToFace));
            Demand(targets.Motion.Length, targets.FindMotion ? FrameFloats : 0, nameof(targets.Motion));
            DemandOrNone(targets.Near.Length, controls, nameof(targets.Near));
            DemandOrNone(targets.Before.Length, controls, nameof(targets.Before));
            DemandOrNone(targets.Movable.Length, controls, nameof(targets.Movable));
            DemandOrNone(targets.Decided.Length, controls, nameof(targets.Decided));
            DemandOrNone(targets.PointDifferences.Length, PointCount, nameof(targets.PointDifferences));
        }

        // All but the pointers.
        private static void Describe(in SolveTargets targets, fb_solve_desc* desc)
        {
            if (targets.MaxIterations < 0)
                throw new ArgumentOutOfRangeException(nameof(targets.MaxIterations), targets.MaxIterations, "It is below 0.");
            desc->max_iterations = (uint)targets.MaxIterations;
            desc->relative = targets.Relative ? 1u : 0u;
            desc->find_motion = targets.FindMotion ? 1u : 0u;
            for (int i = 0; i < targets.ToFace.Length; ++i) desc->to_face[i] = targets.ToFace[i];
            desc->noise = targets.Noise;
            desc->nearness = targets.Nearness;
            desc->sparsity = targets.Sparsity;
            desc->smoothness = targets.Smoothness;
            desc->symmetry = targets.Symmetry;
            desc->tolerance = targets.Tolerance;
        }

        // Null for an empty span, whose reference may be any.
        private static void* Or(void* pointer, int length)
        {
            return length > 0 ? pointer : null;
        }

        private static int CountOf<T>(T[] array, int each, string name)
        {
            int length = array == null ? 0 : array.Length;
            if (length % each != 0) throw new ArgumentException(length + " numbers, not " + each + " each.", name);
            return length / each;
        }

        private static void DemandOrNone(int length, int expected, string name)
        {
            if (length != 0) Demand(length, expected, name);
        }

        private static void Demand(int length, int expected, string name)
        {
            if (length != expected) WrongLength(length, expected, name);
        }

        [MethodImpl(MethodImplOptions.NoInlining)]
        private static void WrongLength(int length, int expected, string name)
        {
            throw new ArgumentException("There are " + length + " numbers in place of " + expected + ".", name);
        }

        /// <summary>Frees the memory. May be called again; other calls fail with ObjectDisposedException afterwards. A solver
        /// that is not disposed is freed by the garbage collector.</summary>
        public void Dispose()
        {
            handle.Dispose();
        }
    }
}
