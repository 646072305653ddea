// Buffer views that EXT_meshopt_compression or KHR_meshopt_compression compresses.
#pragma once

#include <string>

namespace tinygltf {
class Model;
}  // namespace tinygltf

namespace fb::bake {

// Whether a glTF extension is one of those by name.
bool is_meshopt_extension(const std::string& name);

// Decodes the compressed views into buffers of their own, to which they refer from then on. Fails with bad_data, naming
// the view, on what is not whole, with unsupported on newer versions of the codec, and with limit beyond 2 GiB in all.
void decode_meshopt_views(tinygltf::Model& model);

}  // namespace fb::bake
