// Answers of the web server, as libmicrohttpd's.
#pragma once

#include <microhttpd.h>

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace fb::tool {

struct AnswerDeleter {
  void operator()(MHD_Response* answer) const { MHD_destroy_response(answer); }
};
using Answer = std::unique_ptr<MHD_Response, AnswerDeleter>;
using HeaderFields = std::initializer_list<std::pair<const char*, std::string>>;

// All of them have the headers that keep the page to itself, besides `fields`. Throw bad_alloc.

// `bytes` outlive the server, and are not copied.
Answer answer_with_lasting(std::string_view bytes, HeaderFields fields);
// Frees the bytes and calls freed() once they are sent or the client is gone.
Answer answer_with(std::string bytes, std::function<void()> freed, HeaderFields fields);
// A line of text.
Answer answer_in_words(const std::string& words, HeaderFields fields = {});

}  // namespace fb::tool
