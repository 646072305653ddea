// Visitors of member lists (member_list.h) that write and read JSON objects. For sources: parsing this takes seconds.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/status.h"

namespace fb {

template <class T>
constexpr bool is_plain_field = std::is_arithmetic_v<T> || std::is_same_v<T, std::string>;

struct FieldStyle {
  bool details = false;                 // with figures of every frame and vertex
  double (*rounded)(double) = nullptr;  // applied to all double numbers; null: they are written as they are
};

// Writes members as keys of an object.
template <class Json>
class FieldWriter {
 public:
  explicit FieldWriter(Json& to, FieldStyle style = {}) : to_(to), style_(style) {}

  bool details() const { return style_.details; }

  template <class T>
  void operator()(const char* name, const T& member) {
    to_[name] = written(member);
  }
  // What follows from other members: readers skip it.
  template <class T>
  void derived(const char* name, const T& value) {
    to_[name] = written(value);
  }
  // An object of what visit(visitor) names; object_if: null unless `present`.
  template <class Visit>
  void object(const char* name, const Visit& visit) {
    to_[name] = object_by(visit);
  }
  template <class Visit>
  void object_if(const char* name, bool present, const Visit& visit) {
    to_[name] = present ? object_by(visit) : Json();
  }
  // The first `count` elements, each as an object of what visit(visitor, element) names.
  template <class T, class Visit>
  void list(const char* name, const std::vector<T>& all, std::size_t count, const Visit& visit) {
    Json& elements = to_[name] = Json::array();
    for (std::size_t i = 0; i < count; ++i)
      elements.push_back(object_by([&](FieldWriter& inner) { visit(inner, all[i]); }));
  }
  // One member of all elements, as an array; an empty one unless `present`.
  template <class T, class Member>
  void column(const char* name, const std::vector<T>& all, Member T::*member, bool present) {
    Json& values = to_[name] = Json::array();
    for (std::size_t i = 0; present && i < all.size(); ++i) values.push_back(all[i].*member);
  }

 private:
  template <class Visit>
  Json object_by(const Visit& visit) const {
    Json object = Json::object();
    FieldWriter inner(object, style_);
    visit(inner);
    return object;
  }
  template <class T>
  Json written(const std::vector<T>& list) const {
    Json elements = Json::array();
    for (const T& element : list) elements.push_back(written(element));
    return elements;
  }
  template <class T>
  Json written(const std::optional<T>& value) const {
    return value ? written(*value) : Json();
  }
  template <class T>
  Json written(const T& value) const {
    if constexpr (std::is_same_v<T, double>)
      return style_.rounded ? style_.rounded(value) : value;
    else if constexpr (is_plain_field<T>)
      return value;
    else
      return object_by([&](FieldWriter& inner) { visit_fields(inner, value); });
  }

  Json& to_;
  FieldStyle style_;
};

// Reads what FieldWriter wrote, with details. Fails with bad_data, naming the field, where one is missing or of another
// type. A floating-point number that is null, as JSON has it if it was not finite, is NaN.
template <class Json>
class FieldReader {
 public:
  explicit FieldReader(const Json& from, std::string path = {}) : from_(from), path_(std::move(path)) {
    if (!from.is_object()) fail(Status::bad_data, "\"%s\" is no object", path_.c_str());
  }

  static constexpr bool details() { return true; }

  template <class T>
  void operator()(const char* name, T& member) const {
    read(at(name), path_of(name), member);
  }
  template <class T>
  void derived(const char* name, const T&) const {
    at(name);
  }
  template <class Visit>
  void object(const char* name, const Visit& visit) const {
    read_object(at(name), path_of(name), visit);
  }
  template <class Visit>
  void object_if(const char* name, bool, const Visit& visit) const {
    if (const Json& json = at(name); !json.is_null()) read_object(json, path_of(name), visit);
  }
  template <class T, class Visit>
  void list(const char* name, std::vector<T>& all, std::size_t, const Visit& visit) const {
    const Json& elements = array_at(name);
    all.resize(std::max(all.size(), elements.size()));
    for (std::size_t i = 0; i < elements.size(); ++i)
      read_object(elements[i], element(path_of(name), i), [&](FieldReader& inner) { visit(inner, all[i]); });
  }
  template <class T, class Member>
  void column(const char* name, std::vector<T>& all, Member T::*member, bool) const {
    const Json& values = array_at(name);
    const std::string path = path_of(name);
    all.resize(std::max(all.size(), values.size()));
    for (std::size_t i = 0; i < values.size(); ++i) read(values[i], path, all[i].*member);
  }

 private:
  std::string path_of(const char* name) const { return path_.empty() ? name : path_ + "." + name; }
  static std::string element(const std::string& path, std::size_t index) {
    return path + "[" + std::to_string(index) + "]";
  }
  const Json& at(const char* name) const {
    const auto found = from_.find(name);
    if (found == from_.end()) fail(Status::bad_data, "\"%s\" is missing", path_of(name).c_str());
    return *found;
  }
  const Json& array_at(const char* name) const {
    const Json& json = at(name);
    if (!json.is_array()) fail(Status::bad_data, "\"%s\" is no array", path_of(name).c_str());
    return json;
  }

  template <class Visit>
  static void read_object(const Json& json, const std::string& path, const Visit& visit) {
    FieldReader inner(json, path);
    visit(inner);
  }
  template <class T>
  static void read(const Json& json, const std::string& path, std::vector<T>& list) {
    if (!json.is_array()) fail(Status::bad_data, "\"%s\" is no array", path.c_str());
    list.assign(json.size(), {});
    for (std::size_t i = 0; i < list.size(); ++i) {
      if constexpr (is_plain_field<T>)
        read(json[i], path, list[i]);
      else
        read(json[i], element(path, i), list[i]);
    }
  }
  template <class T>
  static void read(const Json& json, const std::string& path, std::optional<T>& value) {
    value.reset();
    if (!json.is_null()) read(json, path, value.emplace());
  }
  template <class T>
  static void read(const Json& json, const std::string& path, T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      if (!json.is_boolean()) fail(Status::bad_data, "\"%s\" is neither true nor false", path.c_str());
      value = json.template get<bool>();
    } else if constexpr (std::is_floating_point_v<T>) {
      if (!json.is_number() && !json.is_null()) fail(Status::bad_data, "\"%s\" is no number", path.c_str());
      value = json.is_null() ? static_cast<T>(NAN) : json.template get<T>();
    } else if constexpr (std::is_unsigned_v<T>) {
      if (!json.is_number_unsigned() || json.template get<std::uint64_t>() > std::numeric_limits<T>::max())
        fail(Status::bad_data, "\"%s\" is no whole number of its range", path.c_str());
      value = json.template get<T>();
    } else if constexpr (is_plain_field<T>) {
      if (!json.is_string()) fail(Status::bad_data, "\"%s\" is no text", path.c_str());
      value = json.template get<T>();
    } else {
      read_object(json, path, [&](FieldReader& inner) { visit_fields(inner, value); });
    }
  }

  const Json& from_;
  std::string path_;
};

// The object of a struct with a member list.
template <class Json, class T>
Json fields_of(const T& figures, FieldStyle style = {}) {
  Json json = Json::object();
  FieldWriter<Json> writer(json, style);
  visit_fields(writer, figures);
  return json;
}

}  // namespace fb
