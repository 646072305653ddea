#include "server/http_answer.h"

#include <new>

namespace fb::tool {
namespace {

// A page and its WebAssembly from here alone, pictures of archives from memory; nothing of it in a page of elsewhere.
// The last two let the page's clock tick in microseconds.
constexpr std::initializer_list<std::pair<const char*, const char*>> page_fields = {
    {"Cache-Control", "no-store"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Content-Security-Policy",
     "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
     "img-src 'self' blob: data:; connect-src 'self' blob: data:; worker-src 'self' blob:; frame-ancestors 'none'"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cross-Origin-Embedder-Policy", "require-corp"}};

void add_field(const Answer& answer, const char* name, const char* value) {
  if (MHD_add_response_header(answer.get(), name, value) != MHD_YES) throw std::bad_alloc();
}

Answer with_fields(MHD_Response* made, HeaderFields fields) {
  if (!made) throw std::bad_alloc();
  Answer answer(made);
  for (const auto& [name, value] : page_fields) add_field(answer, name, value);
  for (const auto& [name, value] : fields) add_field(answer, name, value.c_str());
  return answer;
}

struct OwnedBytes {
  OwnedBytes(std::string given, std::function<void()> told) : bytes(std::move(given)), freed(std::move(told)) {}
  OwnedBytes(const OwnedBytes&) = delete;
  OwnedBytes& operator=(const OwnedBytes&) = delete;
  ~OwnedBytes() { freed(); }

  std::string bytes;
  std::function<void()> freed;
};

void free_owned(void* owned) {
  delete static_cast<OwnedBytes*>(owned);
}

}  // namespace

Answer answer_with_lasting(std::string_view bytes, HeaderFields fields) {
  return with_fields(
      MHD_create_response_from_buffer(bytes.size(), const_cast<char*>(bytes.data()), MHD_RESPMEM_PERSISTENT), fields);
}

Answer answer_with(std::string bytes, std::function<void()> freed, HeaderFields fields) {
  auto owned = std::make_unique<OwnedBytes>(std::move(bytes), std::move(freed));
  MHD_Response* made = MHD_create_response_from_buffer_with_free_callback_cls(owned->bytes.size(), owned->bytes.data(),
                                                                              free_owned, owned.get());
  if (made) owned.release();
  return with_fields(made, fields);
}

Answer answer_in_words(const std::string& words, HeaderFields fields) {
  std::string line = words + "\n";
  Answer answer = with_fields(MHD_create_response_from_buffer(line.size(), line.data(), MHD_RESPMEM_MUST_COPY), fields);
  add_field(answer, "Content-Type", "text/plain; charset=utf-8");
  return answer;
}

}  // namespace fb::tool
