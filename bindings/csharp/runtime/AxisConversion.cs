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
            return new AxisConversion(MetresPer(face.Units), face.UpAxis == "z", true);
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
