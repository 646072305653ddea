// Options of baking (option_table) in the C interface: as fields of a description that have their names, and by name.
#pragma once

#include <facebaker/facebaker_bake.h>

#include <string_view>
#include <type_traits>

#include "abi_guard.h"
#include "bake/recipe/bake_options.h"

namespace fb::capi {

// Calls visit(name, field) for every field of a description that is an option.
template <class Desc, class Visit>
void visit_option_fields(Desc& desc, const Visit& visit) {
  if constexpr (requires { desc.poses; }) visit("poses", desc.poses);
  if constexpr (requires { desc.rig_budget; }) visit("rig_budget", desc.rig_budget);
  if constexpr (requires { desc.mix; }) visit("mix", desc.mix);
  if constexpr (requires { desc.seed; }) visit("seed", desc.seed);
  if constexpr (requires { desc.epochs; }) visit("epochs", desc.epochs);
  if constexpr (requires { desc.learning_curve; }) visit("learning_curve", desc.learning_curve);
  if constexpr (requires { desc.max_bytes; }) visit("max_bytes", desc.max_bytes);
  if constexpr (requires { desc.max_error; }) visit("max_error", desc.max_error);
  if constexpr (requires { desc.force; }) visit("force", desc.force);
  if constexpr (requires { desc.normal_weight; }) visit("normal_weight", desc.normal_weight);
  if constexpr (requires { desc.skip_failing; }) visit("skip_failing", desc.skip_failing);
  if constexpr (requires { desc.cache_bytes; }) visit("cache_bytes", desc.cache_bytes);
}

// Calls use(row, field, value) for every such field, with the member of the options that it stands for. Texts are
// fields that point to characters, and flags and numbers are numbers.
template <class Desc, class Options, class Use>
void match_option_fields(Desc& desc, Options& options, const Use& use) {
  visit_option_fields(desc, [&](const char* name, auto& field) {
    const bake::OptionRow& row = bake::option_row(name);
    std::visit(
        [&](auto member) {
          constexpr bool is_text = std::is_same_v<decltype(member), std::string bake::BakeOptions::*>;
          if constexpr (is_text == std::is_pointer_v<std::remove_reference_t<decltype(field)>>)
            use(row, field, options.*member);
        },
        row.member);
  });
}

// Gives these fields the defaults of options.
template <class Desc>
void fill_options(Desc& desc) {
  static const bake::BakeOptions defaults;  // which texts of fields belong to
  match_option_fields(desc, defaults, [](const bake::OptionRow&, auto& field, const auto& value) {
    if constexpr (requires { value.c_str(); })
      field = value.c_str();
    else
      field = static_cast<std::remove_reference_t<decltype(field)>>(value);
  });
}

// Takes over the options of a description of this type. Fails naming type and field on what an option cannot be.
template <class Desc>
void read_options(const Desc& desc, const char* type, bake::BakeOptions& options) {
  match_option_fields(desc, options, [&](const bake::OptionRow& row, const auto& field, auto& value) {
    using Value = std::remove_reference_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::string>) {
      require(field, format("%s: %s", type, row.name).c_str());
      value = field;
    } else {
      with_context(type, [&] { bake::check_option(row, static_cast<double>(field)); });
      if constexpr (std::is_same_v<Value, bool>)
        value = field != 0;
      else
        value = static_cast<Value>(field);
    }
  });
}

// Takes over options that are named: "NAME=VALUE" each.
inline void read_named_options(const char* const* named, std::uint32_t count, const char* type,
                               bake::BakeOptions& options) {
  with_context(type, [&] {
    for (std::uint32_t i = 0; i < count; ++i) {
      require(named, "options");
      require(named[i], "one of options");
      const std::string_view text = named[i];
      const std::size_t equals = text.find('=');
      if (equals == text.npos) fail(Status::invalid_argument, "options[%u] is \"%s\", not \"NAME=VALUE\"", i, named[i]);
      bake::set_option(options, bake::option_row(text.substr(0, equals)), text.substr(equals + 1));
    }
  });
}

}  // namespace fb::capi
