using System;
using System.Collections.Generic;

namespace FaceBaker
{
    /// <summary>A control of a face: one float of a pose.</summary>
    public sealed class Control
    {
        internal unsafe Control(int index, fb_control* from)
        {
            Index = index;
            Name = Native.Text(from->name);
            Group = Native.Text(from->group);
            Minimum = from->minimum;
            Maximum = from->maximum;
            Rest = from->rest;
            Mirror = from->mirror == Native.FB_NO_CONTROL ? -1 : (int)from->mirror;
            ArKit = Native.Text(from->arkit);
            Facs = Native.Text(from->facs);
            Unit = Native.Text(from->unit);
        }

        /// <summary>Its place in poses.</summary>
        public int Index { get; private set; }
        /// <summary>Unique, not empty.</summary>
        public string Name { get; private set; }
        /// <summary>The control group that it belongs to; "" if it has none.</summary>
        public string Group { get; private set; }
        /// <summary>Lower end of its range.</summary>
        public float Minimum { get; private set; }
        /// <summary>Upper end of its range.</summary>
        public float Maximum { get; private set; }
        /// <summary>Value in the rest pose.</summary>
        public float Rest { get; private set; }
        /// <summary>Index of the control that does the same on the other side; -1: none is known.</summary>
        public int Mirror { get; private set; }
        /// <summary>Its name among ARKit's face blendshapes, such as "jawOpen"; "" if it has none.</summary>
        public string ArKit { get; private set; }
        /// <summary>Its action unit in FACS, such as "AU26"; "" if it has none.</summary>
        public string Facs { get; private set; }
        /// <summary>Of its values, such as "degrees"; "" if it has none.</summary>
        public string Unit { get; private set; }
    }

    /// <summary>Consecutive polygons of a mesh that have one material.</summary>
    public struct MaterialRun
    {
        internal MaterialRun(fb_material_run from)
        {
            PolygonCount = (int)from.polygon_count;
            Material = from.material == Native.FB_NO_MATERIAL ? -1 : (int)from.material;
        }

        /// <summary>At least 1.</summary>
        public readonly int PolygonCount;
        /// <summary>Index of a material; -1: none.</summary>
        public readonly int Material;
    }

    /// <summary>One of the meshes of a character, which share one pool of vertices, polygons and corners.</summary>
    public sealed class FaceMesh
    {
        internal unsafe FaceMesh(fb_mesh* from)
        {
            Name = Native.Text(from->name);
            VertexCount = (int)from->vertex_count;
            PolygonCount = (int)from->polygon_count;
            FirstVertex = (int)from->first_vertex;
            FirstPolygon = (int)from->first_polygon;
            FirstCorner = (int)from->first_corner;
            CornerCount = (int)from->corner_count;
            var runs = new MaterialRun[from->run_count];
            for (int i = 0; i < runs.Length; ++i) runs[i] = new MaterialRun(from->runs[i]);
            Runs = Array.AsReadOnly(runs);
        }

        /// <summary>Unique; "" for the one mesh of a face whose source names none.</summary>
        public string Name { get; private set; }
        /// <summary>Vertices, from <see cref="FirstVertex"/> of the face.</summary>
        public int VertexCount { get; private set; }
        /// <summary>Polygons, from <see cref="FirstPolygon"/> of the face; may be 0.</summary>
        public int PolygonCount { get; private set; }
        /// <summary>Index of its first vertex, as in positions.</summary>
        public int FirstVertex { get; private set; }
        /// <summary>Index of its first polygon, as in <see cref="Face.PolygonSizes"/>.</summary>
        public int FirstPolygon { get; private set; }
        /// <summary>Index of its first corner, as in <see cref="Face.PolygonCorners"/>.</summary>
        public int FirstCorner { get; private set; }
        /// <summary>Corners of all its polygons.</summary>
        public int CornerCount { get; private set; }
        /// <summary>Its polygons by material, in order.</summary>
        public IReadOnlyList<MaterialRun> Runs { get; private set; }
    }

    /// <summary>A texture of a material, with the meaning of glTF 2.0.</summary>
    public struct FaceTexture
    {
        internal FaceTexture(fb_texture from)
        {
            Slot = (TextureSlot)from.slot;
            Image = (int)from.image;
            WrapU = (TextureWrap)from.wrap_u;
            WrapV = (TextureWrap)from.wrap_v;
            Scale = from.scale;
        }

        /// <summary>What it is to its material.</summary>
        public readonly TextureSlot Slot;
        /// <summary>Index of an image.</summary>
        public readonly int Image;
        /// <summary>How it goes on beyond its borders along u.</summary>
        public readonly TextureWrap WrapU;
        /// <summary>The same along v.</summary>
        public readonly TextureWrap WrapV;
        /// <summary>Of a normal texture; strength of an occlusion texture; 1 in other slots.</summary>
        public readonly float Scale;
    }

    /// <summary>What a texture is to a material.</summary>
    public enum TextureSlot
    {
        /// <summary>sRGB colour and alpha.</summary>
        BaseColour = Native.FB_TEXTURE_BASE_COLOUR,
        /// <summary>Roughness in green, metallic in blue.</summary>
        MetallicRoughness = Native.FB_TEXTURE_METALLIC_ROUGHNESS,
        /// <summary>Normals in tangent space.</summary>
        Normal = Native.FB_TEXTURE_NORMAL,
        /// <summary>Ambient occlusion, in red.</summary>
        Occlusion = Native.FB_TEXTURE_OCCLUSION,
        /// <summary>sRGB colour that is emitted.</summary>
        Emissive = Native.FB_TEXTURE_EMISSIVE
    }

    /// <summary>How a texture goes on beyond its borders.</summary>
    public enum TextureWrap
    {
        /// <summary>It begins again.</summary>
        Repeat = Native.FB_WRAP_REPEAT,
        /// <summary>Its edge goes on.</summary>
        Clamp = Native.FB_WRAP_CLAMP,
        /// <summary>It goes back.</summary>
        Mirror = Native.FB_WRAP_MIRROR
    }

    /// <summary>What alpha means.</summary>
    public enum AlphaMode
    {
        /// <summary>Nothing.</summary>
        Opaque = Native.FB_ALPHA_OPAQUE,
        /// <summary>Transparent below the cutoff.</summary>
        Mask = Native.FB_ALPHA_MASK,
        /// <summary>How much of the surface covers what is behind it.</summary>
        Blend = Native.FB_ALPHA_BLEND
    }

    /// <summary>A material, with the meaning of glTF 2.0.</summary>
    public sealed class FaceMaterial
    {
        internal unsafe FaceMaterial(fb_material* from)
        {
            Name = Native.Text(from->name);
            AlphaMode = (AlphaMode)from->alpha_mode;
            BaseColour = Array.AsReadOnly(Native.Copy(from->base_colour, 4));
            Metallic = from->metallic;
            Roughness = from->roughness;
            Emissive = Array.AsReadOnly(Native.Copy(from->emissive, 3));
            AlphaCutoff = from->alpha_cutoff;
            DoubleSided = from->double_sided != 0;
            var textures = new FaceTexture[from->texture_count];
            for (int i = 0; i < textures.Length; ++i) textures[i] = new FaceTexture(from->textures[i]);
            Textures = Array.AsReadOnly(textures);
        }

        /// <summary>May be "".</summary>
        public string Name { get; private set; }
        /// <summary>What alpha means.</summary>
        public AlphaMode AlphaMode { get; private set; }
        /// <summary>Linear red, green and blue, and alpha.</summary>
        public IReadOnlyList<float> BaseColour { get; private set; }
        /// <summary>0 to 1.</summary>
        public float Metallic { get; private set; }
        /// <summary>0 to 1.</summary>
        public float Roughness { get; private set; }
        /// <summary>Linear red, green and blue.</summary>
        public IReadOnlyList<float> Emissive { get; private set; }
        /// <summary>Of <see cref="AlphaMode.Mask"/>.</summary>
        public float AlphaCutoff { get; private set; }
        /// <summary>Seen from both sides.</summary>
        public bool DoubleSided { get; private set; }
        /// <summary>At most one a slot.</summary>
        public IReadOnlyList<FaceTexture> Textures { get; private set; }
    }

    /// <summary>A picture file as it is, such as a texture.</summary>
    public sealed class FaceImage
    {
        internal unsafe FaceImage(fb_image* from)
        {
            Name = Native.Text(from->name);
            MediaType = Native.Text(from->media_type);
            Bytes = Native.Copy((byte*)from->bytes, checked((int)from->byte_count));
        }

        /// <summary>May be "".</summary>
        public string Name { get; private set; }
        /// <summary>"image/png", "image/jpeg", ...</summary>
        public string MediaType { get; private set; }
        /// <summary>The file's bytes.</summary>
        public ReadOnlyMemory<byte> Bytes { get; private set; }
    }

    /// <summary>A named frame that follows the surface, for what hangs on it.</summary>
    public sealed class FaceSocket
    {
        internal unsafe FaceSocket(fb_socket* from)
        {
            Name = Native.Text(from->name);
            Frame = Array.AsReadOnly(Native.Copy(from->frame, Native.FB_FRAME_FLOATS));
        }

        /// <summary>Unique, not empty.</summary>
        public string Name { get; private set; }
        /// <summary>At rest: the upper three rows of a 4 x 4 matrix.</summary>
        public IReadOnlyList<float> Frame { get; private set; }
    }

    /// <summary>A named number that comes with each pose: the weight of a wrinkle map, the turn of an eye.</summary>
    public sealed class FaceChannel
    {
        internal unsafe FaceChannel(fb_channel* from)
        {
            Name = Native.Text(from->name);
            Unit = Native.Text(from->unit);
            Minimum = from->minimum;
            Maximum = from->maximum;
            Rest = from->rest;
        }

        /// <summary>Unique, not empty.</summary>
        public string Name { get; private set; }
        /// <summary>Of its values; may be "".</summary>
        public string Unit { get; private set; }
        /// <summary>Values are at least this.</summary>
        public float Minimum { get; private set; }
        /// <summary>Values are at most this.</summary>
        public float Maximum { get; private set; }
        /// <summary>In the rest pose.</summary>
        public float Rest { get; private set; }
    }

    /// <summary>A joint of the skeleton that carries the face. Positions are before its skin.</summary>
    public sealed class FaceJoint
    {
        internal unsafe FaceJoint(fb_joint* from)
        {
            Name = Native.Text(from->name);
            Parent = from->parent == Native.FB_NO_JOINT ? -1 : (int)from->parent;
            Rest = Array.AsReadOnly(Native.Copy(from->rest, Native.FB_FRAME_FLOATS));
            InverseBind = Array.AsReadOnly(Native.Copy(from->inverse_bind, Native.FB_FRAME_FLOATS));
        }

        /// <summary>Unique, not empty.</summary>
        public string Name { get; private set; }
        /// <summary>Index of its parent, less than its own; -1: none.</summary>
        public int Parent { get; private set; }
        /// <summary>At rest, as a frame in its parent: the upper three rows of a 4 x 4 matrix.</summary>
        public IReadOnlyList<float> Rest { get; private set; }
        /// <summary>From the space of positions to the joint's, a frame likewise.</summary>
        public IReadOnlyList<float> InverseBind { get; private set; }
    }

    /// <summary>How controls move a driven joint within its parent, along the axes of its own frame at rest.</summary>
    [Flags]
    public enum JointNumbers
    {
        /// <summary>With its parent only.</summary>
        None = 0,
        /// <summary>Turns about its x axis.</summary>
        RotateX = (int)Native.FB_JOINT_ROTATE_X,
        /// <summary>Turns about its y axis.</summary>
        RotateY = (int)Native.FB_JOINT_ROTATE_Y,
        /// <summary>Turns about its z axis.</summary>
        RotateZ = (int)Native.FB_JOINT_ROTATE_Z,
        /// <summary>All three; by less than a half turn.</summary>
        Rotate = (int)Native.FB_JOINT_ROTATE,
        /// <summary>Moves along its x axis.</summary>
        MoveX = (int)Native.FB_JOINT_MOVE_X,
        /// <summary>Moves along its y axis.</summary>
        MoveY = (int)Native.FB_JOINT_MOVE_Y,
        /// <summary>Moves along its z axis.</summary>
        MoveZ = (int)Native.FB_JOINT_MOVE_Z,
        /// <summary>All three.</summary>
        Move = (int)Native.FB_JOINT_MOVE,
        /// <summary>Is longer or shorter along its x axis.</summary>
        ScaleX = (int)Native.FB_JOINT_SCALE_X,
        /// <summary>Is longer or shorter along its y axis.</summary>
        ScaleY = (int)Native.FB_JOINT_SCALE_Y,
        /// <summary>Is longer or shorter along its z axis.</summary>
        ScaleZ = (int)Native.FB_JOINT_SCALE_Z,
        /// <summary>All three.</summary>
        Scale = (int)Native.FB_JOINT_SCALE,
        /// <summary>Turns about a point that moves along its x axis.</summary>
        PivotX = (int)Native.FB_JOINT_PIVOT_X,
        /// <summary>Turns about a point that moves along its y axis.</summary>
        PivotY = (int)Native.FB_JOINT_PIVOT_Y,
        /// <summary>Turns about a point that moves along its z axis.</summary>
        PivotZ = (int)Native.FB_JOINT_PIVOT_Z,
        /// <summary>All three; from its origin.</summary>
        Pivot = (int)Native.FB_JOINT_PIVOT
    }

    /// <summary>A joint that the controls move: of a jaw, a tongue, an eye. Positions have it in them; where it is in a pose,
    /// <see cref="PoseBatch.Joints"/> gives.</summary>
    public sealed class DrivenJoint
    {
        internal unsafe DrivenJoint(fb_driven_joint* from)
        {
            Name = Native.Text(from->name);
            Parent = from->parent == Native.FB_NO_JOINT ? -1 : (int)from->parent;
            Numbers = (JointNumbers)from->numbers;
            OuterRotations = (int)from->outer_rotations;
            Rest = Array.AsReadOnly(Native.Copy(from->rest, Native.FB_FRAME_FLOATS));
        }

        /// <summary>Unique, not empty.</summary>
        public string Name { get; private set; }
        /// <summary>Index of its parent among <see cref="Face.DrivenJoints"/>, less than its own; -1: none.</summary>
        public int Parent { get; private set; }
        /// <summary>How controls move it within its parent.</summary>
        public JointNumbers Numbers { get; private set; }
        /// <summary>How many rotations it turns by beside its first, each after those before it.</summary>
        public int OuterRotations { get; private set; }
        /// <summary>Its frame at rest, in the space of positions: the upper three rows of a 4 x 4 matrix.</summary>
        public IReadOnlyList<float> Rest { get; private set; }
    }

    /// <summary>A pose that comes out as the rig gave it.</summary>
    public sealed class ExactPose
    {
        internal unsafe ExactPose(fb_exact_pose* from)
        {
            Name = Native.Text(from->name);
            Controls = Array.AsReadOnly(Native.Copy(from->controls, (int)from->control_count));
        }

        /// <summary>"CLIP:FRAME".</summary>
        public string Name { get; private set; }
        /// <summary>The values of the pose.</summary>
        public IReadOnlyList<float> Controls { get; private set; }
    }

    /// <summary>Consecutive rows of the basis that use the same coefficients, for hosts whose GPU moves the vertices. Row 3 i +
    /// axis is coordinate `axis` of vertex i in baked order (<see cref="Face.VertexOrder"/>). Driven joints move vertices after
    /// that.</summary>
    public sealed class RowBlock
    {
        private readonly uint[] columns;
        private readonly float[] values;

        internal RowBlock(fb_row_block from, uint[] columns, float[] values)
        {
            FirstRow = (int)from.first_row;
            RowCount = (int)from.row_count;
            this.columns = columns;
            this.values = values;
        }

        /// <summary>Row blocks follow each other without gaps.</summary>
        public int FirstRow { get; private set; }
        /// <summary>Rows in it.</summary>
        public int RowCount { get; private set; }
        /// <summary>The coefficients that it uses, ascending.</summary>
        public ReadOnlySpan<uint> Columns { get { return columns; } }
        /// <summary>Column after column, <see cref="RowCount"/> floats each: the displacements for one unit of the coefficient.
        /// </summary>
        public ReadOnlySpan<float> Values { get { return values; } }
    }

    /// <summary>A level of detail: the character at fewer vertices. Level 0 is the whole.</summary>
    public sealed class FaceLevel
    {
        private readonly uint[] sizes, corners, uvCorners;

        internal unsafe FaceLevel(fb_level* from, int meshCount)
        {
            VertexCount = (int)from->vertex_count;
            CoefficientCount = (int)from->coefficient_count;
            sizes = Native.Copy(from->polygon_sizes, (int)from->polygon_count);
            corners = Native.Copy(from->polygon_corners, (int)from->corner_count);
            uvCorners = Native.Copy(from->uv_corners, from->uv_corners == null ? 0 : (int)from->corner_count);
            var meshes = new FaceMesh[meshCount];
            for (int i = 0; i < meshes.Length; ++i) meshes[i] = new FaceMesh(from->meshes + i);
            Meshes = Array.AsReadOnly(meshes);
        }

        /// <summary>The first so many in baked order, see <see cref="Face.VertexOrder"/>.</summary>
        public int VertexCount { get; private set; }
        /// <summary>Coefficients that move its vertices.</summary>
        public int CoefficientCount { get; private set; }
        /// <summary>Corners of each polygon.</summary>
        public ReadOnlySpan<uint> PolygonSizes { get { return sizes; } }
        /// <summary>Vertex indices in the source's order, polygon after polygon.</summary>
        public ReadOnlySpan<uint> PolygonCorners { get { return corners; } }
        /// <summary>For each corner the index of its pair in <see cref="Face.Uvs"/>; empty without texture
        /// coordinates.</summary>
        public ReadOnlySpan<uint> UvCorners { get { return uvCorners; } }
        /// <summary>As <see cref="Face.Meshes"/>, with this level's polygons.</summary>
        public IReadOnlyList<FaceMesh> Meshes { get; private set; }
    }
}
