using System;

namespace FaceBaker
{
    /// <summary>What a pose should come to, what it should be like beside, and where the answer goes. What is minimised is the
    /// sum of ((difference / noise)^2 / 2) x weight over points, distances and frames, and of what nearness, sparsity,
    /// smoothness and symmetry say, with controls in units of their ranges. Spans that are empty are no target, no output, or
    /// weights of 1. A target that has a NaN counts as one with a weight of 0. It is made on the stack and allocates nothing:
    /// <code>SolveResult result = solver.Solve(new SolveTargets(controls) { Points = points });</code></summary>
    public ref struct SolveTargets
    {
        /// <summary>With the library's defaults. controls: <see cref="Face.ControlCount"/> floats: in, where it starts, best the
        /// frame before; out, what was found, within ranges.</summary>
        public SolveTargets(Span<float> controls) : this()
        {
            fb_solve_desc defaults = fb_solve_desc.Filled();
            Controls = controls;
            MaxIterations = (int)defaults.max_iterations;
            Noise = defaults.noise;
            Nearness = defaults.nearness;
            Sparsity = defaults.sparsity;
            Smoothness = defaults.smoothness;
            Symmetry = defaults.symmetry;
            Tolerance = defaults.tolerance;
        }

        /// <summary>Where it starts, and what is found.</summary>
        public Span<float> Controls;
        /// <summary>Where points should be: 3 floats a point.</summary>
        public ReadOnlySpan<float> Points;
        /// <summary>One a point, 0 or more.</summary>
        public ReadOnlySpan<float> PointWeights;
        /// <summary>One a pair, in <see cref="Face.Units"/>.</summary>
        public ReadOnlySpan<float> Distances;
        /// <summary>One a pair.</summary>
        public ReadOnlySpan<float> DistanceWeights;
        /// <summary>12 floats a frame, of sockets and then of joints: three rows of a matrix.</summary>
        public ReadOnlySpan<float> Frames;
        /// <summary>One a frame.</summary>
        public ReadOnlySpan<float> FrameWeights;
        /// <summary>Points are told as how far they should be from where they are at rest.</summary>
        public bool Relative;
        /// <summary>Takes targets of points and frames to the space and units of the face: 12 floats, three rows of a matrix
        /// that turns, mirrors and scales alike in all directions; empty: the identity. See <see
        /// cref="AxisConversion.WriteInverse"/>.</summary>
        public ReadOnlySpan<float> ToFace;
        /// <summary>Where the head is, is found too; see <see cref="Motion"/>.</summary>
        public bool FindMotion;
        /// <summary>With <see cref="FindMotion"/>, 12 floats, in and out: the face's space, moved and turned by it, is that of
        /// the targets as <see cref="ToFace"/> leaves them. Not read if it is all 0.</summary>
        public Span<float> Motion;

        /// <summary>What a point's target is off by itself, in units; 0: half a millimetre, or a thousandth of <see
        /// cref="Face.Diagonal"/> where the unit is not known.</summary>
        public float Noise;
        /// <summary>x (control - near)^2 / 2.</summary>
        public float Nearness;
        /// <summary>x |control - rest|: few controls rather than many.</summary>
        public float Sparsity;
        /// <summary>x (control - before)^2 / 2.</summary>
        public float Smoothness;
        /// <summary>x (control - its mirror's)^2 / 2, both from rest.</summary>
        public float Symmetry;
        /// <summary>It ends where an iteration lowers the sum by less than this share.</summary>
        public float Tolerance;
        /// <summary>How often derivatives are found, at most.</summary>
        public int MaxIterations;
        /// <summary>What nearness draws to, one a control; empty: rest.</summary>
        public ReadOnlySpan<float> Near;
        /// <summary>The controls of the frame before, for smoothness, in memory other than <see cref="Controls"/>.</summary>
        public ReadOnlySpan<float> Before;
        /// <summary>One a control: whether it may move from where it starts; empty: all. See <see
        /// cref="ControlSearch.MaskOf"/> and <see cref="ControlSearch.MaskWithout"/>.</summary>
        public ReadOnlySpan<bool> Movable;

        /// <summary>One a control: the share of what decides it that comes from the targets, from 0, nothing but preferences,
        /// to 1. Takes some time.</summary>
        public Span<float> Decided;
        /// <summary>One a point: how far it is from its target, in units; NaN without one.</summary>
        public Span<float> PointDifferences;
    }

    /// <summary>How a solution came out.</summary>
    public struct SolveResult
    {
        internal SolveResult(in fb_solve_result from)
        {
            Iterations = (int)from.iterations;
            Converged = from.converged != 0;
            PointCount = (int)from.point_count;
            WorstPoint = from.point_count == 0 ? -1 : (int)from.worst_point;
            RmsDifference = from.rms_difference;
            MaxDifference = from.max_difference;
            Objective = from.objective;
        }

        /// <summary>How often derivatives were found.</summary>
        public readonly int Iterations;
        /// <summary>It did not end because of <see cref="SolveTargets.MaxIterations"/>.</summary>
        public readonly bool Converged;
        /// <summary>Points with targets.</summary>
        public readonly int PointCount;
        /// <summary>Farthest from its target; -1: no point has one.</summary>
        public readonly int WorstPoint;
        /// <summary>Root mean square distance of these points from their targets, in units.</summary>
        public readonly float RmsDifference;
        /// <summary>Of the worst point.</summary>
        public readonly float MaxDifference;
        /// <summary>What was minimised.</summary>
        public readonly double Objective;
    }
}
