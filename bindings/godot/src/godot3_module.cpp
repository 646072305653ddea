/** @file
 * The GDNative module for Godot 3.x: the class FaceBakerFace of godot_face.h as a NativeScript.
 */
#include <gdnative_api_struct.gen.h>

#include <cstring>
#include <exception>

#include "godot_face.h"

namespace facebaker::godot {
namespace {

const godot_gdnative_core_api_struct* api = nullptr;
const godot_gdnative_ext_nativescript_api_struct* nativescript = nullptr;
constexpr const char* class_name = "FaceBakerFace";

void report(const char* sentence, const char* function) {
  api->godot_print_error(sentence, function, "facebaker", 0);
}

// An argument that is converted to plain values, and keeps Godot's array alive meanwhile.
class Argument {
 public:
  Argument(const godot_variant* from, Kind kind) {
    value.kind = kind;
    switch (kind) {
      case Kind::boolean:
        value.integer = api->godot_variant_as_bool(from);
        break;
      case Kind::integer:
        value.integer = api->godot_variant_as_int(from);
        break;
      case Kind::real:
        value.real = api->godot_variant_as_real(from);
        break;
      case Kind::text:
        take_text(from);
        break;
      case Kind::bytes:
        bytes_ = api->godot_variant_as_pool_byte_array(from);
        read_bytes_ = api->godot_pool_byte_array_read(&bytes_);
        value.data = api->godot_pool_byte_array_read_access_ptr(read_bytes_);
        value.count = static_cast<std::size_t>(api->godot_pool_byte_array_size(&bytes_));
        break;
      case Kind::floats:
        floats_ = api->godot_variant_as_pool_real_array(from);
        read_floats_ = api->godot_pool_real_array_read(&floats_);
        value.data = api->godot_pool_real_array_read_access_ptr(read_floats_);
        value.count = static_cast<std::size_t>(api->godot_pool_real_array_size(&floats_));
        break;
      default:
        break;  // no method has others
    }
  }
  Argument(const Argument&) = delete;
  Argument& operator=(const Argument&) = delete;
  ~Argument() {
    if (read_bytes_) {
      api->godot_pool_byte_array_read_access_destroy(read_bytes_);
      api->godot_pool_byte_array_destroy(&bytes_);
    }
    if (read_floats_) {
      api->godot_pool_real_array_read_access_destroy(read_floats_);
      api->godot_pool_real_array_destroy(&floats_);
    }
  }

  Value value;

 private:
  void take_text(const godot_variant* from) {
    godot_string string = api->godot_variant_as_string(from);
    godot_char_string utf8 = api->godot_string_utf8(&string);
    value.text.assign(api->godot_char_string_get_data(&utf8),
                      static_cast<std::size_t>(api->godot_char_string_length(&utf8)));
    api->godot_char_string_destroy(&utf8);
    api->godot_string_destroy(&string);
  }

  godot_pool_byte_array bytes_;
  godot_pool_byte_array_read_access* read_bytes_ = nullptr;
  godot_pool_real_array floats_;
  godot_pool_real_array_read_access* read_floats_ = nullptr;
};

// A variant with a copy of an array of the value; the functions are those of Godot's array of that kind.
template <typename Array, typename Access, typename Element>
godot_variant array_variant(const Value& value, std::size_t element_bytes, void (*make)(Array*),
                            void (*resize)(Array*, const godot_int), Access* (*write)(Array*),
                            Element* (*pointer)(const Access*), void (*end_write)(Access*),
                            void (*to_variant)(godot_variant*, const Array*), void (*destroy)(Array*)) {
  Array array;
  make(&array);
  resize(&array, static_cast<godot_int>(value.count));
  if (value.count > 0) {
    Access* access = write(&array);
    std::memcpy(static_cast<void*>(pointer(access)), value.data, value.count * element_bytes);
    end_write(access);
  }
  godot_variant made;
  to_variant(&made, &array);
  destroy(&array);
  return made;
}

#define FB_POOL_ARRAY(kind, bytes)                                                                               \
  array_variant(value, bytes, api->godot_pool_##kind##_array_new, api->godot_pool_##kind##_array_resize,         \
                api->godot_pool_##kind##_array_write, api->godot_pool_##kind##_array_write_access_ptr,           \
                api->godot_pool_##kind##_array_write_access_destroy, api->godot_variant_new_pool_##kind##_array, \
                api->godot_pool_##kind##_array_destroy)

godot_variant to_variant(const Value& value) {
  godot_variant made;
  switch (value.kind) {
    case Kind::boolean:
      api->godot_variant_new_bool(&made, value.integer != 0);
      break;
    case Kind::integer:
      api->godot_variant_new_int(&made, value.integer);
      break;
    case Kind::real:
      api->godot_variant_new_real(&made, value.real);
      break;
    case Kind::text: {
      godot_string string;
      api->godot_string_new(&string);
      api->godot_string_parse_utf8_with_len(&string, value.text.c_str(), static_cast<godot_int>(value.text.size()));
      api->godot_variant_new_string(&made, &string);
      api->godot_string_destroy(&string);
      break;
    }
    case Kind::bytes:
      return FB_POOL_ARRAY(byte, 1);
    case Kind::integers:
      return FB_POOL_ARRAY(int, sizeof(godot_int));
    case Kind::floats:
      return FB_POOL_ARRAY(real, sizeof(godot_real));
    case Kind::vectors2:
      return FB_POOL_ARRAY(vector2, 2 * sizeof(float));
    case Kind::vectors3:
      return FB_POOL_ARRAY(vector3, 3 * sizeof(float));
    case Kind::nothing:
      api->godot_variant_new_nil(&made);
      break;
  }
  return made;
}

#undef FB_POOL_ARRAY

GDCALLINGCONV void* create(godot_object*, void*) {
  try {
    return new GodotFace;
  } catch (const std::exception& exception) {
    report(exception.what(), class_name);
    return nullptr;
  }
}

GDCALLINGCONV void destroy(godot_object*, void*, void* instance) {
  delete static_cast<GodotFace*>(instance);
}

GDCALLINGCONV godot_variant call(godot_object*, void* method_data, void* instance, int count, godot_variant** given) {
  const Method& method = *static_cast<const Method*>(method_data);
  Value result;
  std::string error;
  if (!instance) {
    report("memory is short", method.name);
  } else if (count != static_cast<int>(method.arguments.size())) {
    report("wrong number of arguments", method.name);
  } else if (count == 0) {
    result = static_cast<GodotFace*>(instance)->call(method, nullptr, error);
  } else {  // no method has more than two
    const Argument first(given[0], method.arguments[0]);
    const Argument second(given[count - 1], method.arguments[static_cast<std::size_t>(count) - 1]);
    const Value values[] = {first.value, second.value};
    result = static_cast<GodotFace*>(instance)->call(method, values, error);
  }
  if (!error.empty()) report(error.c_str(), method.name);
  return to_variant(result);
}

}  // namespace
}  // namespace facebaker::godot

#ifdef _WIN32
#define FB_MODULE_EXPORT __declspec(dllexport)
#else
#define FB_MODULE_EXPORT __attribute__((visibility("default")))
#endif

extern "C" {

FB_MODULE_EXPORT void godot_gdnative_init(godot_gdnative_init_options* options) {
  using namespace facebaker::godot;
  api = options->api_struct;
  for (unsigned i = 0; i < api->num_extensions; ++i)
    if (api->extensions[i]->type == GDNATIVE_EXT_NATIVESCRIPT)
      nativescript = reinterpret_cast<const godot_gdnative_ext_nativescript_api_struct*>(api->extensions[i]);
}

FB_MODULE_EXPORT void godot_gdnative_terminate(godot_gdnative_terminate_options*) {
  facebaker::godot::api = nullptr;
  facebaker::godot::nativescript = nullptr;
}

FB_MODULE_EXPORT void godot_nativescript_init(void* handle) {
  using namespace facebaker::godot;
  if (!nativescript) return;
  const godot_instance_create_func creation = {create, nullptr, nullptr};
  const godot_instance_destroy_func destruction = {destroy, nullptr, nullptr};
  nativescript->godot_nativescript_register_tool_class(handle, class_name, "Reference", creation, destruction);
  for (const Method& method : methods()) {
    const godot_instance_method callable = {call, const_cast<Method*>(&method), nullptr};
    nativescript->godot_nativescript_register_method(handle, class_name, method.name, {GODOT_METHOD_RPC_MODE_DISABLED},
                                                     callable);
  }
}
}
