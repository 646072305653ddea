using System.Collections.Generic;
using System.IO;
using UnityEditor.AssetImporters;
using UnityEngine;
using UnityEngine.Rendering;

namespace FaceBaker.Unity.Editor
{
    /// <summary>Imports an .fbk archive as an asset, and an object with a component for each mesh to drag into scenes. An
    /// archive that is damaged is an import error with the library's message. Materials and textures are known to projects by
    /// their names; of those of one name the second is "NAME 2".</summary>
    [ScriptedImporter(2, "fbk")]
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
            var used = new HashSet<string>();
            var textures = new Texture2D[face.Images.Count];
            for (int i = 0; i < made.Length; ++i)
            {
                made[i] = new UnityEngine.Material(shader) { name = "default" };
                bool own = i < face.Materials.Count;
                if (own) Fill(made[i], face, face.Materials[i], textures);
                context.AddObjectToAsset(Identifier(own ? "material " + made[i].name : "no material", used), made[i]);
            }
            for (int i = 0; i < textures.Length; ++i)
            {
                if (textures[i] == null) continue;
                if (!textures[i].LoadImage(face.Images[i].Bytes.ToArray()))
                    context.LogImportWarning("image " + i + ", " + face.Images[i].MediaType + ", cannot be read by Unity");
                context.AddObjectToAsset(Identifier("image " + textures[i].name, used), textures[i]);
            }
            return made;
        }

        // Two objects of one identifier are one to Unity.
        private static string Identifier(string name, HashSet<string> used)
        {
            string identifier = name;
            for (int number = 2; !used.Add(identifier); ++number) identifier = name + " " + number;
            return identifier;
        }

        // textures: of each image; those that the material shows are made.
        private static void Fill(UnityEngine.Material to, Face face, FaceMaterial from, Texture2D[] textures)
        {
            to.name = from.Name;
            to.color = new Color(from.BaseColour[0], from.BaseColour[1], from.BaseColour[2], from.BaseColour[3]).gamma;
            foreach (FaceTexture texture in from.Textures)
            {
                if (texture.Slot != TextureSlot.BaseColour) continue;
                int image = texture.Image;
                if (textures[image] == null) textures[image] = new Texture2D(2, 2) { name = face.Images[image].Name };
                to.mainTexture = textures[image];
            }
        }
    }
}
