#include "bake/signing/key_files.h"

#include <openssl/crypto.h>
#include <openssl/pem.h>

#include <algorithm>
#include <cstring>
#include <string_view>

#include "bake/signing/signer_certificate.h"
#include "base/file.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

constexpr std::uint64_t most_bytes = 1 << 20;

// The bytes of a file that may hold a private key, which are overwritten in the end.
struct PemBytes {
  explicit PemBytes(const std::filesystem::path& path) : bytes(read_file(path, most_bytes)) {}
  ~PemBytes() { OPENSSL_cleanse(bytes.data(), bytes.size()); }
  PemBytes(const PemBytes&) = delete;
  PemBytes& operator=(const PemBytes&) = delete;

  BioChain reader() const {
    const void* first = bytes.empty() ? "" : static_cast<const void*>(bytes.data());
    return BioChain(made(BIO_new_mem_buf(first, static_cast<int>(bytes.size())), "reading PEM"));
  }

  std::vector<std::byte> bytes;
};

struct PemParts {
  std::vector<CertificatePointer> certificates;
  std::vector<KeyPointer> public_keys;
  bool private_key = false;
};

void take_block(std::string_view name, const unsigned char* bytes, long size, PemParts& parts) {
  if (name == PEM_STRING_X509 || name == PEM_STRING_X509_OLD) {
    CertificatePointer certificate(d2i_X509(nullptr, &bytes, size));
    if (!certificate) fail(Status::bad_data, "holds a damaged certificate: %s", openssl_reason().c_str());
    parts.certificates.push_back(std::move(certificate));
  } else if (name == PEM_STRING_PUBLIC) {
    KeyPointer key(d2i_PUBKEY(nullptr, &bytes, size));
    if (!key) fail(Status::bad_data, "holds a damaged public key: %s", openssl_reason().c_str());
    parts.public_keys.push_back(std::move(key));
  } else if (name.ends_with("PRIVATE KEY")) {
    parts.private_key = true;
  }
}

// All blocks of a file; private keys are seen, and not read.
PemParts read_parts(const PemBytes& file) {
  const BioChain reader = file.reader();
  PemParts parts;
  char *name = nullptr, *header = nullptr;
  unsigned char* data = nullptr;
  long size = 0;
  while (PEM_read_bio(reader.get(), &name, &header, &data, &size) == 1) {
    const auto free_block = [size](unsigned char* block) { OPENSSL_clear_free(block, static_cast<std::size_t>(size)); };
    const std::unique_ptr<char, OpensslFree<[](void*text) { OPENSSL_free(text); }>> name_owner(name),
        header_owner(header);
    const std::unique_ptr<unsigned char, decltype(free_block)> data_owner(data, free_block);
    take_block(name, data, size, parts);
  }
  const bool at_end = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  const std::string reason = openssl_reason();
  if (!at_end) fail(Status::bad_data, "holds damaged PEM: %s", reason.c_str());
  return parts;
}

struct PassPhrase {
  const std::optional<std::string>& given;
  bool asked = false;
};

// For OpenSSL, which without a function of ours would ask at the terminal.
int give_pass_phrase(char* to, int size, int, void* context) {
  PassPhrase& phrase = *static_cast<PassPhrase*>(context);
  phrase.asked = true;
  if (!phrase.given || phrase.given->size() > static_cast<std::size_t>(size)) return -1;
  std::memcpy(to, phrase.given->data(), phrase.given->size());
  return static_cast<int>(phrase.given->size());
}

KeyPointer read_private_key(const PemBytes& file, const std::optional<std::string>& pass_phrase) {
  PassPhrase phrase{pass_phrase};
  KeyPointer key(PEM_read_bio_PrivateKey(file.reader().get(), nullptr, give_pass_phrase, &phrase));
  const std::string reason = key ? "" : openssl_reason();
  if (!key && phrase.asked && !pass_phrase)
    fail(Status::invalid_argument, "the private key is encrypted, and no pass phrase is given");
  if (!key && phrase.asked) fail(Status::invalid_argument, "the pass phrase given does not open the private key");
  if (!key) fail(Status::bad_data, "holds a damaged private key: %s", reason.c_str());
  key_kind(key.get());
  return key;
}

// The certificate of the key becomes that of `signing`, all others its chain.
void take_certificates(PemParts parts, SigningKey& signing) {
  for (CertificatePointer& certificate : parts.certificates) {
    const EVP_PKEY* key = X509_get0_pubkey(certificate.get());
    if (!signing.certificate && key && EVP_PKEY_eq(key, signing.key.get()) == 1)
      signing.certificate = std::move(certificate);
    else
      signing.chain.push_back(std::move(certificate));
  }
  forget_reason();  // of keys of another kind
}

TrustedFile read_trusted_file(const std::filesystem::path& path) {
  const PemBytes file(path);
  PemParts parts = read_parts(file);
  if (parts.private_key)
    fail(Status::bad_data,
         "holds a private key, which none but the signer may have: give its certificate or public key");
  if (parts.certificates.empty() && parts.public_keys.empty())
    fail(Status::bad_data, "holds neither a certificate nor a public key in PEM");
  return {path, std::move(parts.certificates), std::move(parts.public_keys)};
}

}  // namespace

SigningKey read_signing_key(const std::filesystem::path& key, const std::filesystem::path& certificate,
                            const std::optional<std::string>& pass_phrase) {
  SigningKey signing;
  const std::filesystem::path& holder = certificate.empty() ? key : certificate;
  with_path(key, [&] {
    const PemBytes file(key);
    PemParts parts = read_parts(file);
    if (!parts.private_key) fail(Status::bad_data, "holds no private key in PEM");
    signing.key = read_private_key(file, pass_phrase);
    if (certificate.empty()) take_certificates(std::move(parts), signing);
  });
  with_path(holder, [&] {
    if (!certificate.empty()) take_certificates(read_parts(PemBytes(certificate)), signing);
    if (!signing.certificate)
      fail(Status::bad_data, certificate.empty() ? "holds no certificate of its private key, and none is given"
                                                 : "holds no certificate of the private key");
  });
  return signing;
}

std::vector<TrustedFile> read_trusted(const std::vector<std::filesystem::path>& paths) {
  std::vector<TrustedFile> files;
  for (const std::filesystem::path& path : paths)
    files.push_back(with_path(path, [&] { return read_trusted_file(path); }));
  return files;
}

}  // namespace fb::bake
