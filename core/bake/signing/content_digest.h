// Digests of bytes that are signed.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "bake/signing/openssl_objects.h"

namespace fb::bake {

// SHA-256, as 64 hexadecimal digits in lower case.
std::string sha256_of_bytes(std::span<const std::byte> bytes);

// Digests `content` by all digests that the message names, for CMS_dataFinal and CMS_SignerInfo_verify_content. Fails
// with bad_data where one of them is unknown.
BioChain digest_content(CMS_ContentInfo* message, std::span<const std::byte> content);

}  // namespace fb::bake
