using System;

namespace FaceBaker
{
    /// <summary>Limits for archives that may come from anyone, and where notes go. What is larger than a limit is refused with
    /// <see cref="Status.Limit"/>. One set of options may serve any number of loads, one after another.</summary>
    public sealed class LoadOptions
    {
        /// <summary>With the library's defaults.</summary>
        public LoadOptions()
        {
            fb_load_desc defaults = fb_load_desc.Filled();
            MaxFileBytes = (long)defaults.max_file_bytes;
            MaxModelBytes = (long)defaults.max_model_bytes;
            MaxNameBytes = (long)defaults.max_name_bytes;
            MaxVertices = (long)defaults.max_vertices;
            MaxPolygons = (long)defaults.max_polygons;
            MaxFeatures = (long)defaults.max_features;
            Threads = (int)defaults.threads;
        }

        /// <summary>Bytes of the file; default 4 GiB.</summary>
        public long MaxFileBytes { get; set; }

        /// <summary>Bytes of memory that loading takes at any time; default 4 GiB.</summary>
        public long MaxModelBytes { get; set; }

        /// <summary>Bytes of all names and texts; default 16 MiB.</summary>
        public long MaxNameBytes { get; set; }

        /// <summary>Vertices; default 4 Mi.</summary>
        public long MaxVertices { get; set; }

        /// <summary>Polygons; default 8 Mi.</summary>
        public long MaxPolygons { get; set; }

        /// <summary>Functions of the controls that networks and blendshapes are made of; default 1 Mi.</summary>
        public long MaxFeatures { get; set; }

        /// <summary>Threads that decode the basis, at most; default 1; 0: as many as OpenMP would use.</summary>
        public int Threads { get; set; }

        /// <summary>Maps a file instead of reading it, which saves memory. It must not be cut short or overwritten during the
        /// call: the system would end the process.</summary>
        public bool MapFile { get; set; }

        /// <summary>Receives sentences about what is odd but no error, on the loading thread; null: nobody. What it throws is
        /// thrown by the call that loads.</summary>
        public Action<string> Note { get; set; }

        /// <summary>The struct of the C interface, without the note.</summary>
        /// <exception cref="ArgumentOutOfRangeException">A number is below 0.</exception>
        internal fb_load_desc Described()
        {
            fb_load_desc desc = fb_load_desc.Filled();
            desc.max_file_bytes = Limit(MaxFileBytes, nameof(MaxFileBytes));
            desc.max_model_bytes = Limit(MaxModelBytes, nameof(MaxModelBytes));
            desc.max_name_bytes = Limit(MaxNameBytes, nameof(MaxNameBytes));
            desc.max_vertices = Limit(MaxVertices, nameof(MaxVertices));
            desc.max_polygons = Limit(MaxPolygons, nameof(MaxPolygons));
            desc.max_features = Limit(MaxFeatures, nameof(MaxFeatures));
            desc.threads = (uint)Limit(Threads, nameof(Threads));
            desc.map_file = MapFile ? 1u : 0u;
            return desc;
        }

        private static ulong Limit(long value, string name)
        {
            if (value < 0) throw new ArgumentOutOfRangeException(name, value, "It may not be below 0.");
            return (ulong)value;
        }
    }
}
