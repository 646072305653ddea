#include "signing_files.h"

#include <fstream>

#include "signing_keys.h"

void write_signing_files(const char* folder) {
  const fb::test::SigningTestKey signer(fb::test::new_curve_key(), "Ada"), other(fb::test::new_curve_key(), "Bob");
  const std::string place = std::string(folder) + "/";
  std::ofstream(place + "key.pem") << signer.key_pem() << signer.certificate_pem();
  std::ofstream(place + "signer.pem") << signer.certificate_pem();
  std::ofstream(place + "other.pem") << other.certificate_pem();
}
