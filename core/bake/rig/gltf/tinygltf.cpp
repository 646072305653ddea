// The one translation unit of tinygltf; see CMakeLists.txt for its settings.
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
