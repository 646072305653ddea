#pragma once

#include <ostream>
#include <span>
#include <streambuf>

#include "base/file.h"

namespace fb::tool {

// A stream into a file, for libraries that write to one. What fails, writing or taking memory, is thrown as it is.
class FileStream : private std::streambuf, public std::ostream {
 public:
  explicit FileStream(AtomicFile& file) : std::ostream(this), file_(file) { exceptions(badbit | failbit); }

 private:
  using Traits = std::char_traits<char>;

  std::streamsize xsputn(const char* text, std::streamsize size) override {
    file_.write(std::as_bytes(std::span(text, static_cast<std::size_t>(size))));
    return size;
  }
  Traits::int_type overflow(Traits::int_type c) override {
    const char one = Traits::to_char_type(c);
    if (!Traits::eq_int_type(c, Traits::eof())) xsputn(&one, 1);
    return Traits::not_eof(c);
  }

  AtomicFile& file_;
};

}  // namespace fb::tool
