#pragma once

#ifndef _WIN32
#include <locale.h>
#endif
#ifdef __APPLE__
#include <xlocale.h>
#endif

namespace fb {

// While it lives, C functions print and read numbers of this thread with decimal points, whatever locale the host has
// set. On Windows the host's locale counts.
class DecimalPoints {
 public:
  DecimalPoints(const DecimalPoints&) = delete;
  DecimalPoints& operator=(const DecimalPoints&) = delete;
#ifdef _WIN32
  DecimalPoints() {}
#else
  DecimalPoints() {
    static const locale_t plain = ::newlocale(LC_ALL_MASK, "C", nullptr);
    if (plain) before_ = ::uselocale(plain);
  }
  ~DecimalPoints() {
    if (before_) ::uselocale(before_);
  }

 private:
  locale_t before_ = nullptr;
#endif
};

}  // namespace fb
