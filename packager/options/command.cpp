#include "options/command.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/parse_number.h"

namespace fb::tool {

Option Option::type_name(const std::string& name) const {
  option_->type_name(name);
  return *this;
}

Option Option::required() const {
  option_->required();
  return *this;
}

Option Option::shows_default() const {
  option_->capture_default_str();
  return *this;
}

Option Option::repeatable() const {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::separated_by(char character) const {
  option_->delimiter(character);
  return *this;
}

Option Option::one_of(const std::vector<std::string>& words) const {
  option_->check(CLI::IsMember(words));
  return *this;
}

template <typename Number>
Option Option::between(Number least, Number most) const {
  option_->check(CLI::Range(least, most));
  return *this;
}

template Option Option::between(int, int) const;
template Option Option::between(std::uint64_t, std::uint64_t) const;
template Option Option::between(float, float) const;
template Option Option::between(double, double) const;

Option Option::not_negative() const {
  return checked([](const std::string& word) {
    const std::optional<double> number = parse_number<double>(word);
    return !number || std::isnan(*number) ? word + " is no number"
           : *number >= 0                 ? std::string()
                                          : word + " is negative";
  });
}

Option Option::checked(std::function<std::string(const std::string&)> check) const {
  option_->check(std::move(check));
  return *this;
}

Option Option::not_with(const Option& other) const {
  option_->excludes(other.option_);
  return *this;
}

Option Option::only_with(const Option& other) const {
  option_->needs(other.option_);
  return *this;
}

bool Option::given() const {
  return option_->count() > 0;
}

std::string Option::name() const {
  return option_->get_name();
}

Command Command::add_command(const std::string& name, const std::string& what) const {
  return Command(*app_->add_subcommand(name, what));
}

template <typename Value>
Option Command::add_option(const std::string& name, Value& to, const std::string& what) const {
  return Option(app_->add_option(name, to, what));
}

template Option Command::add_option(const std::string&, std::string&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<double>&, const std::string&) const;
template Option Command::add_option(const std::string&, int&, const std::string&) const;
template Option Command::add_option(const std::string&, std::uint32_t&, const std::string&) const;
template Option Command::add_option(const std::string&, std::uint64_t&, const std::string&) const;
template Option Command::add_option(const std::string&, float&, const std::string&) const;
template Option Command::add_option(const std::string&, double&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<std::uint64_t>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<double>&, const std::string&) const;

Option Command::add_flag(const std::string& name, bool& to, const std::string& what) const {
  return Option(app_->add_flag(name, to, what));
}

void Command::footer(const std::string& text) const {
  app_->footer(text);
}

void Command::when_called(std::function<void()> run) const {
  app_->callback(std::move(run));
}

}  // namespace fb::tool
