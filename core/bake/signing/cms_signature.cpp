#include "bake/signing/cms_signature.h"

#include <openssl/ess.h>

#include <algorithm>
#include <string_view>

#include "bake/signing/content_digest.h"
#include "bake/signing/der_frame.h"
#include "bake/signing/signer_certificate.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

CmsMessage read_message(std::span<const std::byte> der) {
  if (der.size() > most_signature_bytes)
    fail(Status::limit, "is none: it has %zu bytes; one has at most %zu", der.size(), most_signature_bytes);
  const auto* at = reinterpret_cast<const unsigned char*>(der.data());
  const unsigned char* const begin = at;
  CmsMessage message(d2i_CMS_ContentInfo(nullptr, &at, static_cast<long>(der.size())));
  const std::string reason = message ? "" : openssl_reason();
  const std::string_view text(reinterpret_cast<const char*>(begin), der.size());
  if (!message && text.starts_with("-----BEGIN"))
    fail(Status::bad_data,
         "is PEM: a signature is DER, which `openssl cms -cmsout -inform PEM -outform DER` makes of it");
  // What begins as a sequence with the identifier of signed data was one, and is cut or damaged.
  if (!message && text.substr(0, 40).find("\x2a\x86\x48\x86\xf7\x0d\x01\x07\x02") != text.npos)
    fail(Status::bad_data, "is cut short or damaged: %s", reason.c_str());
  if (!message) fail(Status::bad_data, "is none: CMS in DER is expected (%s)", reason.c_str());
  if (const std::size_t read = static_cast<std::size_t>(at - begin); read != der.size())
    fail(Status::bad_data, "has %zu bytes behind its end", der.size() - read);
  return message;
}

// Without parameters, or with the null that some write.
bool is_plain(const X509_ALGOR* algorithm) {
  int type = V_ASN1_UNDEF;
  X509_ALGOR_get0(nullptr, &type, nullptr, algorithm);
  return type == V_ASN1_UNDEF || type == V_ASN1_NULL;
}

int identifier_of(const X509_ALGOR* algorithm) {
  const ASN1_OBJECT* identifier = nullptr;
  X509_ALGOR_get0(&identifier, nullptr, nullptr, algorithm);
  return OBJ_obj2nid(identifier);
}

std::string name_of(const X509_ALGOR* algorithm) {
  const ASN1_OBJECT* identifier = nullptr;
  X509_ALGOR_get0(&identifier, nullptr, nullptr, algorithm);
  char name[80] = "";
  OBJ_obj2txt(name, sizeof name, identifier, 0);
  return shown(name);
}

std::string_view digest_name(int digest) {
  if (digest == NID_sha256) return "SHA-256";
  if (digest == NID_sha384) return "SHA-384";
  return digest == NID_sha512 ? "SHA-512" : "";
}

X509_ALGOR* digest_of(CMS_SignerInfo* signer) {
  X509_ALGOR* digest = nullptr;
  CMS_SignerInfo_get0_algs(signer, nullptr, nullptr, &digest, nullptr);
  return digest;
}

}  // namespace

CmsSignature::CmsSignature(std::span<const std::byte> der) : message_(read_message(der)) {
  if (OBJ_obj2nid(CMS_get0_type(message_.get())) != NID_pkcs7_signed)
    fail(Status::bad_data, "is none: it is CMS of another kind than signed data");
  if (OBJ_obj2nid(CMS_get0_eContentType(message_.get())) != NID_pkcs7_data)
    fail(Status::bad_data, "signs content of another type than data");
  ASN1_OCTET_STRING** content = CMS_get0_content(message_.get());
  if (!content || *content) fail(Status::bad_data, "holds what it signs: it must be detached, beside the file");
  find_signer();
  check_frame(der);
  check_algorithms();
  check_attributes();
}

void CmsSignature::find_signer() {
  STACK_OF(CMS_SignerInfo)* signers = CMS_get0_SignerInfos(message_.get());
  const int count = signers ? sk_CMS_SignerInfo_num(signers) : 0;
  if (count <= 0) fail(Status::bad_data, "has no signer");
  if (count > 1) fail(Status::bad_data, "has %d signers; it must have one", count);
  signer_ = sk_CMS_SignerInfo_value(signers, 0);
  certificates_.reset(CMS_get1_certs(message_.get()));
  const int certificates = certificates_ ? sk_X509_num(certificates_.get()) : 0;
  for (int i = 0; i < certificates && !certificate_; ++i)
    if (CMS_SignerInfo_cert_cmp(signer_, sk_X509_value(certificates_.get(), i)) == 0)
      certificate_ = sk_X509_value(certificates_.get(), i);
  if (!certificate_) fail(Status::bad_data, "has not the certificate of its signer in it");
  try {
    key_kind(X509_get0_pubkey(certificate_));
  } catch (const Error& error) {
    fail(error.status(), "is by %s: %s", subject_of(certificate_).c_str(), error.what());
  }
  check_key_usage(certificate_, "is by");
  CMS_SignerInfo_set1_signer_cert(signer_, certificate_);
}

// What nothing signs has one form, so that no byte of a signature can change unseen.
void CmsSignature::check_frame(std::span<const std::byte> der) const {
  const std::vector<unsigned char> again = der_of(message_.get(), i2d_CMS_ContentInfo, "reading a signature");
  if (!std::ranges::equal(std::as_bytes(std::span(again)), der))
    fail(Status::bad_data, "is damaged: it is CMS, but not in DER");
  ASN1_OCTET_STRING* key_identifier = nullptr;
  X509_NAME* issuer = nullptr;
  CMS_SignerInfo_get0_signer_id(signer_, &key_identifier, &issuer, nullptr);
  if (!has_right_versions(again, key_identifier != nullptr))
    fail(Status::bad_data, "is damaged: its version is not that of RFC 5652");
  // OpenSSL compares names without case.
  if (issuer && der_of(issuer, i2d_X509_NAME, "reading a name") !=
                    der_of(X509_get_issuer_name(certificate_), i2d_X509_NAME, "reading a name"))
    fail(Status::bad_data, "is damaged: it does not name the issuer of its signer's certificate");
}

void CmsSignature::check_algorithms() const {
  X509_ALGOR *digest = nullptr, *signature = nullptr;
  CMS_SignerInfo_get0_algs(signer_, nullptr, nullptr, &digest, &signature);
  const int of_content = identifier_of(digest);
  if (digest_name(of_content).empty() || !is_plain(digest))
    fail(Status::unsupported, "has the digest %s; known are SHA-256, SHA-384 and SHA-512", name_of(digest).c_str());
  int of_signature = of_content, key = identifier_of(signature);
  if (key != NID_rsaEncryption && OBJ_find_sigid_algs(identifier_of(signature), &of_signature, &key) != 1)
    key = NID_undef;
  const int expected = EVP_PKEY_get_base_id(X509_get0_pubkey(certificate_));
  if (key != expected || of_signature != of_content || !is_plain(signature))
    fail(Status::unsupported,
         "is made by %s, which is none of RSA (PKCS #1 v1.5) and ECDSA with that key and the digest %s",
         name_of(signature).c_str(), name_of(digest).c_str());
}

void CmsSignature::check_attributes() const {
  if (CMS_signed_get_attr_count(signer_) <= 0 || !signing_time())
    fail(Status::bad_data, "does not say when it was signed: it has no signing time among signed attributes");
  const int at = CMS_signed_get_attr_by_NID(signer_, NID_id_smime_aa_signingCertificateV2, -1);
  if (at < 0) return;
  const auto* value = static_cast<const ASN1_STRING*>(
      CMS_signed_get0_data_by_OBJ(signer_, OBJ_nid2obj(NID_id_smime_aa_signingCertificateV2), -3, V_ASN1_SEQUENCE));
  const unsigned char* bytes = value ? ASN1_STRING_get0_data(value) : nullptr;
  const std::unique_ptr<ESS_SIGNING_CERT_V2, OpensslFree<ESS_SIGNING_CERT_V2_free>> named(
      bytes ? d2i_ESS_SIGNING_CERT_V2(nullptr, &bytes, ASN1_STRING_length(value)) : nullptr);
  const std::unique_ptr<STACK_OF(X509), OpensslFree<[](STACK_OF(X509) * stack) { sk_X509_free(stack); }>> one(
      made(sk_X509_new_null(), "reading a signature"));
  if (sk_X509_push(one.get(), certificate_) <= 0) succeed(0, "reading a signature");
  if (!named || OSSL_ESS_check_signing_certs(nullptr, named.get(), one.get(), 1) != 1) {
    forget_reason();
    fail(Status::bad_data, "names another certificate as its signer's than the one that is in it");
  }
}

const ASN1_TIME* CmsSignature::signing_time() const {
  const int at = CMS_signed_get_attr_by_NID(signer_, NID_pkcs9_signingTime, -1);
  X509_ATTRIBUTE* attribute = at < 0 ? nullptr : CMS_signed_get_attr(signer_, at);
  const ASN1_TYPE* value = attribute ? X509_ATTRIBUTE_get0_type(attribute, 0) : nullptr;
  if (!value || (value->type != V_ASN1_UTCTIME && value->type != V_ASN1_GENERALIZEDTIME)) return nullptr;
  return value->value.asn1_string;
}

std::string CmsSignature::signed_at() const {
  return moment_of(signing_time());
}

std::string CmsSignature::signed_day() const {
  return day_of(signing_time());
}

std::string CmsSignature::digest() const {
  return std::string(digest_name(identifier_of(digest_of(signer_))));
}

void CmsSignature::check_content(std::span<const std::byte> content) const {
  if (CMS_SignerInfo_verify(signer_) != 1) {
    const std::string reason = openssl_reason();
    fail(Status::bad_data, "was not made by the key of its certificate (%s), or is damaged: %s",
         subject_of(certificate_).c_str(), reason.c_str());
  }
  const BioChain chain = digest_content(message_.get(), content);
  if (CMS_SignerInfo_verify_content(signer_, chain.get()) == 1) return;
  forget_reason();
  fail(Status::bad_data,
       "is of other bytes: the file was changed after %s signed it at %s, or it is the signature of another file",
       subject_of(certificate_).c_str(), signed_at().c_str());
}

}  // namespace fb::bake
