#include "bake/signing/der_frame.h"

#include <openssl/asn1.h>

namespace fb::bake {
namespace {

// Elements of DER, one after the other. After one that is not as expected there are none.
class DerReader {
 public:
  explicit DerReader(std::span<const unsigned char> bytes) : at_(bytes.data()), end_(at_ + bytes.size()) {}

  // Goes to the first element inside of the next one.
  DerReader& enter() {
    next();
    end_ = body_end_;
    return *this;
  }
  DerReader& skip() {
    next();
    at_ = body_end_;
    return *this;
  }
  // Goes inside of the last one.
  DerReader& enter_last() {
    DerReader ahead = *this;
    while (ahead.skip().at_ != ahead.end_) *this = ahead;
    return enter();
  }
  // The integer of one byte that is next; -1 of anything else.
  int small_integer() {
    next();
    return tag_ == V_ASN1_INTEGER && body_end_ - at_ == 1 ? *at_ : -1;
  }

 private:
  // Goes behind the head of the next element.
  void next() {
    long size = 0;
    int kind = 0;
    tag_ = -1;
    body_end_ = at_ = at_ < end_ && (ASN1_get_object(&at_, &size, &tag_, &kind, end_ - at_) & 0x80) == 0 ? at_ : end_;
    if (at_ != end_) body_end_ = at_ + size;
  }

  const unsigned char *at_, *end_, *body_end_ = nullptr;
  int tag_ = -1;
};

}  // namespace

bool has_right_versions(std::span<const unsigned char> der, bool by_key_identifier) {
  const int expected = by_key_identifier ? 3 : 1;
  // ContentInfo { OID, [0] { SignedData { version, digests, content, ..., signers { { version, ... } } } } }
  DerReader signed_data = DerReader(der).enter().skip().enter().enter();
  DerReader signer = signed_data;
  return signed_data.small_integer() == expected && signer.enter_last().enter().small_integer() == expected;
}

}  // namespace fb::bake
