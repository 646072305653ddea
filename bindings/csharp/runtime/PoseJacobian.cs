using System;

namespace FaceBaker
{
    /// <summary>A pose, and where the derivatives of what a <see cref="Solver"/> follows by its controls are written, in units
    /// a unit of the control. Spans that are empty are no output. It is made on the stack and allocates nothing:
    /// <code>solver.Jacobian(new PoseJacobian(controls) { Derivatives = derivatives });</code></summary>
    public ref struct PoseJacobian
    {
        /// <summary>Without outputs. controls: <see cref="Face.ControlCount"/> floats; they are clamped to their
        /// ranges.</summary>
        public PoseJacobian(ReadOnlySpan<float> controls) : this()
        {
            Controls = controls;
        }

        /// <summary>The pose.</summary>
        public ReadOnlySpan<float> Controls;
        /// <summary>Indices of controls, ascending; empty: all.</summary>
        public ReadOnlySpan<uint> Chosen;
        /// <summary>One a control: where the pose bends, as at rest or where a corrective begins, the derivative is that of
        /// moving it down. Empty: of moving it up, but down at its maximum.</summary>
        public ReadOnlySpan<bool> Downwards;
        /// <summary>The numbers that are followed: <see cref="Solver.RowCount"/> floats.</summary>
        public Span<float> Values;
        /// <summary>Dense derivatives: row after row, a float for each chosen control.</summary>
        public Span<float> Derivatives;
        /// <summary>Sparse derivatives: where the entries of each chosen control begin, and of how many there are in all: one
        /// more than chosen. It is written also where the next two are too small, and alone if they are empty.</summary>
        public Span<ulong> ColumnStarts;
        /// <summary>Rows of entries that are not 0, ascending in each column.</summary>
        public Span<uint> ColumnRows;
        /// <summary>Their derivatives; as long as <see cref="ColumnRows"/>.</summary>
        public Span<float> ColumnValues;
    }
}
