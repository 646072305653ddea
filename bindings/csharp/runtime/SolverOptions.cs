namespace FaceBaker
{
    /// <summary>What a <see cref="Solver"/> follows. Arrays are copied when it is made. Null: none, but for <see
    /// cref="PointVertices"/>.</summary>
    public sealed class SolverOptions
    {
        /// <summary>Three vertices a point, in the source's order; null: every vertex is a point.</summary>
        public uint[] PointVertices { get; set; }

        /// <summary>Three a point: where it is, is the sum of weight x vertex, as of barycentric coordinates. Null: 1, 0 and
        /// 0.</summary>
        public float[] PointWeights { get; set; }

        /// <summary>Two points each, whose distance may have a target.</summary>
        public uint[] Pairs { get; set; }

        /// <summary>Indices of <see cref="Face.Sockets"/> whose frames are followed.</summary>
        public uint[] Sockets { get; set; }

        /// <summary>Indices of <see cref="Face.DrivenJoints"/> whose frames are followed, after those of sockets.</summary>
        public uint[] Joints { get; set; }

        /// <summary>Level of detail; see <see cref="PoseBatch.Lod"/>.</summary>
        public float Lod { get; set; }
    }
}
