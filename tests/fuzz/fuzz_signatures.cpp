// Feeds arbitrary bytes to what reads signatures and what belongs to them: the first byte says which kind the others
// are.
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>

#include "bake/signing/check_signature.h"
#include "bake/signing/consent.h"
#include "bake/signing/withdrawals.h"
#include "fuzz_folder.h"

namespace {

const std::string day = "2031-12-31";

// Whatever it is, nobody is trusted, so that it may not pass.
void check_signature(std::span<const std::byte> signature) {
  const std::string_view content = "a face";
  fb::bake::check_signature(std::as_bytes(std::span(content)), signature, {}, {.day = day});
  std::abort();
}

void check_list(std::string_view text) {
  fb::bake::WithdrawalList list = fb::bake::parse_withdrawals(text, "list.json");
  for (const fb::bake::Withdrawal& one : list.withdrawals)
    if ((one.agreement.empty() && one.sha256.size() != 64) || one.since.size() != 10) std::abort();
  fb::bake::check_not_withdrawn(list, "A-7", std::string(64, '0'), day);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  fuzz::expect_message([&] {
    switch (data[0]) {
      case 's':
        check_signature(std::as_bytes(std::span(text)));
        break;
      case 't':
        fb::bake::read_trusted({fuzz::put("trusted.pem", data + 1, size - 1)});
        break;
      case 'c':
        if (fb::bake::parse_consent(text, "consent.json").permits.empty()) std::abort();
        break;
      case 'w':
        check_list(text);
        break;
      default:
        break;
    }
  });
  return 0;
}
