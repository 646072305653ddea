/** @file
 * The class FaceBakerFace as both generations of Godot show it, without either's interface: the methods that scripts
 * call, with arguments and results as plain values. godot3_module.cpp and godot4_module.cpp only translate them.
 */
#ifndef FACEBAKER_GODOT_GODOT_FACE_H
#define FACEBAKER_GODOT_GODOT_FACE_H

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace facebaker::godot {

/** Types of arguments and results. Arrays are Godot's packed (pool) arrays. */
enum class Kind { nothing, boolean, integer, real, text, bytes, integers, floats, vectors2, vectors3 };

/** An argument or a result. */
struct Value {
  Kind kind = Kind::nothing;
  std::int64_t integer = 0;    ///< of boolean and integer
  double real = 0;             ///< of real
  std::string text;            ///< UTF-8
  const void* data = nullptr;  ///< of arrays: bytes, int32 or float; of a result, valid until the face's next call
  std::size_t count = 0;       ///< elements of the array: bytes, numbers, or vectors
};

class GodotFace;

/** A method that scripts can call. */
struct Method {
  const char* name;
  std::vector<Kind> arguments;
  Kind result;
  Value (*call)(GodotFace&, const Value*);
};

/** All methods. The same list in every call. */
const std::vector<Method>& methods();

/** What is behind one object of the class. Of one thread at a time. */
class GodotFace {
 public:
  GodotFace();
  ~GodotFace();
  GodotFace(const GodotFace&) = delete;
  GodotFace& operator=(const GodotFace&) = delete;

  /** Calls a method with as many arguments as it has. Throws nothing: what goes wrong is a sentence in `error`, which
   * is empty otherwise, and no result. */
  Value call(const Method& method, const Value* arguments, std::string& error) noexcept;

  struct State;
  std::unique_ptr<State> state;  ///< for methods
};

}  // namespace facebaker::godot

#endif
