// The bits of the first vertex of FACE with its first control at 0.7: VertexBits.exe FACE.
using System;
using FaceBaker;

internal static class VertexBits
{
    public static void Main(string[] arguments)
    {
        using (Face face = Face.Load(arguments[0]))
        using (var scratch = new Scratch(face))
        {
            float[] controls = face.RestControls.ToArray(), positions = new float[3 * face.VertexCount];
            controls[0] = 0.7f;
            scratch.Evaluate(controls, positions);
            var bytes = new byte[12];
            Buffer.BlockCopy(positions, 0, bytes, 0, bytes.Length);
            Console.WriteLine(BitConverter.ToString(bytes).Replace("-", "").ToLowerInvariant());
        }
    }
}
