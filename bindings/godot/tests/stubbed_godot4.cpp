/* The module for Godot 4 over stubs of the interface that the engine hands to it: strings, packed arrays and variants
 * in the sizes of Godot's, counted, so that a leak is an error. That Godot takes the module is not tested here.
 *
 *     stubbed_godot4 MODULE.so FACE.fbk FACE.poses BROKEN.fbk
 */
#include <dlfcn.h>
#include <gdextension_interface.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace {

int checks = 0, failures = 0, live = 0;
std::string last_error;
std::string class_registered, parent_registered;
GDExtensionClassCreationInfo2 class_info;
GDExtensionClassInstancePtr instance = nullptr;

struct StubMethod {
  void* userdata;
  GDExtensionClassMethodCall call;
  GDExtensionClassMethodPtrCall ptrcall;
  std::vector<GDExtensionVariantType> arguments;
  GDExtensionVariantType result;
};
std::map<std::string, StubMethod> registered;

void that(bool holds, const std::string& what) {
  ++checks;
  if (holds) return;
  ++failures;
  std::fprintf(stderr, "not so: %s\n", what.c_str());
}

/* ---- Values of the engine: a pointer in the first bytes of each */

template <typename T>
T*& held(void* at) {
  return *static_cast<T**>(at);
}

std::string& text_of(const void* string) {
  return *held<std::string>(const_cast<void*>(string));
}

void new_text(void* at, const std::string& text) {
  ++live;
  held<std::string>(at) = new std::string(text);
}

void destroy_text(void* at) {
  --live;
  delete held<std::string>(at);
}

using Bytes = std::vector<unsigned char>;

std::size_t element_bytes(GDExtensionVariantType type) {
  switch (type) {
    case GDEXTENSION_VARIANT_TYPE_PACKED_BYTE_ARRAY:
      return 1;
    case GDEXTENSION_VARIANT_TYPE_PACKED_INT32_ARRAY:
    case GDEXTENSION_VARIANT_TYPE_PACKED_FLOAT32_ARRAY:
      return 4;
    case GDEXTENSION_VARIANT_TYPE_PACKED_VECTOR2_ARRAY:
      return 8;
    case GDEXTENSION_VARIANT_TYPE_PACKED_VECTOR3_ARRAY:
      return 12;
    default:
      return 0;
  }
}

void new_array(void* at, const GDExtensionConstTypePtr*) {
  ++live;
  held<Bytes>(at) = new Bytes;
}

void destroy_array(void* at) {
  --live;
  delete held<Bytes>(at);
}

template <int Type>
void resize(void* self, const GDExtensionConstTypePtr* arguments, void* result, int) {
  held<Bytes>(self)->resize(static_cast<std::size_t>(*static_cast<const std::int64_t*>(arguments[0])) *
                            element_bytes(static_cast<GDExtensionVariantType>(Type)));
  *static_cast<std::int64_t*>(result) = 0;
}

template <int Type>
void size(void* self, const GDExtensionConstTypePtr*, void* result, int) {
  *static_cast<std::int64_t*>(result) =
      static_cast<std::int64_t>(held<Bytes>(self)->size() / element_bytes(static_cast<GDExtensionVariantType>(Type)));
}

void* element(void* self, GDExtensionInt) {
  return held<Bytes>(self)->data();
}

struct Variant {
  GDExtensionVariantType type;
  union {
    std::int64_t integer;
    double real;
    void* pointer;
  };
};
static_assert(sizeof(Variant) <= 24);

Variant& variant_of(const void* at) {
  return *static_cast<Variant*>(const_cast<void*>(at));
}

template <int Type>
void to_variant(void* to, void* typed) {
  Variant& variant = variant_of(to);
  variant.type = static_cast<GDExtensionVariantType>(Type);
  switch (variant.type) {
    case GDEXTENSION_VARIANT_TYPE_BOOL:
      variant.integer = *static_cast<GDExtensionBool*>(typed);
      break;
    case GDEXTENSION_VARIANT_TYPE_INT:
      variant.integer = *static_cast<std::int64_t*>(typed);
      break;
    case GDEXTENSION_VARIANT_TYPE_FLOAT:
      variant.real = *static_cast<double*>(typed);
      break;
    case GDEXTENSION_VARIANT_TYPE_STRING:
      new_text(&variant.pointer, text_of(typed));
      break;
    default:
      new_array(&variant.pointer, nullptr);
      *held<Bytes>(&variant.pointer) = *held<Bytes>(typed);
  }
}

template <int Type>
void from_variant(void* typed, void* from) {
  Variant& variant = variant_of(from);
  switch (static_cast<GDExtensionVariantType>(Type)) {
    case GDEXTENSION_VARIANT_TYPE_BOOL:
      *static_cast<GDExtensionBool*>(typed) = variant.integer != 0;
      break;
    case GDEXTENSION_VARIANT_TYPE_INT:
      *static_cast<std::int64_t*>(typed) = variant.integer;
      break;
    case GDEXTENSION_VARIANT_TYPE_FLOAT:
      *static_cast<double*>(typed) =
          variant.type == GDEXTENSION_VARIANT_TYPE_INT ? double(variant.integer) : variant.real;
      break;
    case GDEXTENSION_VARIANT_TYPE_STRING:
      new_text(typed, text_of(&variant.pointer));
      break;
    default:
      new_array(typed, nullptr);
      *held<Bytes>(typed) = *held<Bytes>(&variant.pointer);
  }
}

void destroy_variant(void* at) {
  Variant& variant = variant_of(at);
  if (variant.type == GDEXTENSION_VARIANT_TYPE_STRING) destroy_text(&variant.pointer);
  if (element_bytes(variant.type) > 0) destroy_array(&variant.pointer);
  variant.type = GDEXTENSION_VARIANT_TYPE_NIL;
}

/* ---- Functions of the interface */

#define FB_OF_TYPE(function)                                          \
  switch (type) {                                                     \
    case GDEXTENSION_VARIANT_TYPE_BOOL:                               \
      return function<GDEXTENSION_VARIANT_TYPE_BOOL>;                 \
    case GDEXTENSION_VARIANT_TYPE_INT:                                \
      return function<GDEXTENSION_VARIANT_TYPE_INT>;                  \
    case GDEXTENSION_VARIANT_TYPE_FLOAT:                              \
      return function<GDEXTENSION_VARIANT_TYPE_FLOAT>;                \
    case GDEXTENSION_VARIANT_TYPE_STRING:                             \
      return function<GDEXTENSION_VARIANT_TYPE_STRING>;               \
    case GDEXTENSION_VARIANT_TYPE_PACKED_BYTE_ARRAY:                  \
      return function<GDEXTENSION_VARIANT_TYPE_PACKED_BYTE_ARRAY>;    \
    case GDEXTENSION_VARIANT_TYPE_PACKED_INT32_ARRAY:                 \
      return function<GDEXTENSION_VARIANT_TYPE_PACKED_INT32_ARRAY>;   \
    case GDEXTENSION_VARIANT_TYPE_PACKED_FLOAT32_ARRAY:               \
      return function<GDEXTENSION_VARIANT_TYPE_PACKED_FLOAT32_ARRAY>; \
    case GDEXTENSION_VARIANT_TYPE_PACKED_VECTOR2_ARRAY:               \
      return function<GDEXTENSION_VARIANT_TYPE_PACKED_VECTOR2_ARRAY>; \
    case GDEXTENSION_VARIANT_TYPE_PACKED_VECTOR3_ARRAY:               \
      return function<GDEXTENSION_VARIANT_TYPE_PACKED_VECTOR3_ARRAY>; \
    default:                                                          \
      return nullptr;                                                 \
  }

void print_error(const char* sentence, const char*, const char*, std::int32_t, GDExtensionBool) {
  last_error = sentence;
}
void string_new(void* to, const char* text, GDExtensionInt length) {
  new_text(to, std::string(text, static_cast<std::size_t>(length)));
}
GDExtensionInt string_to_utf8(const void* self, char* to, GDExtensionInt most) {
  const std::string& text = text_of(self);
  if (to) std::memcpy(to, text.data(), std::min(text.size(), static_cast<std::size_t>(most)));
  return static_cast<GDExtensionInt>(text.size());
}
void name_new(void* to, const char* text, GDExtensionBool) {
  new_text(to, text);
}
GDExtensionVariantFromTypeConstructorFunc variant_from_type(GDExtensionVariantType type){
    FB_OF_TYPE(to_variant)} GDExtensionTypeFromVariantConstructorFunc
    variant_to_type(GDExtensionVariantType type){FB_OF_TYPE(from_variant)} GDExtensionPtrConstructor
    constructor(GDExtensionVariantType, std::int32_t) {
  return new_array;
}
GDExtensionPtrDestructor destructor(GDExtensionVariantType type) {
  return element_bytes(type) > 0 ? destroy_array : destroy_text;
}
GDExtensionPtrBuiltInMethod builtin_method(GDExtensionVariantType type, const void* name, GDExtensionInt) {
  if (text_of(name) == "resize") {
    FB_OF_TYPE(resize)
  }
  FB_OF_TYPE(size)
}
GDExtensionVariantType variant_type(const void* variant) {
  return variant_of(variant).type;
}
void* construct_object(const void* name) {
  that(text_of(name) == "RefCounted", "the object is of the parent class");
  static int object;
  return &object;
}
void set_instance(void*, const void* name, void* made) {
  that(text_of(name) == "FaceBakerFace", "the instance is of the class");
  instance = made;
}
void register_class(void*, const void* name, const void* parent, const GDExtensionClassCreationInfo2* info) {
  class_registered = text_of(name);
  parent_registered = text_of(parent);
  class_info = *info;
}
void register_method(void*, const void*, const GDExtensionClassMethodInfo* info) {
  StubMethod method = {info->method_userdata, info->call_func, info->ptrcall_func, {}, GDEXTENSION_VARIANT_TYPE_NIL};
  for (std::uint32_t i = 0; i < info->argument_count; ++i) method.arguments.push_back(info->arguments_info[i].type);
  if (info->has_return_value) method.result = info->return_value_info->type;
  registered[text_of(info->name)] = method;
}
void unregister_class(void*, const void* name) {
  that(text_of(name) == class_registered, "the class is taken back");
  class_registered.clear();
}

GDExtensionInterfaceFunctionPtr get_function(const char* name) {
  const auto as = [](auto function) { return reinterpret_cast<GDExtensionInterfaceFunctionPtr>(function); };
  const std::map<std::string, GDExtensionInterfaceFunctionPtr> functions = {
      {"print_error", as(print_error)},
      {"string_new_with_utf8_chars_and_len", as(string_new)},
      {"string_to_utf8_chars", as(string_to_utf8)},
      {"string_name_new_with_latin1_chars", as(name_new)},
      {"get_variant_from_type_constructor", as(variant_from_type)},
      {"get_variant_to_type_constructor", as(variant_to_type)},
      {"variant_get_ptr_constructor", as(constructor)},
      {"variant_get_ptr_destructor", as(destructor)},
      {"variant_get_ptr_builtin_method", as(builtin_method)},
      {"variant_destroy", as(destroy_variant)},
      {"variant_get_type", as(variant_type)},
      {"classdb_construct_object", as(construct_object)},
      {"object_set_instance", as(set_instance)},
      {"classdb_register_extension_class2", as(register_class)},
      {"classdb_register_extension_class_method", as(register_method)},
      {"classdb_unregister_extension_class", as(unregister_class)},
      {"packed_byte_array_operator_index", as(element)},
      {"packed_int32_array_operator_index", as(element)},
      {"packed_float32_array_operator_index", as(element)},
      {"packed_vector2_array_operator_index", as(element)},
      {"packed_vector3_array_operator_index", as(element)},
  };
  const auto found = functions.find(name);
  return found == functions.end() ? nullptr : found->second;
}

GDExtensionInterfaceFunctionPtr get_less(const char* name) {
  return std::string(name) == "classdb_register_extension_class2" ? nullptr : get_function(name);
}

/* ---- Calls as scripts make them */

struct Box {
  alignas(8) unsigned char bytes[24] = {};
  Box() = default;
  Box(const Box&) = delete;
  Box& operator=(const Box&) = delete;
  ~Box() { destroy_variant(bytes); }
  Variant& variant() { return variant_of(bytes); }
  const Bytes& array() { return *held<Bytes>(&variant().pointer); }
  const std::string& text() { return text_of(&variant().pointer); }
};

void put_array(Box& box, GDExtensionVariantType type, const void* data, std::size_t size) {
  box.variant().type = type;
  new_array(&box.variant().pointer, nullptr);
  const auto* bytes = static_cast<const unsigned char*>(data);
  held<Bytes>(&box.variant().pointer)->assign(bytes, bytes + size);
}

void put(Box& box, std::int64_t integer) {
  box.variant().type = GDEXTENSION_VARIANT_TYPE_INT;
  box.variant().integer = integer;
}

GDExtensionCallErrorType call(const std::string& name, std::initializer_list<Box*> arguments, Box& result) {
  std::vector<GDExtensionConstVariantPtr> pointers;
  for (Box* argument : arguments) pointers.push_back(argument->bytes);
  const StubMethod& method = registered.at(name);
  GDExtensionCallError error = {};
  last_error.clear();
  method.call(method.userdata, instance, pointers.data(), static_cast<GDExtensionInt>(pointers.size()), result.bytes,
              &error);
  return error.error;
}

Bytes read_file(const char* path) {
  std::ifstream file(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), {});
}

std::string load(const char* path) {
  const Bytes archive = read_file(path);
  Box argument, result;
  put_array(argument, GDEXTENSION_VARIANT_TYPE_PACKED_BYTE_ARRAY, archive.data(), archive.size());
  that(call("load_bytes", {&argument}, result) == GDEXTENSION_CALL_OK, "load_bytes is called");
  return result.text();
}

void compare_poses(const char* path) {
  constexpr std::size_t frame_bytes = 12 * sizeof(float);
  const Bytes file = read_file(path);
  Box metres, none;
  metres.variant().type = GDEXTENSION_VARIANT_TYPE_BOOL;
  that(call("set_metres", {&metres}, none) == GDEXTENSION_CALL_OK, "lengths are the archive's");
  std::array<std::uint32_t, 7> header;
  std::memcpy(header.data(), file.data(), sizeof header);
  const std::size_t controls = 4 * header[1], positions = 12 * header[2];
  const std::size_t joints = 4 * header[6], rest = positions * (1 + header[5]) + 4 * (header[3] + header[4]) + joints;
  const unsigned char* at = file.data() + sizeof header;
  that(joints > 0, "the face has driven joints");
  for (std::uint32_t p = 0; p < header[0]; ++p, at += controls + positions + rest) {
    Box values, nothing, posed, found;
    put_array(values, GDEXTENSION_VARIANT_TYPE_PACKED_FLOAT32_ARRAY, at, controls);
    that(call("set_controls", {&values}, nothing) == GDEXTENSION_CALL_OK && last_error.empty(), "controls are set");
    call("pose", {}, posed);
    that(posed.variant().integer >= 0, "it poses");
    call("positions", {}, found);
    that(found.array() == Bytes(at + controls, at + controls + positions), "positions are those of the C interface");
    // The same by the typed call, into an array that is there already.
    const StubMethod& method = registered.at("positions");
    alignas(8) unsigned char typed[16];
    new_array(typed, nullptr);
    method.ptrcall(method.userdata, instance, nullptr, typed);
    that(*held<Bytes>(typed) == found.array(), "typed calls give the same");
    destroy_array(typed);
    const unsigned char* frames = at + controls + positions + rest - joints;
    for (std::size_t j = 0; j < joints / frame_bytes; ++j) {
      Box index, frame;
      put(index, static_cast<std::int64_t>(j));
      call("driven_joint_frame", {&index}, frame);
      that(frame.array() == Bytes(frames + j * frame_bytes, frames + (j + 1) * frame_bytes),
           "frames of driven joints are those of the C interface");
    }
  }
}

void check_calls() {
  Box index, number, text, result;
  put(index, 0);
  put(number, 1);  // an integer where a float is wanted
  that(call("set_control", {&index, &number}, result) == GDEXTENSION_CALL_OK && last_error.empty(),
       "integers are numbers");
  Box value;
  call("get_control", {&index}, value);
  that(value.variant().real == 1, "the control is set");
  that(call("set_control", {&index}, result) == GDEXTENSION_CALL_ERROR_TOO_FEW_ARGUMENTS, "too few arguments");
  that(call("pose", {&index}, result) == GDEXTENSION_CALL_ERROR_TOO_MANY_ARGUMENTS, "too many arguments");
  that(call("find_control", {&index}, result) == GDEXTENSION_CALL_ERROR_INVALID_ARGUMENT, "a number is no name");
  Box name, found;
  call("control_name", {&index}, name);
  that(!name.text().empty(), "the control has a name");
  that(call("find_control", {&name}, found) == GDEXTENSION_CALL_OK && found.variant().integer == 0,
       "it is found by it");
  Box far, none;
  put(far, 9999);
  call("control_name", {&far}, none);
  that(last_error.find("9999") != std::string::npos, "an index out of range is an error that names it: " + last_error);
  // Typed.
  const StubMethod& set = registered.at("set_control");
  const std::int64_t typed_index = 0;
  const double typed_value = 0.25;
  const GDExtensionConstTypePtr arguments[] = {&typed_index, &typed_value};
  set.ptrcall(set.userdata, instance, arguments, nullptr);
  Box again;
  call("get_control", {&index}, again);
  that(again.variant().real == 0.25, "the control is set by a typed call");
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 5) return std::fputs("usage: stubbed_godot4 MODULE.so FACE.fbk FACE.poses BROKEN.fbk\n", stderr), 2;
  void* module = dlopen(arguments[1], RTLD_NOW);
  if (!module) return std::fprintf(stderr, "%s\n", dlerror()), 1;
  const auto start = reinterpret_cast<GDExtensionInitializationFunction>(dlsym(module, "facebaker_godot4_init"));
  if (!start) return std::fputs("there is no entry point\n", stderr), 1;
  GDExtensionInitialization initialization = {};
  that(!start(get_less, nullptr, &initialization) && !last_error.empty(), "an engine that lacks a function is refused");
  if (!start(get_function, nullptr, &initialization)) return std::fputs("it does not start\n", stderr), 1;
  initialization.initialize(initialization.userdata, GDEXTENSION_INITIALIZATION_CORE);
  that(class_registered.empty(), "nothing is registered at the core's level");
  initialization.initialize(initialization.userdata, GDEXTENSION_INITIALIZATION_SCENE);
  that(class_registered == "FaceBakerFace" && parent_registered == "RefCounted", "the class is registered");
  that(registered.size() > 30, "with its methods");
  that(class_info.create_instance_func(class_info.class_userdata) != nullptr && instance, "an object is made");
  Box result;
  call("positions", {}, result);
  that(!last_error.empty(), "without a face there are no positions");
  that(!load(arguments[4]).empty(), "a broken archive is refused with a sentence");
  that(load(arguments[2]).empty(), "an archive is loaded");
  compare_poses(arguments[3]);
  check_calls();
  class_info.free_instance_func(class_info.class_userdata, instance);
  initialization.deinitialize(initialization.userdata, GDEXTENSION_INITIALIZATION_SCENE);
  that(class_registered.empty(), "the class is gone");
  destroy_variant(result.bytes);
  that(live == 0, std::to_string(live) + " strings and arrays are left");
  std::printf("%d checks over stubs of Godot 4, %d failed\n", checks, failures);
  return failures == 0 ? 0 : 1;
}
