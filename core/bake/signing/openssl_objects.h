// OpenSSL's objects with owners, and its errors as words.
#pragma once

#include <openssl/bio.h>
#include <openssl/cms.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/x509.h>

#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "base/status.h"

namespace fb::bake {

template <auto free_object>
struct OpensslFree {
  template <class T>
  void operator()(T* object) const {
    free_object(object);
  }
};

using BioChain = std::unique_ptr<BIO, OpensslFree<BIO_free_all>>;
using CmsMessage = std::unique_ptr<CMS_ContentInfo, OpensslFree<CMS_ContentInfo_free>>;
using KeyPointer = std::unique_ptr<EVP_PKEY, OpensslFree<EVP_PKEY_free>>;
using CertificatePointer = std::unique_ptr<X509, OpensslFree<X509_free>>;

// Why OpenSSL refused last, in its words; forgets all that it reported. Throws bad_alloc where it had too little
// memory, so that nothing is taken for damage because of that.
inline std::string openssl_reason() {
  const char* reason = nullptr;
  bool out_of_memory = false;
  for (unsigned long code = ERR_get_error(); code != 0; code = ERR_get_error()) {
    out_of_memory = out_of_memory || ERR_GET_REASON(code) == ERR_R_MALLOC_FAILURE;
    if (const char* text = ERR_reason_error_string(code)) reason = text;
  }
  if (out_of_memory) throw std::bad_alloc();
  return reason ? reason : "no reason is given";
}

// For refusals that need no words of OpenSSL's.
inline void forget_reason() {
  static_cast<void>(openssl_reason());
}

// An object that OpenSSL made, or a failure of `what` if it made none.
template <class T>
T* made(T* object, const char* what) {
  if (!object) fail(Status::internal, "OpenSSL fails at %s: %s", what, openssl_reason().c_str());
  return object;
}

inline void succeed(int result, const char* what) {
  if (result <= 0) fail(Status::internal, "OpenSSL fails at %s: %s", what, openssl_reason().c_str());
}

// The DER encoding that one of OpenSSL's i2d functions writes.
template <class T, class Encode>
std::vector<unsigned char> der_of(T* object, Encode encode, const char* what) {
  const int size = encode(object, nullptr);
  succeed(size, what);
  std::vector<unsigned char> bytes(static_cast<std::size_t>(size));
  unsigned char* to = bytes.data();
  succeed(encode(object, &to), what);
  return bytes;
}

}  // namespace fb::bake
