using System;
using System.Collections.Generic;

namespace FaceBaker
{
    /// <content>What is in a face. Each list and array is copied once, when it is first asked for; threads that ask at once may
    /// copy it twice, and get equal ones.</content>
    public sealed unsafe partial class Face
    {
        private IReadOnlyList<Control> controls;
        private IReadOnlyList<FaceMesh> meshes;
        private IReadOnlyList<FaceMaterial> materials;
        private IReadOnlyList<FaceImage> images;
        private IReadOnlyList<FaceSocket> sockets;
        private IReadOnlyList<FaceChannel> channels;
        private IReadOnlyList<FaceJoint> joints;
        private IReadOnlyList<DrivenJoint> drivenJoints;
        private IReadOnlyList<FaceLevel> levels;
        private IReadOnlyList<ExactPose> exactPoses;
        private IReadOnlyList<RowBlock> rowBlocks;
        private IReadOnlyList<string> regions, errorRegions;
        private float[] restControls, restPositions, uvs, tangentSigns, skinWeights, drivenSkinWeights;
        private uint[] polygonSizes, polygonCorners, uvCorners, vertexOrder, errorVertexRegions;
        private ushort[] skinJoints, drivenSkinJoints;
        private string about, provenance;

        private delegate T Reader<T>(uint index);

        // What is in `place`, or else what `read` copies there from the model, which stays meanwhile. `read` captures nothing,
        // so that asking again allocates nothing.
        private T Copied<T>(ref T place, Func<Face, T> read) where T : class
        {
            if (place != null) return place;
            bool held = false;
            try
            {
                Handle.DangerousAddRef(ref held);
                return place = read(this);
            }
            finally
            {
                if (held) Handle.DangerousRelease();
            }
        }

        private static IReadOnlyList<T> ListOf<T>(uint count, Reader<T> read)
        {
            var list = new T[count];
            for (uint i = 0; i < count; ++i) list[i] = read(i);
            return Array.AsReadOnly(list);
        }

        /// <summary>The controls, in the order of poses.</summary>
        public IReadOnlyList<Control> Controls
        {
            get
            {
                return Copied(ref controls, face => ListOf(Native.fb_control_count(face.Handle), i =>
                {
                    fb_control at = fb_control.Filled();
                    Native.Check(Native.fb_control_at(face.Handle, i, &at));
                    return new Control((int)i, &at);
                }));
            }
        }

        /// <summary>The meshes, at least 1.</summary>
        public IReadOnlyList<FaceMesh> Meshes
        {
            get
            {
                return Copied(ref meshes, face => ListOf(Native.fb_mesh_count(face.Handle), i =>
                {
                    fb_mesh at = fb_mesh.Filled();
                    Native.Check(Native.fb_mesh_at(face.Handle, i, &at));
                    return new FaceMesh(&at);
                }));
            }
        }

        /// <summary>The materials; there may be none.</summary>
        public IReadOnlyList<FaceMaterial> Materials
        {
            get
            {
                return Copied(ref materials, face => ListOf(Native.fb_material_count(face.Handle), i =>
                {
                    fb_material at = fb_material.Filled();
                    Native.Check(Native.fb_material_at(face.Handle, i, &at));
                    return new FaceMaterial(&at);
                }));
            }
        }

        /// <summary>The images; there may be none.</summary>
        public IReadOnlyList<FaceImage> Images
        {
            get
            {
                return Copied(ref images, face => ListOf(Native.fb_image_count(face.Handle), i =>
                {
                    fb_image at = fb_image.Filled();
                    Native.Check(Native.fb_image_at(face.Handle, i, &at));
                    return new FaceImage(&at);
                }));
            }
        }

        /// <summary>The sockets; there may be none.</summary>
        public IReadOnlyList<FaceSocket> Sockets
        {
            get
            {
                return Copied(ref sockets, face => ListOf(Native.fb_socket_count(face.Handle), i =>
                {
                    fb_socket at = fb_socket.Filled();
                    Native.Check(Native.fb_socket_at(face.Handle, i, &at));
                    return new FaceSocket(&at);
                }));
            }
        }

        /// <summary>The channels; there may be none.</summary>
        public IReadOnlyList<FaceChannel> Channels
        {
            get
            {
                return Copied(ref channels, face => ListOf(Native.fb_channel_count(face.Handle), i =>
                {
                    fb_channel at = fb_channel.Filled();
                    Native.Check(Native.fb_channel_at(face.Handle, i, &at));
                    return new FaceChannel(&at);
                }));
            }
        }

        /// <summary>The joints, after their parents; there may be none.</summary>
        public IReadOnlyList<FaceJoint> Joints
        {
            get
            {
                return Copied(ref joints, face => ListOf(Native.fb_joint_count(face.Handle), i =>
                {
                    fb_joint at = fb_joint.Filled();
                    Native.Check(Native.fb_joint_at(face.Handle, i, &at));
                    return new FaceJoint(&at);
                }));
            }
        }

        /// <summary>The joints that the controls drive, after their parents; there may be none.</summary>
        public IReadOnlyList<DrivenJoint> DrivenJoints
        {
            get
            {
                return Copied(ref drivenJoints, face => ListOf(Native.fb_driven_joint_count(face.Handle), i =>
                {
                    fb_driven_joint at = fb_driven_joint.Filled();
                    Native.Check(Native.fb_driven_joint_at(face.Handle, i, &at));
                    return new DrivenJoint(&at);
                }));
            }
        }

        /// <summary>Levels of detail, with the whole as level 0.</summary>
        public IReadOnlyList<FaceLevel> Levels
        {
            get
            {
                return Copied(ref levels, face => ListOf(Native.fb_level_count(face.Handle), i =>
                {
                    fb_level at = fb_level.Filled();
                    Native.Check(Native.fb_level_at(face.Handle, i, &at));
                    return new FaceLevel(&at, face.Meshes.Count);
                }));
            }
        }

        /// <summary>The basis: times the coefficients of a pose (<see cref="Scratch.EvaluateCoefficients"/>) it gives
        /// displacements, which differ from positions by rounding, and do without exact poses and driven joints. Large; copied
        /// when it is first asked for.
        /// </summary>
        public IReadOnlyList<RowBlock> RowBlocks
        {
            get
            {
                return Copied(ref rowBlocks, face => ListOf(Native.fb_row_block_count(face.Handle), i =>
                {
                    fb_row_block at = fb_row_block.Filled();
                    Native.Check(Native.fb_row_block_at(face.Handle, i, &at));
                    var columns = new uint[at.column_count];
                    var values = new float[checked((int)(at.column_count * (ulong)at.row_count))];
                    fixed (uint* column = columns)
                    fixed (float* value = values)
                        if (columns.Length > 0) Native.Check(Native.fb_row_block_values(face.Handle, i, column, value));
                    return new RowBlock(at, columns, values);
                }));
            }
        }

        /// <summary>Poses that come out as the rig gave them; there may be none.</summary>
        public IReadOnlyList<ExactPose> ExactPoses
        {
            get
            {
                return Copied(ref exactPoses, face => ListOf(Native.fb_exact_pose_count(face.Handle), i =>
                {
                    fb_exact_pose at = fb_exact_pose.Filled();
                    Native.Check(Native.fb_exact_pose_at(face.Handle, i, &at));
                    return new ExactPose(&at);
                }));
            }
        }

        /// <summary>Names of the regions that have a network of their own; there may be none.</summary>
        public IReadOnlyList<string> Regions
        {
            get
            {
                return Copied(ref regions, face => ListOf(Native.fb_region_count(face.Handle),
                                                    i => Native.Text(Native.fb_region_name(face.Handle, i))));
            }
        }

        /// <summary>Names of the regions that expected errors are given for; there may be none.</summary>
        public IReadOnlyList<string> ErrorRegions
        {
            get
            {
                return Copied(ref errorRegions, face => ListOf(Native.fb_error_region_count(face.Handle),
                                                              i => Native.Text(Native.fb_error_region_name(face.Handle, i))));
            }
        }

        /// <summary>The controls of the rest pose.</summary>
        public ReadOnlySpan<float> RestControls
        {
            get
            {
                return Copied(ref restControls, face =>
                    Native.Copy(Native.fb_rest_controls(face.Handle), face.ControlCount));
            }
        }

        /// <summary>The rest mesh: 3 x <see cref="VertexCount"/> floats, xyz interleaved.</summary>
        public ReadOnlySpan<float> RestPositions
        {
            get
            {
                return Copied(ref restPositions, face =>
                    Native.Copy(Native.fb_rest_positions(face.Handle), 3 * face.VertexCount));
            }
        }

        /// <summary>Corners of each polygon, at least 3.</summary>
        public ReadOnlySpan<uint> PolygonSizes
        {
            get
            {
                return Copied(ref polygonSizes, face =>
                    Native.Copy(Native.fb_polygon_sizes(face.Handle), (int)Native.fb_polygon_count(face.Handle)));
            }
        }

        /// <summary>Vertex indices, polygon after polygon.</summary>
        public ReadOnlySpan<uint> PolygonCorners
        {
            get
            {
                return Copied(ref polygonCorners, face =>
                    Native.Copy(Native.fb_polygon_corners(face.Handle), (int)Native.fb_polygon_corner_count(face.Handle)));
            }
        }

        /// <summary>Pairs of texture coordinates, v pointing up from the lower edge; empty if the source had none.</summary>
        public ReadOnlySpan<float> Uvs
        {
            get
            {
                return Copied(ref uvs, face =>
                    Native.Copy(Native.fb_uvs(face.Handle), 2 * (int)Native.fb_uv_count(face.Handle)));
            }
        }

        /// <summary>For each polygon corner the index of its pair; empty without texture coordinates.</summary>
        public ReadOnlySpan<uint> UvCorners
        {
            get
            {
                return Copied(ref uvCorners, face =>
                    Optional(Native.fb_uv_corners(face.Handle), face.PolygonCorners.Length));
            }
        }

        /// <summary>-1 for each vertex where the texture is mirrored, 1 elsewhere: the bitangent is the sign times the cross
        /// product of normal and tangent. Empty without texture coordinates.</summary>
        public ReadOnlySpan<float> TangentSigns
        {
            get
            {
                return Copied(ref tangentSigns, face =>
                {
                    float* from = Native.fb_tangent_signs(face.Handle);
                    return Native.Copy(from, from == null ? 0 : face.VertexCount);
                });
            }
        }

        /// <summary>Baked order: the source's index of each vertex; empty if it is the source's order.</summary>
        public ReadOnlySpan<uint> VertexOrder
        {
            get { return Copied(ref vertexOrder, face => Optional(Native.fb_vertex_order(face.Handle), face.VertexCount)); }
        }

        /// <summary>For each vertex the index of its region in <see cref="ErrorRegions"/>; empty without expected
        /// errors.</summary>
        public ReadOnlySpan<uint> ErrorVertexRegions
        {
            get
            {
                return Copied(ref errorVertexRegions, face =>
                    Optional(Native.fb_error_vertex_regions(face.Handle), face.VertexCount));
            }
        }

        /// <summary>Influences of each vertex in the two spans below; 0 if the face has no skin.</summary>
        public int SkinInfluences
        {
            get { return (int)Native.fb_skin_influences(Handle); }
        }

        /// <summary>Joints that each vertex follows: vertices x <see cref="SkinInfluences"/>.</summary>
        public ReadOnlySpan<ushort> SkinJoints
        {
            get
            {
                return Copied(ref skinJoints, face =>
                    Native.Copy(Native.fb_skin_joints(face.Handle), face.VertexCount * face.SkinInfluences));
            }
        }

        /// <summary>The weight of each, 0 to 1.</summary>
        public ReadOnlySpan<float> SkinWeights
        {
            get
            {
                return Copied(ref skinWeights, face =>
                    Native.Copy(Native.fb_skin_weights(face.Handle), face.VertexCount * face.SkinInfluences));
            }
        }

        /// <summary>Influences of each vertex in the two spans below; 0 if the face has no driven joints.</summary>
        public int DrivenInfluences
        {
            get { return (int)Native.fb_driven_influences(Handle); }
        }

        /// <summary>Driven joints that each vertex follows: vertices x <see cref="DrivenInfluences"/>.</summary>
        public ReadOnlySpan<ushort> DrivenSkinJoints
        {
            get
            {
                return Copied(ref drivenSkinJoints, face =>
                    Native.Copy(Native.fb_driven_skin_joints(face.Handle), face.VertexCount * face.DrivenInfluences));
            }
        }

        /// <summary>The weight of each, 0 to 1; those of a vertex sum to at most 1, and the rest of it does not move. A vertex
        /// of <see cref="PoseBatch.Unskinned"/> positions at p goes to p + the sum of weight x (frame x (inverse of <see
        /// cref="DrivenJoint.Rest"/>) x p - p), with frames of <see cref="PoseBatch.Joints"/>.</summary>
        public ReadOnlySpan<float> DrivenSkinWeights
        {
            get
            {
                return Copied(ref drivenSkinWeights, face =>
                    Native.Copy(Native.fb_driven_skin_weights(face.Handle), face.VertexCount * face.DrivenInfluences));
            }
        }

        /// <summary>A JSON object that says whose the character is and what may be done with it; "" if nothing is
        /// said.</summary>
        public string About
        {
            get { return Copied(ref about, face => Native.Text(Native.fb_about(face.Handle))); }
        }

        /// <summary>A JSON object: how the face was made; "" if nothing is said.</summary>
        public string Provenance
        {
            get { return Copied(ref provenance, face => Native.Text(Native.fb_provenance(face.Handle))); }
        }

        /// <summary>A new array with the bytes of a picture of the character, a square PNG; empty if there is none.</summary>
        public byte[] Thumbnail()
        {
            byte[] copy = null;
            return Copied(ref copy, face =>
            {
                ulong count;
                var bytes = (byte*)Native.fb_thumbnail(face.Handle, &count);
                return Native.Copy(bytes, (int)count);
            });
        }

        private static uint[] Optional(uint* from, int count)
        {
            return Native.Copy(from, from == null ? 0 : count);
        }
    }
}
