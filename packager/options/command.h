// What a command takes, declared once: the command line, help, man pages and completion come of it. CLI11, which does
// the work, is a large header: command.cpp and the readers of declarations include it, and no command does.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace fb::tool {

// An option or argument of a command. Copies are the same option, which belongs to its command.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option type_name(const std::string& name) const;  // of what it takes, in the help: "FILE"
  Option required() const;
  Option shows_default() const;               // what the variable holds now
  Option repeatable() const;                  // takes one value each time it is given
  Option separated_by(char character) const;  // takes a list in one word
  // What values may be; others are wrong use.
  Option one_of(const std::vector<std::string>& words) const;
  template <typename Number>
  Option between(Number least, Number most) const;
  Option not_negative() const;
  Option checked(std::function<std::string(const std::string&)> check) const;  // "" or what is wrong with the word
  Option not_with(const Option& other) const;
  Option only_with(const Option& other) const;

  bool given() const;  // on the command line that was parsed
  std::string name() const;

 private:
  CLI::Option* option_;
};

// A command of the tool, or the tool itself. Copies are the same command.
class Command {
 public:
  explicit Command(CLI::App& app) : app_(&app) {}
  CLI::App& app() const { return *app_; }

  Command add_command(const std::string& name, const std::string& what) const;
  // `name`: "--out", or "OUT" for an argument. `to`: where the value goes, which is the default; it must outlive the
  // command. Of texts, numbers, lists of them, and std::optional numbers.
  template <typename Value>
  Option add_option(const std::string& name, Value& to, const std::string& what) const;
  Option add_flag(const std::string& name, bool& to, const std::string& what) const;
  void footer(const std::string& text) const;
  void when_called(std::function<void()> run) const;

 private:
  CLI::App* app_;
};

}  // namespace fb::tool
