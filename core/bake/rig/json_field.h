// JSON from anyone: parsed, and read with checks whose messages name the place and what is wrong there.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/status.h"

namespace fb::bake {

// The value that a text is. Fails, naming `what`, on what lies too deep (json_depth.h) or is no JSON in UTF-8:
// "what: is no JSON: parse error at line 3, column 7: ...". Json: nlohmann::json, or ordered_json, in which fields keep
// their order.
template <class Json>
Json parse_json(std::string_view text, const std::string& what, Status status = Status::bad_data);
// The object that a text from an archive or a cache is; null where parse_json fails or gives another value.
nlohmann::ordered_json object_in(std::string_view text);

// A value and its place, with which messages begin: "dataset.json: clips[2] fps". A field may be missing: readers fail
// then, but for those ending in _or or _or_none. Failures have the status of the root, but for not_finite.
class JsonField {
 public:
  // The root, which must outlive its fields. `place`: such as "dataset.json:".
  JsonField(const nlohmann::json& root, std::string place, Status status = Status::bad_data)
      : JsonField(&root, std::move(place), status) {}

  bool exists() const { return value_ != nullptr; }
  const nlohmann::json& value() const;

  JsonField operator[](const char* key) const;  // of an object
  std::vector<JsonField> items() const;         // of a list
  std::vector<JsonField> items_or_none() const { return exists() ? items() : std::vector<JsonField>(); }
  std::vector<JsonField> nonempty_items() const;

  bool is_text() const;
  std::string any_text() const;
  std::string text() const;  // without zero bytes
  std::string text_or(const char* otherwise) const { return exists() ? text() : otherwise; }
  std::string nonempty_text() const;
  std::uint64_t hash() const;  // of hexadecimal digits

  double number() const;
  float single() const;  // no larger than a float can be
  float single_or(float otherwise) const { return exists() ? single() : otherwise; }
  std::vector<float> singles() const;
  // Where the field exists, it must be a list of as many numbers as there is room for.
  void read_singles(std::span<float> to) const;

  std::uint32_t count(std::uint32_t least = 0) const;
  std::uint32_t count_or(std::uint32_t otherwise) const { return exists() ? count() : otherwise; }
  std::vector<std::uint32_t> counts() const;
  bool flag_or(bool otherwise) const;

  // The enumerator with the number of the one of these words that it is.
  template <class Kind>
  Kind word_or(Kind otherwise, std::span<const std::string_view> words) const {
    return exists() ? static_cast<Kind>(position_in(words)) : otherwise;
  }

  // What read(text) gives; its failures get the place, and keep their status.
  template <class Kind, class Read>
  Kind read_or(Kind otherwise, Read read) const {
    if (!exists()) return otherwise;
    const std::string given = text();
    try {
      return read(given);
    } catch (const Error& error) {
      refuse(error.what(), error.status());
    }
  }

  // Fails with the place and what is wrong there: "is no list".
  [[noreturn]] void refuse(const std::string& why) const { refuse(why, status_); }
  [[noreturn]] void refuse(const std::string& why, Status status) const;

 private:
  JsonField(const nlohmann::json* value, std::string place, Status status)
      : value_(value), place_(std::move(place)), status_(status) {}
  std::size_t size() const;  // of a list
  JsonField item(std::size_t i) const;
  std::size_t position_in(std::span<const std::string_view> words) const;

  const nlohmann::json* value_;  // null: missing
  std::string place_;
  Status status_;
};

}  // namespace fb::bake
