#include "bake/signing/content_digest.h"

#include <algorithm>
#include <array>

namespace fb::bake {
namespace {

constexpr std::size_t most_at_once = 1 << 20;  // bytes; OpenSSL's sizes are of int

}  // namespace

std::string sha256_of_bytes(std::span<const std::byte> bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned size = 0;
  succeed(EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr), "SHA-256");
  std::string text;
  for (const unsigned char byte : std::span(digest).first(size)) text += format("%02x", byte);
  return text;
}

BioChain digest_content(CMS_ContentInfo* message, std::span<const std::byte> content) {
  BioChain nothing(made(BIO_new(BIO_s_null()), "digesting"));
  BIO* head = CMS_dataInit(message, nothing.get());
  if (!head) fail(Status::bad_data, "is damaged: its digest is unknown (%s)", openssl_reason().c_str());
  static_cast<void>(nothing.release());  // it is the end of the chain
  BioChain chain(head);
  while (!content.empty()) {
    const std::size_t size = std::min(most_at_once, content.size());
    if (BIO_write(chain.get(), content.data(), static_cast<int>(size)) != static_cast<int>(size))
      succeed(0, "digesting");
    content = content.subspan(size);
  }
  return chain;
}

}  // namespace fb::bake
