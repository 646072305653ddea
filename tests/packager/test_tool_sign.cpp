// Signing by the tool, and what `verify --signature` says and refuses.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "archive/writer.h"
#include "base/calendar_day.h"
#include "base/file.h"
#include "signing_keys.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_sign {

using Json = nlohmann::json;
using fb::test::SigningTestKey;

// A face under agreement A-7, with a key and its certificate.
struct SignedFace {
  SignedFace() {
    fb::PackedModel model = fb::tiny_packed_model();
    model.character.about = R"({"rights":{"agreement":"A-7"}})";
    fb::write_file(face, fb::archive::write_archive(model, {}));
    fb::write_file(key, signer.key_pem());
    fb::write_file(certificate, signer.certificate_pem());
  }

  ToolRun sign(const std::string& file, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"sign", file, "--key", key, "--certificate", certificate};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tool(arguments);
  }
  ToolRun verify(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"verify", face, "--signature", face + ".sig"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tool(arguments);
  }
  // Whether it fails with one line that has the words, and prints nothing else.
  bool refused(const ToolRun& run, const std::vector<std::string>& words, const char* command = "verify") const {
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(run.out.empty());
    const bool told = is_error_line(run.err, command, words);
    CHECK(told);
    return told;
  }

  ScratchFolder folder;
  SigningTestKey signer{fb::test::new_curve_key(), "Ada's studio", {.last_day = 100}};
  std::string face = folder / "face.fbk", key = folder / "key.pem", certificate = folder / "studio.pem";
};

std::string in_days(int days) {
  return fb::calendar_day_text(fb::today() + std::chrono::days(days));
}

TEST_CASE("a signed face says who vouches for it, and is not changed") {
  const SignedFace made;
  const auto before = fb::read_file(made.face);
  const ToolRun sign = made.sign(made.face);
  CAPTURE(sign.err);
  REQUIRE(sign.exit_code == 0);
  CHECK(sign.out.starts_with(made.face + ".sig: signs " + made.face + " at 20"));
  CHECK(sign.out.find("  by CN = Ada's studio (P-256, certificate valid from ") != std::string::npos);
  CHECK(fb::read_file(made.face) == before);

  const ToolRun verify = made.verify({"--trust", made.certificate});
  CAPTURE(verify.err);
  REQUIRE(verify.exit_code == 0);
  for (const std::string& line :
       {made.face + ".sig: signs every byte of " + made.face + ", its provenance and rights too\n",
        "  trusted by its certificate in " + made.certificate + "\n",
        std::string(", as the signer says; nothing proves the time\n")})
    CHECK(verify.out.find(line) != std::string::npos);

  const ToolRun json = made.verify({"--trust", made.certificate, "--json"});
  REQUIRE(json.exit_code == 0);
  const Json read = Json::parse(json.out);
  CHECK(read["archive"] == made.face);
  const Json& signature = read["signature"];
  CHECK(signature["file"] == made.face);
  CHECK(signature["sha256"].get<std::string>().size() == 64);
  CHECK(signature["on"] == in_days(0));
  CHECK(signature["agreement"] == "A-7");
  CHECK(signature["signer"]["subject"] == "CN = Ada's studio");
  CHECK(signature["signer"]["valid_until"] == in_days(100));
  CHECK(signature["signer"]["expired"] == false);
  CHECK(signature["trusted"] ==
        Json({{"by", "certificate"}, {"name", "CN = Ada's studio"}, {"file", made.certificate}}));
  CHECK(signature["withdrawn"].empty());
  CHECK(run_tool({"verify", made.face}).exit_code == 0);
}

TEST_CASE("a face is refused that another signed, that changed, or whose certificate does not hold") {
  const SignedFace made;
  REQUIRE(made.sign(made.face).exit_code == 0);
  made.refused(made.verify({}),
               {"is intact, and by CN = Ada's studio", "no certificate or key is given that is trusted"});
  const std::string others = made.folder / "other.pem";
  fb::write_file(others, SigningTestKey(fb::test::new_curve_key(), "Eve").public_pem());
  made.refused(made.verify({"--trust", others}), {"somebody who is not trusted: CN = Ada's studio", "face.fbk.sig"});
  made.refused(made.verify({"--trust", made.certificate, "--on", in_days(101)}),
               {"whose certificate has expired by " + in_days(101), "--accept-expired"});
  CHECK(made.verify({"--trust", made.certificate, "--on", in_days(101), "--accept-expired"})
            .out.find(": it has expired, which is accepted)") != std::string::npos);
  made.refused(made.verify({"--trust", made.certificate, "--on", in_days(-1)}),
               {"says that it was signed at", in_days(-1)});
  CHECK(made.verify({"--trust", made.certificate, "--on", "soon"}).exit_code == 2);
  made.refused(run_tool({"verify", made.face, "--trust", made.certificate}), {"--trust needs --signature"});
  made.refused(run_tool({"verify", made.face, "--signature", made.folder / "none.sig"}), {"none.sig"});
  made.refused(run_tool({"verify", made.face, "--signature", made.face}),
               {"the signature is none: CMS in DER is expected"});
  fb::write_file(made.face, fb::archive::write_archive(fb::tiny_packed_model(2), {}));
  made.refused(
      made.verify({"--trust", made.certificate}),
      {"is of other bytes: the file was changed after CN = Ada's studio signed it", "the signature of another file"});
}

TEST_CASE("a list of withdrawals reaches faces that are out") {
  const SignedFace made;
  REQUIRE(made.sign(made.face).exit_code == 0);
  const std::string list = made.folder / "withdrawn.json";
  const auto write_list = [&](const std::string& entries) {
    fb::write_file(list, R"({"format": "facebaker-withdrawals", "version": 1, "issued": ")" + in_days(0) +
                             R"(", "withdrawn": [)" + entries + "]}");
    const ToolRun run = made.sign(list);
    CAPTURE(run.err);
    REQUIRE(run.exit_code == 0);
  };
  const std::vector<std::string> with_list = {"--trust", made.certificate, "--withdrawn", list};
  write_list(R"({"agreement": "A-8", "since": "2026-01-01", "reason": "by letter"})");
  const ToolRun held = made.verify(with_list);
  CAPTURE(held.err);
  CHECK(held.exit_code == 0);
  CHECK(held.out.find("  not withdrawn by " + list + ": issued on " + in_days(0) + ", signed by CN = Ada's studio\n") !=
        std::string::npos);
  write_list(R"({"agreement": "A-7", "since": "2026-01-01", "reason": "by letter"})");
  made.refused(made.verify(with_list),
               {"the consent of agreement A-7 is withdrawn since 2026-01-01: by letter, says the list of",
                "by CN = Ada's studio"});
  write_list(R"({"agreement": "A-7", "since": ")" + in_days(9) + R"(", "reason": "by letter"})");
  CHECK(made.verify(with_list).out.find("  note: the consent of agreement A-7 will be withdrawn on " + in_days(9)) !=
        std::string::npos);
  fb::write_file(list, std::string("{}"));
  made.refused(made.verify(with_list), {"the signature is of other bytes", "withdrawn.json.sig"});
}

TEST_CASE("no byte of the private key gets out") {
  const SignedFace made;
  const std::string clear = made.signer.key_pem(), encrypted = made.signer.key_pem("open sesame");
  BIGNUM* number = nullptr;
  REQUIRE(EVP_PKEY_get_bn_param(made.signer.key(), "priv", &number) == 1);
  std::string secret(32, '\0');
  CHECK(BN_bn2binpad(number, reinterpret_cast<unsigned char*>(secret.data()), 32) == 32);
  BN_clear_free(number);
  const ToolRun signs = made.sign(made.face, {"--json"});
  REQUIRE(signs.exit_code == 0);
  const auto bytes = fb::read_file(made.face + ".sig");
  std::string told(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  fb::write_file(made.key, encrypted);
  for (const ToolRun& run : {signs, made.sign(made.face), made.sign(made.face, {"--pass-phrase", made.key}),
                             run_tool({"sign", made.face, "--key", made.face}), made.verify({"--trust", made.key})})
    told += run.out + run.err;
  CHECK(told.find(secret) == std::string::npos);
  std::istringstream words(clear + encrypted);
  for (std::string line; std::getline(words, line);) {
    if (!line.starts_with("-----")) CHECK(told.find(line) == std::string::npos);
  }
}

TEST_CASE("what cannot be signed is refused, and nothing is written") {
  const SignedFace made;
  const auto refused = [&](const ToolRun& run, const std::vector<std::string>& words) {
    made.refused(run, words, "sign");
    CHECK(!std::filesystem::exists(made.face + ".sig"));
  };
  refused(run_tool({"sign", made.face, "--key", made.key}), {"holds no certificate of its private key", "key.pem"});
  refused(run_tool({"sign", made.face, "--key", made.certificate}), {"holds no private key in PEM"});
  for (const std::string& input : {made.face, made.key, made.certificate})
    refused(made.sign(made.face, {"--out", input}), {"the signature would replace " + input});
  const std::string consent = made.folder / "consent.json";
  fb::write_file(consent, std::string(R"({"format": "facebaker-consent", "version": 1, "performer": "Ada"})"));
  refused(made.sign(consent), {"consent.json: agreement is missing"});
  const std::string encrypted = made.folder / "encrypted.pem", phrase = made.folder / "phrase.txt";
  fb::write_file(encrypted, made.signer.key_pem("open sesame"));
  fb::write_file(phrase, std::string("open sesame\r\nsecond line\n"));
  const std::vector<std::string> by_phrase = {"sign", made.face, "--key", encrypted, "--certificate", made.certificate};
  refused(run_tool(by_phrase), {"the private key is encrypted, and no pass phrase is given", "encrypted.pem"});
  std::vector<std::string> with_phrase = by_phrase;
  with_phrase.insert(with_phrase.end(), {"--pass-phrase", phrase, "--out", made.folder / "other.sig"});
  CHECK(run_tool(with_phrase).exit_code == 0);
  CHECK(std::filesystem::exists(made.folder / "other.sig"));
  auto bytes = fb::read_file(made.face);
  bytes[bytes.size() / 2] ^= std::byte{1};
  fb::write_file(made.face, bytes);
  refused(made.sign(made.face), {"face.fbk"});
}

}  // namespace test_tool_sign
