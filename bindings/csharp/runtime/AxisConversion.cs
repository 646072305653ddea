using System;
using System.Runtime.InteropServices;

namespace FaceBaker
{
    /// <summary>From the axes and units of an archive (right-handed, y or z up, centimetres, ...) to those of an
    /// engine.</summary>
    public struct AxisConversion
    {
        private AxisConversion(float scale, bool zUp, bool leftHanded)
        {
            Scale = scale;
            ZUp = zUp;
            LeftHanded = leftHanded;
        }

        /// <summary>Factor of lengths.</summary>
        public readonly float Scale;
        /// <summary>The archive's z axis becomes y, and its y axis -z.</summary>
        public readonly bool ZUp;
        /// <summary>x is negated, and triangles are turned round.</summary>
        public readonly bool LeftHanded;

        /// <summary>For Unity: left-handed, y up, metres; front faces are clockwise. Units that are not known count as metres.
        /// </summary>
        public static AxisConversion ToUnity(Face face)
        {
            return ToUnity(face.UpAxis, face.Units);
        }

        /// <summary>The same of an archive's <see cref="Face.UpAxis"/> and <see cref="Face.Units"/>.</summary>
        public static AxisConversion ToUnity(string upAxis, string units)
        {
            return new AxisConversion(MetresPer(units), upAxis == "z", true);
        }

        /// <summary>Nothing is converted.</summary>
        public static AxisConversion None
        {
            get { return new AxisConversion(1, false, false); }
        }

        /// <summary>Metres of a unit of length; 1 for one that is not known.</summary>
        public static float MetresPer(string units)
        {
            switch (units)
            {
                case "mm": return 0.001f;
                case "cm": return 0.01f;
                case "dm": return 0.1f;
                case "in": return 0.0254f;
                case "ft": return 0.3048f;
                default: return 1;
            }
        }

        /// <summary>Converts a box: its smallest x, y, z, then its largest.</summary>
        /// <exception cref="ArgumentException">A span has not 6 floats.</exception>
        public unsafe void ApplyBounds(ReadOnlySpan<float> from, Span<float> to)
        {
            if (from.Length != 6 || to.Length != 6) throw new ArgumentException("A box has 6 floats.");
            fixed (float* box = &MemoryMarshal.GetReference(from), converted = &MemoryMarshal.GetReference(to))
            {
                Apply(box, Scale, converted);
                Apply(box + 3, Scale, converted + 3);
            }
            for (int i = 0; i < 3; ++i)
                if (to[i] > to[i + 3])
                {
                    float larger = to[i];
                    to[i] = to[i + 3];
                    to[i + 3] = larger;
                }
        }

        /// <summary>Converts a frame, such as a socket's, of three rows of a matrix: its origin as a position, its axes as
        /// those of the engine are. The spans may not overlap.</summary>
        /// <exception cref="ArgumentException">A span has not 12 floats.</exception>
        public unsafe void ApplyFrame(ReadOnlySpan<float> from, Span<float> to)
        {
            if (from.Length != 12 || to.Length != 12) throw new ArgumentException("A frame has 12 floats.");
            float* column = stackalloc float[3], converted = stackalloc float[3];
            for (int i = 0; i < 4; ++i)
            {
                // Which of the archive's columns is this one, and with which sign: what becomes of a unit vector.
                int source = !ZUp || i == 0 || i == 3 ? i : 3 - i;
                float sign = i == 0 && LeftHanded || i == 2 && ZUp ? -1 : 1;
                for (int row = 0; row < 3; ++row) column[row] = from[4 * row + source];
                Apply(column, i == 3 ? Scale : sign, converted);
                for (int row = 0; row < 3; ++row) to[4 * row + i] = converted[row];
            }
        }

        /// <summary>Writes the matrix that takes positions in the engine's axes and units back to those of the archive: three
        /// rows of four. See <see cref="SolveTargets.ToFace"/>.</summary>
        /// <exception cref="ArgumentException">The span has not 12 floats.</exception>
        public unsafe void WriteInverse(Span<float> to)
        {
            if (to.Length != 12) throw new ArgumentException("A frame has 12 floats.");
            float* unit = stackalloc float[3];
            fixed (float* rows = &MemoryMarshal.GetReference(to))
                for (int row = 0; row < 3; ++row)
                {
                    for (int i = 0; i < 3; ++i) unit[i] = i == row ? 1 : 0;
                    // The conversion turns, mirrors and scales: the rows of its inverse are its columns over its scale twice.
                    Apply(unit, 1 / Scale, rows + 4 * row);
                    rows[4 * row + 3] = 0;
                }
        }

        /// <summary>Converts a direction, or with <see cref="Scale"/> a position.</summary>
        internal unsafe void Apply(float* from, float scale, float* to)
        {
            float x = from[0] * scale, y = from[1] * scale, z = from[2] * scale;
            to[0] = LeftHanded ? -x : x;
            to[1] = ZUp ? z : y;
            to[2] = ZUp ? -y : z;
        }
    }
}
