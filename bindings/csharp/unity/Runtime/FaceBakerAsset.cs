using System;
using UnityEngine;

namespace FaceBaker.Unity
{
    /// <summary>An .fbk archive in a project, as the importer makes it. Components that pose it share one loaded
    /// face.</summary>
    public sealed class FaceBakerAsset : ScriptableObject
    {
        [SerializeField, HideInInspector] private byte[] archive;

        [NonSerialized] private Face face;
        [NonSerialized] private int users;

        /// <summary>Made by the importer; archive: the file's bytes.</summary>
        public static FaceBakerAsset Create(byte[] archive)
        {
            FaceBakerAsset asset = CreateInstance<FaceBakerAsset>();
            asset.archive = archive;
            return asset;
        }

        /// <summary>The face, loaded by the first who asks; to be given back by <see cref="Release"/>. An archive that was
        /// imported anew is loaded once all have given back the old one. Main thread only.</summary>
        /// <exception cref="FaceBakerException">The archive is damaged.</exception>
        public Face Acquire()
        {
            if (face == null) face = Face.Load(archive);
            ++users;
            return face;
        }

        /// <summary>Ends a use; the last one frees the face. Main thread only.</summary>
        public void Release()
        {
            if (users == 0 || --users > 0) return;
            face.Dispose();
            face = null;
        }
    }
}
