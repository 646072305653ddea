#include "bake/bag/message_digest.h"

#include <openssl/err.h>
#include <openssl/evp.h>

#include <array>
#include <new>

#include "base/status.h"

namespace fb::bake {
namespace {

struct Algorithm {
  const char *name, *openssl_name;
  std::size_t digits;
};

constexpr std::array<Algorithm, 6> algorithms = {{{"md5", "MD5", 32},
                                                  {"sha1", "SHA1", 40},
                                                  {"sha224", "SHA224", 56},
                                                  {"sha256", "SHA256", 64},
                                                  {"sha384", "SHA384", 96},
                                                  {"sha512", "SHA512", 128}}};

const Algorithm* find(std::string_view name) {
  for (const Algorithm& one : algorithms)
    if (name == one.name) return &one;
  return nullptr;
}

// Of what OpenSSL failed to do; forgets its errors.
[[noreturn]] void fail_by_openssl(std::string_view algorithm) {
  bool memory = false;
  while (const unsigned long error = ERR_get_error()) memory |= ERR_GET_REASON(error) == ERR_R_MALLOC_FAILURE;
  if (memory) throw std::bad_alloc();
  fail(Status::unsupported, "%.*s: OpenSSL does not compute this checksum here", static_cast<int>(algorithm.size()),
       algorithm.data());
}

}  // namespace

std::optional<std::size_t> digest_digits(std::string_view algorithm) {
  const Algorithm* const found = find(algorithm);
  return found ? std::optional(found->digits) : std::nullopt;
}

MessageDigest::MessageDigest(std::string_view algorithm)
    : algorithm_(algorithm), context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
  if (!context_) throw std::bad_alloc();
  const Algorithm* const found = find(algorithm);
  const std::unique_ptr<EVP_MD, void (*)(EVP_MD*)> method(
      found ? EVP_MD_fetch(nullptr, found->openssl_name, nullptr) : nullptr, EVP_MD_free);
  if (!method) fail_by_openssl(algorithm);
  require_done(EVP_DigestInit_ex(context_.get(), method.get(), nullptr));
}

void MessageDigest::require_done(int done) const {
  if (done != 1) fail_by_openssl(algorithm_);
}

void MessageDigest::add(std::span<const std::byte> bytes) {
  require_done(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()));
}

std::string MessageDigest::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes;
  unsigned int size = 0;
  require_done(EVP_DigestFinal_ex(context_.get(), bytes.data(), &size));
  std::string text;
  for (unsigned int i = 0; i < size; ++i) text += format("%02x", bytes[i]);
  return text;
}

}  // namespace fb::bake
