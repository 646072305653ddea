using System.Threading;

namespace FaceBaker
{
    /// <summary>Scratches that wait for the next pose, for callers who bring none. Takes no lock; allocates where more threads
    /// pose at once than ever before.</summary>
    internal sealed class ScratchPool
    {
        private readonly Scratch[] idle = new Scratch[64];
        private readonly bool several;
        private volatile bool closed;

        /// <summary>several: for batches, else for single poses.</summary>
        public ScratchPool(bool several)
        {
            this.several = several;
        }

        /// <summary>One that nobody else has; to be given back.</summary>
        public Scratch Take(Face face)
        {
            for (int i = 0; i < idle.Length; ++i)
            {
                Scratch scratch = idle[i] == null ? null : Interlocked.Exchange(ref idle[i], null);
                if (scratch != null) return scratch;
            }
            return new Scratch(face, 1, several);
        }

        /// <summary>Gives a scratch back, which is freed where the pool is full or closed.</summary>
        public void Give(Scratch scratch)
        {
            for (int i = 0; i < idle.Length && !closed; ++i)
                if (idle[i] == null && Interlocked.CompareExchange(ref idle[i], scratch, null) == null)
                {
                    if (closed) Close();
                    return;
                }
            scratch.Dispose();
        }

        /// <summary>Frees all that are idle now, and the others when they come back.</summary>
        public void Close()
        {
            closed = true;
            for (int i = 0; i < idle.Length; ++i)
            {
                Scratch scratch = Interlocked.Exchange(ref idle[i], null);
                if (scratch != null) scratch.Dispose();
            }
        }
    }
}
