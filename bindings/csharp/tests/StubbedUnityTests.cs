using System;
using System.Collections.Generic;
using System.IO;
using System.Reflection;
using FaceBaker.Unity;
using FaceBaker.Unity.Editor;
using UnityEditor;
using UnityEditor.AssetImporters;
using UnityEngine;
using UnityEngine.Rendering;
using static FaceBaker.Tests.CheckMain;

namespace FaceBaker.Tests
{
    /// <summary>The Unity package over stubs of Unity's classes, which call what Unity would. That Unity does so is not tested
    /// here.</summary>
    internal static class StubbedUnityTests
    {
        private static void Call(object component, string method)
        {
            component.GetType().GetMethod(method, BindingFlags.Instance | BindingFlags.NonPublic).Invoke(component, null);
        }

        private static FaceBakerFace Open(string fixture)
        {
            FaceBakerAsset asset = FaceBakerAsset.Create(File.ReadAllBytes(Fixture(fixture)));
            var component = new GameObject("face").AddComponent<FaceBakerFace>();
            component.enabled = true;
            component.Asset = asset;
            That(component.Face != null, string.Join(" ", Debug.Errors));
            return component;
        }

        public static void TheComponentFillsItsMeshInPlace()
        {
            FaceBakerFace component = Open("character.fbk");
            Face face = component.Face;
            Control control = face.Controls[0];
            component.SetControl(control.Name, control.Maximum);
            Call(component, "LateUpdate");
            var instance = new FaceInstance(face);
            instance[0] = control.Maximum;
            instance.Pose();
            var render = new RenderMesh(face, 0, AxisConversion.ToUnity(face));
            var expected = new float[render.VertexCount * render.VertexFloats];
            instance.Write(render, expected);
            UnityEngine.Mesh mesh = component.GetComponent<MeshFilter>().sharedMesh;
            SameBits(expected, mesh.Streams[0], "vertices");
            SameBits(render.Uvs, mesh.Streams[1], "texture coordinates");
            Same(render.Parts.Count, mesh.Parts.Length, "parts");
            That(mesh.bounds.min.x < mesh.bounds.max.x && mesh.bounds.min.z <= mesh.bounds.max.z, "bounds");
            foreach (SubMeshDescriptor part in mesh.Parts) CheckPart(part, mesh, render.VertexFloats);
            Matrix4x4 frame = component.GetSocket(0);
            float rest = face.Sockets[0].Frame[3] * AxisConversion.MetresPer(face.Units);
            That(Math.Abs(frame[0, 3] + rest) < 0.1 * face.Diagonal && frame[3, 3] == 1, "a socket near where it is at rest");
            Throws<FaceBakerException>(() => component.SetControl("no such control", 1));
            component.ResetControls();
            Same(control.Rest, component.GetControl(0), "at rest");
            Call(component, "OnDisable");
            That(component.Face == null, "closed");
            Call(component, "OnEnable");
            That(component.Face != null, "opened again");
            Call(component, "OnDisable");
        }

        public static void DrivenJointsAreWhereThePoseHasThem()
        {
            FaceBakerFace component = Open("driven.fbk");
            Face face = component.Face;
            var follower = new GameObject("follower").AddComponent<FaceBakerFace>();
            follower.enabled = true;
            follower.Asset = component.Asset;
            follower.MeshName = face.Meshes[1].Name;
            follower.Leader = component;
            var before = component.GetDrivenJoint(0);
            foreach (Control control in face.Controls) component.SetControl(control.Index, control.Maximum);
            Call(component, "LateUpdate");
            Call(follower, "LateUpdate");
            var instance = new FaceInstance(face);
            instance.SetControls(Widest(face));
            instance.Pose();
            var expected = new float[12];
            for (int joint = 0; joint < face.DrivenJoints.Count; ++joint)
            {
                AxisConversion.ToUnity(face).ApplyFrame(instance.Joints.Slice(12 * joint, 12), expected);
                Matrix4x4 frame = component.GetDrivenJoint(joint), followed = follower.GetDrivenJoint(joint);
                for (int i = 0; i < 12; ++i)
                {
                    Same(expected[i], frame[i / 4, i % 4], face.DrivenJoints[joint].Name);
                    Same(expected[i], followed[i / 4, i % 4], face.DrivenJoints[joint].Name + " of a follower");
                }
            }
            That(before[0, 0] != component.GetDrivenJoint(0)[0, 0], "the jaw turns");
            Matrix4x4 socket = component.GetSocket(0), other = follower.GetSocket(0);
            for (int i = 0; i < 12; ++i) Same(socket[i / 4, i % 4], other[i / 4, i % 4], "a socket of a follower");
            Throws<ArgumentOutOfRangeException>(() => component.GetDrivenJoint(face.DrivenJoints.Count));
            Call(follower, "OnDisable");
            Call(component, "OnDisable");
        }

        public static void TheTrianglesAreThoseOfTheLevel()
        {
            FaceBakerFace component = Open("levels.fbk");
            Face face = component.Face;
            var render = new RenderMesh(face, 0, AxisConversion.ToUnity(face));
            var instance = new FaceInstance(face);
            UnityEngine.Mesh mesh = component.GetComponent<MeshFilter>().sharedMesh;
            That(render.Levels[2].Indices.Length < render.Levels[1].Indices.Length, "coarser levels have fewer triangles");
            foreach (float lod in new[] { 0, 2, 1.5f, 9, 0.5f })
            {
                component.LevelOfDetail = instance.Lod = lod;
                component.SetControl(0, face.Controls[0].Maximum * 0.05f * (1 + lod));
                instance[0] = face.Controls[0].Maximum * 0.05f * (1 + lod);
                Call(component, "LateUpdate");
                instance.Pose();
                RenderLevel level = render.Levels[Math.Min((int)lod, 2)];
                var expected = new float[level.VertexCount * render.VertexFloats];
                instance.Write(render, expected);
                SameBits(expected, new ReadOnlySpan<float>(mesh.Streams[0], 0, expected.Length), "vertices");
                int drawn = 0;
                foreach (SubMeshDescriptor part in mesh.Parts)
                {
                    CheckPart(part, mesh, render.VertexFloats);
                    drawn += part.indexCount;
                }
                Same(level.Indices.Length, drawn, "indices that are drawn");
                for (int i = 0; i < drawn; ++i) Same(level.Indices[i], mesh.Indices[i], "index");
            }
            Call(component, "OnDisable");
        }

        public static void AFaceThatNobodySeesIsNotPosed()
        {
            FaceBakerFace component = Open("tiny.fbk");
            UnityEngine.Mesh mesh = component.GetComponent<MeshFilter>().sharedMesh;
            float before = 0;
            Func<bool> changes = () =>
            {
                float last = before;
                before = 0;
                foreach (float number in mesh.Streams[0]) before += Math.Abs(number);
                return before != last;
            };
            changes();
            component.GetComponent<MeshRenderer>().isVisible = false;
            component.SetControl(0, component.Face.Controls[0].Maximum);
            Call(component, "LateUpdate");
            That(!changes(), "nobody sees it");
            component.UpdateWhenOffscreen = true;
            Call(component, "LateUpdate");
            That(changes(), "it is posed where that is asked for");
            component.UpdateWhenOffscreen = false;
            component.ResetControls();
            Call(component, "LateUpdate");
            That(!changes(), "and not otherwise");
            Call(component, "OnBecameVisible");
            That(changes(), "it is posed in the moment in which a camera sees it");
            Call(component, "OnDisable");
        }

        // Its ranges hold all its indices and nothing else, its bounds all its vertices.
        private static void CheckPart(SubMeshDescriptor part, UnityEngine.Mesh mesh, int floats)
        {
            int first = int.MaxValue, last = -1;
            for (int i = part.indexStart; i < part.indexStart + part.indexCount; ++i)
            {
                int vertex = mesh.Indices[i];
                first = Math.Min(first, vertex);
                last = Math.Max(last, vertex);
                float x = mesh.Streams[0][vertex * floats], y = mesh.Streams[0][vertex * floats + 1];
                That(part.bounds.min.x <= x && x <= part.bounds.max.x && part.bounds.min.y <= y && y <= part.bounds.max.y,
                     "vertex " + vertex + " is within the bounds of its part");
            }
            That(part.indexCount > 0, "a part has triangles");
            Same(first, part.firstVertex, "first vertex");
            Same(last - first + 1, part.vertexCount, "vertices of the part");
        }

        public static void AFrameAllocatesNothing()
        {
            FaceBakerFace component = Open("levels.fbk");
            Face face = component.Face;
            var late = (Action)Delegate.CreateDelegate(typeof(Action), component,
                component.GetType().GetMethod("LateUpdate", BindingFlags.Instance | BindingFlags.NonPublic));
            long before = 0;
            for (int frame = 0; frame < 1000; ++frame)
            {
                if (frame == 500) before = GC.GetAllocatedBytesForCurrentThread();
                component.SetControl(0, frame * 0.001f);
                component.LevelOfDetail = frame % 3;
                late();
            }
            Same(0L, GC.GetAllocatedBytesForCurrentThread() - before, "bytes allocated by 500 frames");
            Call(component, "OnDisable");
        }

        public static void TheImporterMakesObjectsAndRefusesBrokenFiles()
        {
            var context = new AssetImportContext { assetPath = Fixture("character.fbk") };
            new FbkImporter().OnImportAsset(context);
            Same(0, context.Errors.Count, string.Join(" ", context.Errors));
            That(context.Main is GameObject && context.Objects["archive"] is FaceBakerAsset, "objects");
            That(context.Objects.ContainsKey("material skin") && context.Objects.ContainsKey("no material"), "materials");
            string broken = Array.Find(Golden("rejected"), file => file.EndsWith("corrupt-bit.fbk"));
            context = new AssetImportContext { assetPath = broken };
            new FbkImporter().OnImportAsset(context);
            That(context.Errors.Count == 1 && context.Main == null, "an import error");
            That(context.Errors[0].Contains("corrupt-bit.fbk"), context.Errors[0]);
        }

        public static void ObjectsOfOneNameHaveIdentifiersOfTheirOwn()
        {
            var context = new AssetImportContext { assetPath = Fixture("rebaked.fbk") };
            new FbkImporter().OnImportAsset(context);
            Same(0, context.Errors.Count, string.Join(" ", context.Errors));
            foreach (string identifier in new[] { "material skin", "material skin 2", "image skin", "image skin 2" })
                That(context.Objects.ContainsKey(identifier),
                     identifier + " is one of " + string.Join(", ", context.Objects.Keys));
            var texture = ((UnityEngine.Material)context.Objects["material skin 2"]).mainTexture;
            That(texture == context.Objects["image skin 2"], "each material has its own texture");
        }

        // As Unity does it: the asset's fields are read anew, and then all postprocessors are called.
        public static void OpenComponentsShowAnArchiveThatIsImportedAnew()
        {
            FaceBakerFace component = Open("character.fbk");
            FaceBakerAsset asset = component.Asset;
            var other = new GameObject("other").AddComponent<FaceBakerFace>();
            other.enabled = true;
            other.Asset = asset;
            AssetDatabase.Paths[asset] = "Assets/face.fbk";
            Face old = component.Face;
            var expected = new Dictionary<string, float>();
            foreach (Control control in old.Controls)
            {
                expected[control.Name] = control.Minimum + 0.75f * (control.Maximum - control.Minimum);
                component.SetControl(control.Index, expected[control.Name]);
            }
            typeof(FaceBakerAsset).GetField("archive", BindingFlags.Instance | BindingFlags.NonPublic)
                .SetValue(asset, File.ReadAllBytes(Fixture("rebaked.fbk")));
            Debug.Warnings.Clear();
            typeof(FbkImporter).Assembly.GetType("FaceBaker.Unity.Editor.FbkPostprocessor", true)
                .GetMethod("OnPostprocessAllAssets", BindingFlags.Static | BindingFlags.NonPublic)
                .Invoke(null, new object[] { new[] { "Assets/face.fbk" }, new string[0], new string[0], new string[0] });
            Face now = component.Face;
            That(now != null && now != old && other.Face == now, "both components show the new face");
            Throws<ObjectDisposedException>(() => old.FindControl("jaw_open"));
            That(now.Controls[0].Name != "jaw_open", "its controls are in another order");
            int kept = 0;
            foreach (Control control in now.Controls)
            {
                float value;
                if (expected.TryGetValue(control.Name, out value)) ++kept;
                else value = control.Rest;
                Same(value, component.GetControl(control.Index), control.Name);
            }
            That(kept >= 3 && kept < now.ControlCount, kept + " controls have kept their values");
            Same(2, Debug.Warnings.FindAll(text => text.Contains("nose_wrinkle")).Count, "warnings about the one that has gone");
            That(EditorApplication.Queued > 0, "the editor shows it");
            Call(component, "OnDisable");
            Call(other, "OnDisable");
        }

        public static void TheInspectorHasASliderForEveryControl()
        {
            FaceBakerFace component = Open("tiny.fbk");
            var inspector = new FaceBakerFaceEditor { target = component };
            inspector.OnInspectorGUI();
            foreach (Control control in component.Face.Controls)
                Same(control.Maximum, component.GetControl(control.Index), control.Name); // where the stub moves its sliders
            int found = 0;
            string name = component.Face.Controls[0].Name;
            foreach (KeyValuePair<string, List<Control>> group in ControlSearch.ByGroup(component.Face.Controls,
                name.ToUpperInvariant()))
                found += group.Value.Count;
            That(found >= 1, "the control is found by its name in capitals");
            Same(0, ControlSearch.ByGroup(component.Face.Controls, "no such thing").Count, "groups");
            Call(component, "OnDisable");
        }
    }
}
