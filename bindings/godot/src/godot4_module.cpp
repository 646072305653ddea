/** @file
 * The GDExtension for Godot 4.2 and later: the class FaceBakerFace of godot_face.h.
 */
#include <gdextension_interface.h>

#include <array>
#include <cstring>
#include <exception>

#include "godot_face.h"

namespace facebaker::godot {
namespace {

// Sizes of Godot's types on 64-bit platforms in builds with single precision.
struct alignas(8) OpaqueString {
  unsigned char bytes[8];
};
struct alignas(8) OpaqueArray {
  unsigned char bytes[16];
};

// The arrays that methods use.
struct ArrayType {
  Kind kind;
  GDExtensionVariantType type;
  const char* element_function;
  std::size_t element_bytes;
  GDExtensionPtrConstructor construct;
  GDExtensionPtrDestructor destroy;
  GDExtensionPtrBuiltInMethod resize, size;
  void* (*element)(void*, GDExtensionInt);
};

struct Api {
  GDExtensionInterfacePrintError print_error;
  GDExtensionInterfaceStringNewWithUtf8CharsAndLen string_new;
  GDExtensionInterfaceStringToUtf8Chars string_to_utf8;
  GDExtensionInterfaceStringNameNewWithLatin1Chars name_new;
  GDExtensionInterfaceGetVariantFromTypeConstructor variant_from_type;
  GDExtensionInterfaceGetVariantToTypeConstructor variant_to_type;
  GDExtensionInterfaceVariantGetPtrConstructor constructor;
  GDExtensionInterfaceVariantGetPtrDestructor destructor;
  GDExtensionInterfaceVariantGetPtrBuiltinMethod builtin_method;
  GDExtensionInterfaceVariantDestroy variant_destroy;
  GDExtensionInterfaceVariantGetType variant_type;
  GDExtensionInterfaceClassdbConstructObject construct_object;
  GDExtensionInterfaceObjectSetInstance set_instance;
  GDExtensionInterfaceClassdbRegisterExtensionClass2 register_class;
  GDExtensionInterfaceClassdbRegisterExtensionClassMethod register_method;
  GDExtensionInterfaceClassdbUnregisterExtensionClass unregister_class;
  GDExtensionPtrDestructor string_destroy, name_destroy;
};

Api api;
GDExtensionClassLibraryPtr library = nullptr;
std::array<ArrayType, 5> arrays = {{
    {Kind::bytes,
     GDEXTENSION_VARIANT_TYPE_PACKED_BYTE_ARRAY,
     "packed_byte_array_operator_index",
     1,
     {},
     {},
     {},
     {},
     {}},
    {Kind::integers,
     GDEXTENSION_VARIANT_TYPE_PACKED_INT32_ARRAY,
     "packed_int32_array_operator_index",
     4,
     {},
     {},
     {},
     {},
     {}},
    {Kind::floats,
     GDEXTENSION_VARIANT_TYPE_PACKED_FLOAT32_ARRAY,
     "packed_float32_array_operator_index",
     4,
     {},
     {},
     {},
     {},
     {}},
    {Kind::vectors2,
     GDEXTENSION_VARIANT_TYPE_PACKED_VECTOR2_ARRAY,
     "packed_vector2_array_operator_index",
     8,
     {},
     {},
     {},
     {},
     {}},
    {Kind::vectors3,
     GDEXTENSION_VARIANT_TYPE_PACKED_VECTOR3_ARRAY,
     "packed_vector3_array_operator_index",
     12,
     {},
     {},
     {},
     {},
     {}},
}};

const ArrayType* array_of(Kind kind) {
  for (const ArrayType& array : arrays)
    if (array.kind == kind) return &array;
  return nullptr;
}

GDExtensionVariantType type_of(Kind kind) {
  switch (kind) {
    case Kind::boolean:
      return GDEXTENSION_VARIANT_TYPE_BOOL;
    case Kind::integer:
      return GDEXTENSION_VARIANT_TYPE_INT;
    case Kind::real:
      return GDEXTENSION_VARIANT_TYPE_FLOAT;
    case Kind::text:
      return GDEXTENSION_VARIANT_TYPE_STRING;
    case Kind::nothing:
      return GDEXTENSION_VARIANT_TYPE_NIL;
    default:
      return array_of(kind)->type;
  }
}

void report(const char* sentence, const char* function) {
  api.print_error(sentence, function, "facebaker", 0, true);
}

// A name as Godot has it.
class Name {
 public:
  explicit Name(const char* text) { api.name_new(&value_, text, false); }
  Name(const Name&) = delete;
  Name& operator=(const Name&) = delete;
  ~Name() { api.name_destroy(&value_); }
  void* get() { return &value_; }

 private:
  OpaqueString value_;
};

// An argument in place, by its type, as plain values; arrays are read where they are.
Value read(const void* from, Kind kind) {
  Value value;
  value.kind = kind;
  switch (kind) {
    case Kind::boolean:
      value.integer = *static_cast<const GDExtensionBool*>(from);
      break;
    case Kind::integer:
      value.integer = *static_cast<const std::int64_t*>(from);
      break;
    case Kind::real:
      value.real = *static_cast<const double*>(from);
      break;
    case Kind::text: {
      const GDExtensionInt length = api.string_to_utf8(from, nullptr, 0);
      value.text.resize(static_cast<std::size_t>(length));
      api.string_to_utf8(from, value.text.data(), length);
      break;
    }
    case Kind::nothing:
      break;
    default: {
      const ArrayType& array = *array_of(kind);
      std::int64_t count = 0;
      void* self = const_cast<void*>(from);
      array.size(self, nullptr, &count, 0);
      value.count = static_cast<std::size_t>(count);
      // Elements lie one behind the other.
      if (count > 0) value.data = array.element(self, 0);
    }
  }
  return value;
}

// Makes a typed value in uninitialised memory.
void construct(const Value& value, Kind kind, void* to) {
  switch (kind) {
    case Kind::boolean:
      *static_cast<GDExtensionBool*>(to) = value.integer != 0;
      break;
    case Kind::integer:
      *static_cast<std::int64_t*>(to) = value.integer;
      break;
    case Kind::real:
      *static_cast<double*>(to) = value.real;
      break;
    case Kind::text:
      api.string_new(to, value.text.data(), static_cast<GDExtensionInt>(value.text.size()));
      break;
    case Kind::nothing:
      break;
    default: {
      const ArrayType& array = *array_of(kind);
      array.construct(to, nullptr);
      const std::int64_t count = static_cast<std::int64_t>(value.count);
      std::int64_t status = 0;
      const GDExtensionConstTypePtr arguments[] = {&count};
      array.resize(to, arguments, &status, 1);
      if (count > 0 && status == 0) std::memcpy(array.element(to, 0), value.data, value.count * array.element_bytes);
    }
  }
}

void destroy(Kind kind, void* typed) {
  if (kind == Kind::text)
    api.string_destroy(typed);
  else if (const ArrayType* array = array_of(kind))
    array->destroy(typed);
}

Value call(GDExtensionClassInstancePtr instance, const Method& method, const Value* values) {
  std::string error;
  const Value result = static_cast<GodotFace*>(instance)->call(method, values, error);
  if (!error.empty()) report(error.c_str(), method.name);
  return result;
}

// Typed arguments, typed result.
void call_typed(void* userdata, GDExtensionClassInstancePtr instance, const GDExtensionConstTypePtr* arguments,
                GDExtensionTypePtr result) {
  const Method& method = *static_cast<const Method*>(userdata);
  std::array<Value, 2> values;  // no method has more
  for (std::size_t i = 0; i < method.arguments.size(); ++i) values[i] = read(arguments[i], method.arguments[i]);
  const Value made = call(instance, method, values.data());
  if (method.result == Kind::nothing) return;
  destroy(method.result, result);  // what Godot has made there
  construct(made, method.result, result);
}

// Arguments and result as variants.
void call_variants(void* userdata, GDExtensionClassInstancePtr instance, const GDExtensionConstVariantPtr* arguments,
                   GDExtensionInt count, GDExtensionVariantPtr result, GDExtensionCallError* error) {
  const Method& method = *static_cast<const Method*>(userdata);
  const GDExtensionInt wanted = static_cast<GDExtensionInt>(method.arguments.size());
  error->error = GDEXTENSION_CALL_OK;
  if (count != wanted) {
    error->error =
        count < wanted ? GDEXTENSION_CALL_ERROR_TOO_FEW_ARGUMENTS : GDEXTENSION_CALL_ERROR_TOO_MANY_ARGUMENTS;
    error->expected = static_cast<std::int32_t>(wanted);
    return;
  }
  std::array<OpaqueArray, 2> typed;
  std::array<Value, 2> values;
  std::size_t ready = 0;
  for (; ready < method.arguments.size(); ++ready) {
    const GDExtensionVariantType type = type_of(method.arguments[ready]), given = api.variant_type(arguments[ready]);
    const bool number = type == GDEXTENSION_VARIANT_TYPE_FLOAT && given == GDEXTENSION_VARIANT_TYPE_INT;
    if (type != given && !number) {
      error->error = GDEXTENSION_CALL_ERROR_INVALID_ARGUMENT;
      error->argument = static_cast<std::int32_t>(ready);
      error->expected = static_cast<std::int32_t>(type);
      break;
    }
    api.variant_to_type(type)(&typed[ready], const_cast<void*>(arguments[ready]));
    values[ready] = read(&typed[ready], method.arguments[ready]);
  }
  if (error->error == GDEXTENSION_CALL_OK) {
    const Value made = call(instance, method, values.data());
    if (method.result != Kind::nothing) {
      OpaqueArray typed_result;
      construct(made, method.result, &typed_result);
      api.variant_destroy(result);
      api.variant_from_type(type_of(method.result))(result, &typed_result);
      destroy(method.result, &typed_result);
    }
  }
  for (std::size_t i = 0; i < ready; ++i) destroy(method.arguments[i], &typed[i]);
}

GDExtensionObjectPtr create(void*) {
  Name parent("RefCounted"), name("FaceBakerFace");
  GDExtensionObjectPtr object = api.construct_object(parent.get());
  try {
    api.set_instance(object, name.get(), new GodotFace);
  } catch (const std::exception& exception) {
    report(exception.what(), "FaceBakerFace");
  }
  return object;
}

void free_instance(void*, GDExtensionClassInstancePtr instance) {
  delete static_cast<GodotFace*>(instance);
}

// What a parameter or a result is, with the names it points to.
struct Property {
  Property(Kind kind, const char* text) : name(text), none("") {
    api.string_new(&hint, "", 0);
    info.type = type_of(kind);
    info.name = name.get();
    info.class_name = none.get();
    info.hint_string = &hint;
    info.usage = 6;  // PROPERTY_USAGE_DEFAULT
  }
  ~Property() { api.string_destroy(&hint); }
  Property(const Property&) = delete;
  Property& operator=(const Property&) = delete;

  Name name, none;
  OpaqueString hint;
  GDExtensionPropertyInfo info{};
};

void register_method(const Method& method) {
  Name owner("FaceBakerFace"), name(method.name);
  Property result(method.result, ""), first(method.arguments.empty() ? Kind::nothing : method.arguments[0], "first"),
      second(method.arguments.size() < 2 ? Kind::nothing : method.arguments[1], "second");
  GDExtensionPropertyInfo arguments[] = {first.info, second.info};
  GDExtensionClassMethodArgumentMetadata metadata[] = {GDEXTENSION_METHOD_ARGUMENT_METADATA_NONE,
                                                       GDEXTENSION_METHOD_ARGUMENT_METADATA_NONE};
  GDExtensionClassMethodInfo info = {};
  info.name = name.get();
  info.method_userdata = const_cast<Method*>(&method);
  info.call_func = call_variants;
  info.ptrcall_func = call_typed;
  info.method_flags = GDEXTENSION_METHOD_FLAGS_DEFAULT;
  info.has_return_value = method.result != Kind::nothing;
  info.return_value_info = &result.info;
  info.argument_count = static_cast<std::uint32_t>(method.arguments.size());
  info.arguments_info = arguments;
  info.arguments_metadata = metadata;
  api.register_method(library, owner.get(), &info);
}

void load_arrays(GDExtensionInterfaceGetProcAddress get) {
  Name resize("resize"), size("size");
  for (ArrayType& array : arrays) {
    array.construct = api.constructor(array.type, 0);
    array.destroy = api.destructor(array.type);
    // The hashes of the signatures int resize(int) and int size(), the same in all versions of Godot 4.
    array.resize = api.builtin_method(array.type, resize.get(), 848867239);
    array.size = api.builtin_method(array.type, size.get(), 3173160232);
    array.element = reinterpret_cast<void* (*)(void*, GDExtensionInt)>(get(array.element_function));
  }
}

void initialize(void*, GDExtensionInitializationLevel level) {
  if (level != GDEXTENSION_INITIALIZATION_SCENE) return;
  Name name("FaceBakerFace"), parent("RefCounted");
  GDExtensionClassCreationInfo2 info = {};
  info.is_exposed = true;
  info.create_instance_func = create;
  info.free_instance_func = free_instance;
  api.register_class(library, name.get(), parent.get(), &info);
  for (const Method& method : methods()) register_method(method);
}

void deinitialize(void*, GDExtensionInitializationLevel level) {
  if (level != GDEXTENSION_INITIALIZATION_SCENE) return;
  Name name("FaceBakerFace");
  api.unregister_class(library, name.get());
}

template <typename Function>
bool load(GDExtensionInterfaceGetProcAddress get, const char* name, Function& to) {
  to = reinterpret_cast<Function>(get(name));
  return to != nullptr;
}

bool load_api(GDExtensionInterfaceGetProcAddress get) {
  if (!load(get, "print_error", api.print_error)) return false;
  if (!load(get, "string_new_with_utf8_chars_and_len", api.string_new) ||
      !load(get, "string_to_utf8_chars", api.string_to_utf8) ||
      !load(get, "string_name_new_with_latin1_chars", api.name_new) ||
      !load(get, "get_variant_from_type_constructor", api.variant_from_type) ||
      !load(get, "get_variant_to_type_constructor", api.variant_to_type) ||
      !load(get, "variant_get_ptr_constructor", api.constructor) ||
      !load(get, "variant_get_ptr_destructor", api.destructor) ||
      !load(get, "variant_get_ptr_builtin_method", api.builtin_method) ||
      !load(get, "variant_destroy", api.variant_destroy) || !load(get, "variant_get_type", api.variant_type) ||
      !load(get, "classdb_construct_object", api.construct_object) ||
      !load(get, "object_set_instance", api.set_instance) ||
      !load(get, "classdb_register_extension_class2", api.register_class) ||
      !load(get, "classdb_register_extension_class_method", api.register_method) ||
      !load(get, "classdb_unregister_extension_class", api.unregister_class)) {
    report("this version of Godot lacks a function that FaceBaker needs", "FaceBaker");
    return false;
  }
  api.string_destroy = api.destructor(GDEXTENSION_VARIANT_TYPE_STRING);
  api.name_destroy = api.destructor(GDEXTENSION_VARIANT_TYPE_STRING_NAME);
  load_arrays(get);
  return true;
}

}  // namespace

// For facebaker_godot4_init below, which is outside of this namespace.
GDExtensionBool start(GDExtensionInterfaceGetProcAddress get, GDExtensionClassLibraryPtr own,
                      GDExtensionInitialization* initialization) {
  library = own;
  if (!load_api(get)) return false;
  initialization->minimum_initialization_level = GDEXTENSION_INITIALIZATION_SCENE;
  initialization->userdata = nullptr;
  initialization->initialize = initialize;
  initialization->deinitialize = deinitialize;
  return true;
}

}  // namespace facebaker::godot

#ifdef _WIN32
#define FB_MODULE_EXPORT __declspec(dllexport)
#else
#define FB_MODULE_EXPORT __attribute__((visibility("default")))
#endif

extern "C" FB_MODULE_EXPORT GDExtensionBool facebaker_godot4_init(GDExtensionInterfaceGetProcAddress get,
                                                                  GDExtensionClassLibraryPtr library,
                                                                  GDExtensionInitialization* initialization) {
  return facebaker::godot::start(get, library, initialization);
}
