using System.IO;
using UnityEditor.AssetImporters;
using UnityEngine;
using UnityEngine.Rendering;

namespace FaceBaker.Unity.Editor
{
    /// <summary>Imports an .fbk archive as an asset, and an object with a component for each mesh to drag into scenes. An
    /// archive that is damaged is an import error with the library's message.</summary>
    [ScriptedImporter(1, "fbk")]
    public sealed class FbkImporter : ScriptedImporter
    {
        /// <summary>Called by Unity.</summary>
        public override void OnImportAsset(AssetImportContext context)
        {
            byte[] bytes = File.ReadAllBytes(context.assetPath);
            try
            {
                using (Face face = Face.Load(bytes, new LoadOptions { Note = note => context.LogImportWarning(note) }))
                {
                    FaceBakerAsset asset = FaceBakerAsset.Create(bytes);
                    asset.name = Path.GetFileNameWithoutExtension(context.assetPath);
                    context.AddObjectToAsset("archive", asset);
                    GameObject scene = MakeObject(face, asset, MakeMaterials(face, context));
                    context.AddObjectToAsset("object", scene);
                    context.SetMainObject(scene);
                }
            }
            catch (FaceBakerException exception)
            {
                context.LogImportError(context.assetPath + ": " + exception.Message);
            }
        }

        private static GameObject MakeObject(Face face, FaceBakerAsset asset, UnityEngine.Material[] materials)
        {
            var root = new GameObject(face.Name.Length > 0 ? face.Name : asset.name);
            FaceBakerFace leader = null;
            foreach (FaceMesh mesh in face.Meshes)
            {
                GameObject child = root;
                if (face.Meshes.Count > 1)
                {
                    child = new GameObject(mesh.Name);
                    child.transform.SetParent(root.transform, false);
                }
                var component = child.AddComponent<FaceBakerFace>();
                component.Configure(asset, mesh.Name, leader);
                component.GetComponent<MeshRenderer>().sharedMaterials = MaterialsOf(mesh, materials);
                if (leader == null) leader = component;
            }
            return root;
        }

        // Of each run of the mesh; the last of `materials` where it has none.
        private static UnityEngine.Material[] MaterialsOf(FaceMesh mesh, UnityEngine.Material[] materials)
        {
            var chosen = new UnityEngine.Material[mesh.Runs.Count];
            for (int i = 0; i < chosen.Length; ++i)
                chosen[i] = materials[mesh.Runs[i].Material < 0 ? materials.Length - 1 : mesh.Runs[i].Material];
            return chosen;
        }

        // Colours and base colour textures in the shader of the project's render pipeline; then one for what has no material.
        private static UnityEngine.Material[] MakeMaterials(Face face, AssetImportContext context)
        {
            Shader shader = GraphicsSettings.defaultRenderPipeline != null ? GraphicsSettings.defaultRenderPipeline.defaultShader
                                                                           : Shader.Find("Standard");
            var made = new UnityEngine.Material[face.Materials.Count + 1];
            for (int i = 0; i < made.Length; ++i)
            {
                made[i] = new UnityEngine.Material(shader) { name = "default" };
                if (i < face.Materials.Count) Fill(made[i], face, face.Materials[i], context);
                context.AddObjectToAsset("material " + i, made[i]);
            }
            return made;
        }

        private static void Fill(UnityEngine.Material to, Face face, FaceMaterial from, AssetImportContext context)
        {
            to.name = from.Name;
            to.color = new Color(from.BaseColour[0], from.BaseColour[1], from.BaseColour[2], from.BaseColour[3]).gamma;
            foreach (FaceTexture texture in from.Textures)
            {
                if (texture.Slot != TextureSlot.BaseColour) continue;
                FaceImage image = face.Images[texture.Image];
                var picture = new Texture2D(2, 2) { name = image.Name };
                if (!picture.LoadImage(image.Bytes.ToArray()))
                    context.LogImportWarning("image " + texture.Image + ", " + image.MediaType + ", cannot be read by Unity");
                context.AddObjectToAsset("image of " + to.name, picture);
                to.mainTexture = picture;
            }
        }
    }
}
