#include "bake/signing/sign_bytes.h"

#include "bake/signing/content_digest.h"
#include "bake/signing/signer_certificate.h"
#include "base/calendar_day.h"

namespace fb::bake {
namespace {

void check_signer(const SigningKey& signer) {
  key_kind(X509_get0_pubkey(signer.certificate.get()));
  check_key_usage(signer.certificate.get(), "it cannot be signed by");
  check_validity(signer.certificate.get(), calendar_day_text(today()), "it cannot be signed by");
}

}  // namespace

std::vector<std::byte> sign_bytes(std::span<const std::byte> content, const SigningKey& signer) {
  check_signer(signer);
  constexpr unsigned flags = CMS_DETACHED | CMS_BINARY | CMS_PARTIAL | CMS_STREAM;
  const CmsMessage message(made(CMS_sign(nullptr, nullptr, nullptr, nullptr, flags), "signing"));
  made(CMS_add1_signer(message.get(), signer.certificate.get(), signer.key.get(), key_kind(signer.key.get()).digest,
                       flags | CMS_NOSMIMECAP | CMS_CADES),
       "signing");
  for (const CertificatePointer& certificate : signer.chain)
    if (CMS_add1_cert(message.get(), certificate.get()) != 1) forget_reason();  // it is there already
  const BioChain chain = digest_content(message.get(), content);
  succeed(CMS_dataFinal(message.get(), chain.get()), "signing");
  const std::vector<unsigned char> der = der_of(message.get(), i2d_CMS_ContentInfo, "writing a signature");
  const auto bytes = std::as_bytes(std::span(der));
  return {bytes.begin(), bytes.end()};
}

}  // namespace fb::bake
