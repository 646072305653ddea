#include "bake/rig/json_field.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_depth.h"
#include "base/shown_path.h"

namespace fb::bake {

using nlohmann::json;
using nlohmann::ordered_json;

template <class Json>
Json parse_json(std::string_view text, const std::string& what, Status status) {
  try {
    check_json_depth(text);
    return Json::parse(text);
  } catch (const Error& error) {
    throw Error(status, what + ": " + error.what());
  } catch (const json::exception& error) {
    const std::string why = error.what();  // "[json.exception...] parse error at line 3, ..."
    throw Error(status, what + ": is no JSON: " + shown(why.substr(why.find("] ") + 2)));
  }
}
template json parse_json<json>(std::string_view, const std::string&, Status);
template ordered_json parse_json<ordered_json>(std::string_view, const std::string&, Status);

ordered_json object_in(std::string_view text) {
  try {
    ordered_json value = parse_json<ordered_json>(text, "");
    if (value.is_object()) return value;
  } catch (const Error&) {
  }
  return nullptr;
}

void JsonField::refuse(const std::string& why, Status status) const {
  throw Error(status, place_ + " " + why);
}

const json& JsonField::value() const {
  if (!value_) refuse("is missing");
  return *value_;
}

JsonField JsonField::operator[](const char* key) const {
  if (!value().is_object()) refuse("is no object");
  const auto found = value_->find(key);
  return {found == value_->end() ? nullptr : &*found, place_ + " " + key, status_};
}

std::size_t JsonField::size() const {
  if (!value().is_array()) refuse("is no list");
  return value_->size();
}

JsonField JsonField::item(std::size_t i) const {
  return {&(*value_)[i], format("%s[%zu]", place_.c_str(), i), status_};
}

std::vector<JsonField> JsonField::items() const {
  std::vector<JsonField> items;
  for (std::size_t i = 0; i < size(); ++i) items.push_back(item(i));
  return items;
}

std::vector<JsonField> JsonField::nonempty_items() const {
  std::vector<JsonField> found = items();
  if (found.empty()) refuse("is empty");
  return found;
}

bool JsonField::is_text() const {
  return value().is_string();
}

std::string JsonField::any_text() const {
  if (!is_text()) refuse("is no string");
  return value_->get<std::string>();
}

std::string JsonField::text() const {
  std::string given = any_text();
  if (given.find('\0') != std::string::npos) refuse("holds a zero byte");
  return given;
}

std::string JsonField::nonempty_text() const {
  std::string given = text();
  if (given.empty()) refuse("is empty");
  return given;
}

std::uint64_t JsonField::hash() const {
  std::uint64_t hash = 0;
  if (std::sscanf(text().c_str(), "%" SCNx64, &hash) != 1) refuse("is no hexadecimal number");
  return hash;
}

double JsonField::number() const {
  if (!value().is_number()) refuse("is no number");
  const double number = value_->get<double>();
  if (!std::isfinite(number)) refuse("is not finite", Status::not_finite);
  return number;
}

float JsonField::single() const {
  if (std::abs(number()) > 3.4e38) refuse("is too large for a float");
  return value_->get<float>();
}

std::vector<float> JsonField::singles() const {
  std::vector<float> values;
  for (std::size_t i = 0; i < size(); ++i) values.push_back(item(i).single());
  return values;
}

void JsonField::read_singles(std::span<float> to) const {
  if (!exists()) return;
  const std::vector<float> values = singles();
  if (values.size() != to.size()) refuse(format("has %zu numbers, not %zu", values.size(), to.size()));
  std::ranges::copy(values, to.begin());
}

std::uint32_t JsonField::count(std::uint32_t least) const {
  const bool counts = value().is_number_unsigned();
  if (!counts || value_->get<std::uint64_t>() < least || value_->get<std::uint64_t>() > UINT32_MAX)
    refuse(format("is no whole number from %u to %u", least, UINT32_MAX));
  return value_->get<std::uint32_t>();
}

std::vector<std::uint32_t> JsonField::counts() const {
  std::vector<std::uint32_t> values;
  for (std::size_t i = 0; i < size(); ++i) values.push_back(item(i).count());
  return values;
}

bool JsonField::flag_or(bool otherwise) const {
  if (!exists()) return otherwise;
  if (!value_->is_boolean()) refuse("is neither true nor false");
  return value_->get<bool>();
}

std::size_t JsonField::position_in(std::span<const std::string_view> words) const {
  const std::string given = text();
  std::string all;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == given) return i;
    all += (all.empty() ? "" : ", ") + std::string(words[i]);
  }
  refuse(format("is \"%s\"; there are %s", shown(given).c_str(), all.c_str()));
}

}  // namespace fb::bake
