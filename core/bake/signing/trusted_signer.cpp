#include "bake/signing/trusted_signer.h"

#include <openssl/x509_vfy.h>

#include "bake/signing/signer_certificate.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

using Store = std::unique_ptr<X509_STORE, OpensslFree<X509_STORE_free>>;
using StoreContext = std::unique_ptr<X509_STORE_CTX, OpensslFree<X509_STORE_CTX_free>>;

// Keys of 112 bits of security, and no certificates signed by SHA-1: OpenSSL's level 2.
constexpr int security_level = 2;

CertificatePointer shared(X509* certificate) {
  X509_up_ref(certificate);
  return CertificatePointer(certificate);
}

// From the signer's issuer to a certificate of the file; none where there is no chain, with the reason.
std::vector<CertificatePointer> find_issuers(const CmsSignature& signature, const TrustedFile& file,
                                             std::string& reason) {
  const Store store(made(X509_STORE_new(), "checking a certificate"));
  for (const CertificatePointer& one : file.certificates)
    succeed(X509_STORE_add_cert(store.get(), one.get()), "checking a certificate");
  const StoreContext context(made(X509_STORE_CTX_new(), "checking a certificate"));
  succeed(X509_STORE_CTX_init(context.get(), store.get(), const_cast<X509*>(signature.certificate()),
                              const_cast<STACK_OF(X509)*>(signature.certificates())),
          "checking a certificate");
  X509_VERIFY_PARAM* rules = X509_STORE_CTX_get0_param(context.get());
  // Whatever certificate of the file the chain leads to is trusted; dates are checked by day, with messages of ours.
  X509_VERIFY_PARAM_set_flags(rules, X509_V_FLAG_PARTIAL_CHAIN | X509_V_FLAG_NO_CHECK_TIME);
  X509_VERIFY_PARAM_set_auth_level(rules, security_level);
  std::vector<CertificatePointer> issuers;
  if (X509_verify_cert(context.get()) != 1) {
    reason = X509_verify_cert_error_string(X509_STORE_CTX_get_error(context.get()));
    forget_reason();
    return issuers;
  }
  STACK_OF(X509)* chain = X509_STORE_CTX_get0_chain(context.get());
  for (int i = 1; i < sk_X509_num(chain); ++i) issuers.push_back(shared(sk_X509_value(chain, i)));
  return issuers;
}

std::string list_trusted(std::span<const TrustedFile> trusted) {
  std::string list;
  const auto add = [&list](const std::string& one) { list += (list.empty() ? "" : "; ") + one; };
  for (const TrustedFile& file : trusted) {
    for (const CertificatePointer& one : file.certificates) add(subject_of(one.get()));
    for (const KeyPointer& key : file.keys) add("the key with the SHA-256 " + key_sha256(key.get()));
  }
  return shown(list);
}

[[noreturn]] void refuse(const CmsSignature& signature, std::span<const TrustedFile> trusted,
                         const std::string& reason) {
  const std::string signer = subject_of(signature.certificate()) + ", whose key has the SHA-256 " +
                             key_sha256(X509_get0_pubkey(signature.certificate()));
  if (trusted.empty())
    fail(Status::bad_data, "is intact, and by %s; no certificate or key is given that is trusted", signer.c_str());
  fail(Status::bad_data, "is intact, but by somebody who is not trusted: %s (%s); trusted are: %s", signer.c_str(),
       reason.c_str(), list_trusted(trusted).c_str());
}

}  // namespace

TrustFound find_trust(const CmsSignature& signature, std::span<const TrustedFile> trusted) {
  const X509* const certificate = signature.certificate();
  const EVP_PKEY* const key = X509_get0_pubkey(certificate);
  std::string reason = "another key";
  for (const TrustedFile& file : trusted) {
    for (const CertificatePointer& one : file.certificates)
      if (X509_cmp(one.get(), certificate) == 0)
        return {file.path, TrustedBy::certificate, subject_of(certificate), {}};
    for (const KeyPointer& one : file.keys)
      if (EVP_PKEY_eq(one.get(), key) == 1) return {file.path, TrustedBy::public_key, key_sha256(key), {}};
    forget_reason();  // of keys of another kind
    if (file.certificates.empty()) continue;
    std::vector<CertificatePointer> issuers = find_issuers(signature, file, reason);
    if (issuers.empty()) continue;
    const std::string name = subject_of(issuers.back().get());
    return {file.path, TrustedBy::issuer, name, std::move(issuers)};
  }
  refuse(signature, trusted, reason);
}

}  // namespace fb::bake
