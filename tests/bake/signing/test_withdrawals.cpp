// Lists of withdrawals: read, held to their dates and signatures, and applied.
#include "bake/signing/withdrawals.h"

#include "signing/signed_content.h"

namespace test_withdrawals {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

const std::string digits(64, 'a');

std::string list_text(const std::string& entries, const std::string& more = "") {
  return R"({"format": "facebaker-withdrawals", "version": 1, "issued": "2026-05-01", )" + more + R"("withdrawn": [)" +
         entries + "]}";
}

// A list with a signature beside it.
struct SignedList {
  explicit SignedList(const std::string& text) : made(SigningTestKey(new_curve_key(), "Guild")) {
    write_file(file, text);
    sign();
  }
  void sign() const {
    write_file(made.folder / "list.json.sig",
               sign_bytes(read_file(file), read_signing_key(made.folder / "key.pem", "", {})));
  }
  WithdrawalList read(const std::string& day = this_day()) const {
    return verified_withdrawals(file, read_trusted({made.folder / "signer.pem"}), {.day = day});
  }
  std::string refusal(Status status = Status::bad_data, const std::string& day = this_day()) const {
    return failure(status, [&] { read(day); });
  }

  SignedContent made;
  std::filesystem::path file = made.folder / "list.json";
};

TEST_CASE("a withdrawn agreement or archive is refused from its day on, and told of before") {
  const SignedList made(list_text(R"({"agreement": "A-7", "since": "2026-03-01", "reason": "by letter"},
    {"agreement": "A-9", "since": "2090-01-01", "reason": "it ends"},
    {"sha256": ")" + std::string(64, 'A') +
                                  R"(", "since": "2026-04-01", "reason": "a mistake"})"));
  const WithdrawalList list = made.read();
  CHECK(list.issued == "2026-05-01");
  CHECK(list.withdrawals.size() == 3);
  const std::string other(64, 'b');
  CHECK(check_not_withdrawn(list, "A-8", other, this_day()).empty());
  CHECK(check_not_withdrawn(list, "", other, this_day()).empty());
  CHECK(check_not_withdrawn(list, "A-7", other, "2026-02-28").size() == 1);
  CHECK(check_not_withdrawn(list, "A-9", other, this_day()) ==
        std::vector<std::string>{"the consent of agreement A-9 will be withdrawn on 2090-01-01: it ends"});
  const auto refusal = [&](const char* agreement, const std::string& sha256) {
    return failure(Status::bad_data, [&] { check_not_withdrawn(list, agreement, sha256, this_day()); });
  };
  CHECK(refusal("A-7", other) ==
        "the consent of agreement A-7 is withdrawn since 2026-03-01: by letter, says the list of "
        "2026-05-01 by CN = Guild (" +
            made.file.string() + ")");
  CHECK(holds(refusal("", digits),
              "the consent for the archive with the SHA-256 " + digits + " is withdrawn since 2026-04-01"));
}

TEST_CASE("a list that was changed, is not signed, or is of another day is refused, naming its file") {
  const SignedList made(list_text("", R"("next_issue": "2090-06-01", )"));
  CHECK(made.read().next_issue == "2090-06-01");
  CHECK(holds(made.refusal(Status::bad_data, "2026-04-30"), "says that it was signed at"));
  write_file(made.file, list_text(""));
  CHECK(holds(made.refusal(), "the signature is of other bytes"));
  made.sign();
  made.read();
  write_file(made.file, list_text("", R"("next_issue": "2026-06-01", )"));
  made.sign();
  CHECK(holds(made.refusal(),
              "the list of withdrawals of 2026-05-01 is out of date: a newer one was due by 2026-06-01, and this is "));
  write_file(made.file,
             R"({"format": "facebaker-withdrawals", "version": 1, "issued": "2090-01-01", "withdrawn": []})");
  made.sign();
  CHECK(holds(made.refusal(), "the list of withdrawals was issued on 2090-01-01, which is after"));
  made.made.trust(SigningTestKey(new_curve_key(), "Eve").certificate_pem());
  CHECK(holds(made.refusal(), "by somebody who is not trusted: CN = Guild"));
  std::filesystem::remove(made.made.folder / "list.json.sig");
  CHECK(holds(made.refusal(Status::not_found), "list.json.sig"));
}

TEST_CASE("what is signed and is no list of withdrawals is refused, naming field and fault") {
  const auto refused = [](const std::string& text, Status status = Status::bad_data) {
    return SignedList(text).refusal(status);
  };
  CHECK(holds(refused("[]"), "list.json: is no object"));
  CHECK(holds(refused(R"({"format": "facebaker-consent"})"), "format is 'facebaker-consent'"));
  CHECK(holds(refused(R"({"format": "facebaker-withdrawals", "version": 7})", Status::unsupported), "version is 7"));
  CHECK(holds(refused(R"({"format": "facebaker-withdrawals", "version": 1})"), "issued is missing"));
  CHECK(holds(refused(list_text("", R"("next_issue": "2026-04-30", )")),
              "next_issue is 2026-04-30, before it was issued"));
  CHECK(holds(refused(list_text(R"({"since": "2026-03-01", "reason": "x"})")),
              "withdrawn[0] names neither an agreement nor a sha256"));
  CHECK(holds(refused(list_text(R"({"agreement": "A", "since": "2026-02-30", "reason": "x"})")),
              "withdrawn[0] since is '2026-02-30', which is no day"));
  CHECK(holds(refused(list_text(R"({"agreement": "A", "since": "2026-02-20"})")), "withdrawn[0] reason is missing"));
}

}  // namespace test_withdrawals
