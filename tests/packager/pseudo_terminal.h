// What a program prints to a terminal.
#pragma once

#include <doctest/doctest.h>
#include <pty.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string>

// What a child of fork() prints that has a terminal with so many columns and calls work().
inline std::string on_terminal(int columns, const std::function<void()>& work) {
  winsize size = {};
  size.ws_col = static_cast<unsigned short>(columns);
  size.ws_row = 24;
  int screen = -1;
  const pid_t child = forkpty(&screen, nullptr, nullptr, &size);
  REQUIRE(child >= 0);
  if (child == 0) {
    unsetenv("NO_COLOR");
    unsetenv("FORCE_COLOR");
    setenv("TERM", "xterm", 1);
    work();
    _exit(0);
  }
  std::string text;
  std::array<char, 4096> block;
  for (ssize_t got; (got = read(screen, block.data(), block.size())) > 0;)
    text.append(block.data(), static_cast<std::size_t>(got));
  close(screen);
  waitpid(child, nullptr, 0);
  return text;
}

// Without the codes of a terminal: a carriage return begins a line.
inline std::string plain_text(const std::string& text) {
  std::string rest;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\033')
      i = std::min(text.find_first_of("mK", i), text.size());
    else if (text[i] == '\r')
      rest += i + 1 < text.size() && text[i + 1] == '\n' ? "" : "\n";
    else
      rest += text[i];
  }
  return rest;
}
