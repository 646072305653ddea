// Parts of a CMS signature that nothing signs, and that OpenSSL reads past.
#pragma once

#include <span>

namespace fb::bake {

// Whether SignedData and its one signer have the version that RFC 5652 (5.1, 5.3) asks for: 1, or 3 where the signer is
// named by the identifier of its key. `der`: a CMS message of signed data over content of the type data, as OpenSSL
// writes it.
bool has_right_versions(std::span<const unsigned char> der, bool by_key_identifier);

}  // namespace fb::bake
