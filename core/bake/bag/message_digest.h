// Checksums of files as manifests of bags have them, by OpenSSL.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct evp_md_ctx_st;

namespace fb::bake {

inline constexpr const char* sha512 = "sha512";

// Hexadecimal digits of a checksum by this algorithm, named as in manifest-sha512.txt; nothing of one that is not
// known.
std::optional<std::size_t> digest_digits(std::string_view algorithm);

// One checksum of bytes that come in pieces.
class MessageDigest {
 public:
  // Fails with unsupported where OpenSSL does not offer a known algorithm, such as MD5 by a rule of the machine.
  explicit MessageDigest(std::string_view algorithm);
  void add(std::span<const std::byte> bytes);
  // In lower case; once.
  std::string finish();

 private:
  void require_done(int done) const;

  std::string algorithm_;
  std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> context_;
};

}  // namespace fb::bake
