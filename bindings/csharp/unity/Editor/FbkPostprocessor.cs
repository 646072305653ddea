using System;
using System.Collections.Generic;
using UnityEditor;
using UnityEngine;

namespace FaceBaker.Unity.Editor
{
    /// <summary>Shows archives that were imported anew in the components that are open.</summary>
    internal sealed class FbkPostprocessor : AssetPostprocessor
    {
        /// <summary>Called by Unity.</summary>
        private static void OnPostprocessAllAssets(string[] imported, string[] deleted, string[] moved, string[] movedFrom)
        {
            var archives = new HashSet<string>(
                Array.FindAll(imported, path => path.EndsWith(".fbk", StringComparison.OrdinalIgnoreCase)));
            if (archives.Count == 0) return;
            var changed = new List<FaceBakerFace>();
            foreach (FaceBakerFace component in Resources.FindObjectsOfTypeAll<FaceBakerFace>())
                if (!EditorUtility.IsPersistent(component) && archives.Contains(AssetDatabase.GetAssetPath(component.Asset)))
                    changed.Add(component);
            FaceBakerFace.Reload(changed);
            EditorApplication.QueuePlayerLoopUpdate();
        }
    }
}
