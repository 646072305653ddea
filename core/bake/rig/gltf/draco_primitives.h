// Primitives that KHR_draco_mesh_compression compresses.
#pragma once

namespace tinygltf {
class Model;
}  // namespace tinygltf

namespace fb::bake {

// Decodes the indices and attributes of the compressed primitives into buffers of their own, to which the primitives'
// accessors refer from then on. Attributes that the extension does not name stay as they are. Fails with bad_data,
// naming mesh and primitive, on what is not whole or does not have as many elements as the file says, with unsupported
// on bitstreams before 2.2, and with limit beyond 2 GiB in all.
void decode_draco_primitives(tinygltf::Model& model);

}  // namespace fb::bake
