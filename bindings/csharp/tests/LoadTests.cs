using System;
using System.Collections.Generic;
using System.IO;
using static FaceBaker.Tests.CheckMain;

namespace FaceBaker.Tests
{
    internal static class LoadTests
    {
        public static void PathBytesAndStreamGiveTheSameFace()
        {
            byte[] bytes = File.ReadAllBytes(Fixture("character.fbk"));
            using (Face one = Face.Load(Fixture("character.fbk")), two = Face.Load(bytes),
                three = Face.Load(new Dribble(bytes, 7)))
            {
                Same(one.Name, two.Name, "name");
                Same(one.Name, three.Name, "name");
                SameBits(one.RestPositions, two.RestPositions, "rest positions");
                SameBits(one.RestPositions, three.RestPositions, "rest positions");
                That(one.Meshes.Count > 1, "the face has several meshes");
            }
        }

        public static void AStreamIsNotReadBeyondTheArchive()
        {
            byte[] bytes = File.ReadAllBytes(Fixture("tiny.fbk"));
            var longer = new byte[bytes.Length + 100];
            bytes.CopyTo(longer, 50);
            var stream = new MemoryStream(longer) { Position = 50 };
            using (Face.Load(stream)) Same(50L + bytes.Length, stream.Position, "position");
        }

        public static void ABrokenStreamThrowsItsOwnException()
        {
            var stream = new Dribble(File.ReadAllBytes(Fixture("tiny.fbk")), 7) { FailAfter = 100 };
            Same("the stream broke", Throws<IOException>(() => Face.Load(stream)).Message, "message");
            stream = new Dribble(new byte[0], 7);
            Same(Status.NotAnArchive, Throws<FaceBakerException>(() => Face.Load(stream)).Status, "status");
        }

        public static void BrokenArchivesAreRefusedByWhatIsWrong()
        {
            var kinds = new Dictionary<string, Status> { { "corrupt", Status.Corrupt }, { "not_an_archive",
                Status.NotAnArchive },
                                                         { "unsupported", Status.Unsupported } };
            int refused = 0;
            foreach (string file in Golden("rejected"))
            {
                string name = Path.GetFileName(file);
                Status status;
                if (!kinds.TryGetValue(name.Substring(0, name.IndexOf('-')), out status)) continue; // refused by verify alone
                Same(status, Throws<FaceBakerException>(() => Face.Load(file)).Status, name);
                Same(status, Throws<FaceBakerException>(() => Face.Load(File.ReadAllBytes(file))).Status, name);
                ++refused;
            }
            That(refused > 50, refused + " broken archives");
            foreach (string file in Golden("accepted")) Face.Load(file).Dispose();
        }

        public static void MessagesAreTheLibrarys()
        {
            var missing = Throws<FaceBakerException>(() => Face.Load("no/such/fäce.fbk"));
            Same(Status.NotFound, missing.Status, "status");
            That(missing.Message.Contains("no/such/fäce.fbk"), missing.Message);
            using (Face face = Face.Load(Fixture("tiny.fbk")))
            {
                string name = face.Controls[0].Name;
                var unknown = Throws<FaceBakerException>(() => face.FindControl(name + "x"));
                Same(Status.NotFound, unknown.Status, "status");
                That(unknown.Message.Contains(name), unknown.Message);
                Same(0, face.FindControl(name), "index");
                Throws<ArgumentException>(() => face.FindControl(name + "\0x"));
                Throws<ArgumentNullException>(() => face.FindControl(null));
                const ulong jawOpen = 0x251683c4c174b423UL; // as facebaker header writes it
                Same(face.FindControl("jaw_open"), face.FindControl(jawOpen), "index by hash");
                Throws<FaceBakerException>(() => face.FindControl(42UL));
                float[] rest = face.RestControls.ToArray(), open = (float[])rest.Clone(), half = new float[rest.Length];
                int jaw = face.FindControl("jaw_open");
                open[jaw] = face.Controls[jaw].Maximum;
                face.Blend(rest, open, 0.5f, half);
                Same((rest[jaw] + open[jaw]) / 2, half[jaw], "half way");
                face.Blend(open, default, 1, half);
                Same(open[jaw], half[jaw], "a control without a partner, mirrored");
                Throws<ArgumentException>(() => face.Blend(rest, open, 0.5f, new float[1]));
                open[jaw] = float.NaN;
                Throws<FaceBakerException>(() => face.Blend(rest, open, 0.5f, half));
            }
            Throws<ArgumentNullException>(() => Face.Load((string)null));
            Throws<ArgumentNullException>(() => Face.Load((byte[])null));
            Throws<ArgumentNullException>(() => Face.Load((Stream)null));
            Same(Status.NotAnArchive, Throws<FaceBakerException>(() => Face.Load(new byte[0])).Status, "status");
        }

        public static void LimitsAreKept()
        {
            string path = Fixture("tiny.fbk");
            Same(Status.Limit, Throws<FaceBakerException>(() => Face.Load(path,
                new LoadOptions { MaxFileBytes = 10 })).Status, "file");
            Same(Status.Limit, Throws<FaceBakerException>(() => Face.Load(path, new LoadOptions { MaxVertices = 1 })).Status,
                "vertices");
            Throws<ArgumentOutOfRangeException>(() => Face.Load(path, new LoadOptions { MaxNameBytes = -1 }));
            using (Face.Load(path, new LoadOptions { MapFile = true })) { }
        }

        public static void NotesArriveAndTheirExceptionsPass()
        {
            string path = Array.Find(Golden("accepted"), file => file.EndsWith("unknown-optional.fbk"));
            var notes = new List<string>();
            using (Face.Load(path, new LoadOptions { Note = notes.Add })) Same(2, notes.Count, "notes");
            Throws<InvalidOperationException>(
                () => Face.Load(path, new LoadOptions { Note = _ => { throw new InvalidOperationException("no notes"); } }));
        }

        public static void ContentsAreThose()
        {
            using (Face face = Face.Load(Fixture("character.fbk")))
            {
                int vertices = 0, polygons = 0;
                foreach (FaceMesh mesh in face.Meshes)
                {
                    Same(vertices, mesh.FirstVertex, mesh.Name);
                    Same(polygons, mesh.FirstPolygon, mesh.Name);
                    vertices += mesh.VertexCount;
                    polygons += mesh.PolygonCount;
                    Same(face.Meshes[face.FindMesh(mesh.Name)], mesh, "found");
                }
                Same(face.VertexCount, vertices, "vertices");
                Same(face.PolygonSizes.Length, polygons, "polygons");
                Same(3 * face.VertexCount, face.RestPositions.Length, "rest positions");
                Same(face.ControlCount, face.RestControls.Length, "rest controls");
                for (int i = 0; i < face.ControlCount; ++i)
                {
                    Control control = face.Controls[i];
                    Same(i, control.Index, "index");
                    Same(i, face.FindControl(control.Name), control.Name);
                    Same(face.RestControls[i], control.Rest, control.Name);
                    That(control.Minimum <= control.Rest && control.Rest <= control.Maximum, control.Name);
                }
                foreach (FaceSocket socket in face.Sockets) Same(12, socket.Frame.Count, socket.Name);
                foreach (FaceMaterial material in face.Materials) Same(4, material.BaseColour.Count, material.Name);
                That(face.Materials.Count > 0 && face.Images.Count > 0 && face.Sockets.Count > 0, "materials, images, sockets");
                Same((byte)0x89, face.Images[0].Bytes.Span[0], "first byte of a PNG");
            }
            using (Face face = Face.Load(Fixture("body.fbk")))
            {
                That(face.Joints.Count > 0 && face.SkinInfluences > 0, "joints and skin");
                Same(face.VertexCount * face.SkinInfluences, face.SkinWeights.Length, "weights");
                Same(face.SkinJoints.Length, face.SkinWeights.Length, "joints");
                Same(-1, face.Joints[0].Parent, "parent of the first joint");
            }
            using (Face face = Face.Load(Fixture("driven.fbk")))
            {
                That(face.Joints.Count > 0 && face.SkinInfluences > 0, "joints and skin of the host");
                Same(4, face.DrivenJoints.Count, "driven joints");
                Same(-1, face.DrivenJoints[0].Parent, "parent of the jaw");
                Same(0, face.DrivenJoints[1].Parent, "parent of the tongue");
                Same(JointNumbers.Rotate, face.DrivenJoints[0].Numbers, "numbers of the jaw");
                Same(JointNumbers.RotateX | JointNumbers.RotateY | JointNumbers.MoveZ, face.DrivenJoints[1].Numbers,
                     "numbers of the tongue");
                Same(JointNumbers.None, face.DrivenJoints[2].Numbers, "numbers of the pin");
                Same(JointNumbers.Rotate | JointNumbers.Move | JointNumbers.Scale | JointNumbers.Pivot,
                     face.DrivenJoints[3].Numbers, "numbers of the lid");
                Same(0, face.DrivenJoints[0].OuterRotations, "outer rotations of the jaw");
                Same(2, face.DrivenJoints[3].OuterRotations, "outer rotations of the lid");
                Same(12, face.DrivenJoints[0].Rest.Count, "frame of the jaw");
                Same(-1f, face.DrivenJoints[0].Rest[11], "z of the jaw");
                Same(1, face.FindDrivenJoint("tongue"), "index of the tongue");
                That(Throws<FaceBakerException>(() => face.FindDrivenJoint("ear")).Message.Contains("tongue"), "names");
                Same(3, face.DrivenInfluences, "influences");
                Same(face.VertexCount * 3, face.DrivenSkinWeights.Length, "weights");
                Same(face.VertexCount * 3, face.DrivenSkinJoints.Length, "joints of vertices");
            }
            using (Face face = Face.Load(Fixture("body.fbk")))
            {
                Same(0, face.DrivenJoints.Count + face.DrivenInfluences + face.DrivenSkinWeights.Length, "driven joints");
                Throws<FaceBakerException>(() => face.EvaluateBatch(
                    new PoseBatch(1, face.RestControls) { Joints = new float[12] }));
            }
            using (Face face = Face.Load(Fixture("levels.fbk")))
            {
                That(face.Levels.Count > 1, "levels");
                Same(face.VertexCount, face.Levels[0].VertexCount, "level 0");
                That(face.Levels[1].VertexCount < face.VertexCount, "level 1");
                Same(face.Meshes.Count, face.Levels[1].Meshes.Count, "meshes of level 1");
            }
            using (Face face = Face.Load(Fixture("exact.fbk"))) That(face.ExactPoses.Count > 0, "exact poses");
            That(Face.LibraryVersion.Split('.').Length == 3, Face.LibraryVersion);
        }

        /// <summary>A stream that gives a few bytes at a time.</summary>
        private sealed class Dribble : MemoryStream
        {
            private readonly int most;

            public Dribble(byte[] bytes, int most) : base(bytes)
            {
                this.most = most;
            }

            public int FailAfter = int.MaxValue;

            public override int Read(byte[] buffer, int offset, int count)
            {
                if (Position >= FailAfter) throw new IOException("the stream broke");
                return base.Read(buffer, offset, Math.Min(count, most));
            }
        }
    }
}
