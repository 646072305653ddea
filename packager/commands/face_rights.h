// What the rights that an archive states come to, as commands show it.
#pragma once

#include <facebaker/facebaker.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "options/command.h"

namespace fb::tool {

// --on, the day that rights are judged by: "" is today.
void add_on(Command command, std::string& on);

class FaceRights {
 public:
  // about: of fb_archive_info or fb_about. on: of add_on.
  explicit FaceRights(const char* about, const std::string& on = "");

  bool stated() const { return stated_; }
  bool expired() const { return expired_; }
  const std::vector<std::string>& binding() const { return binding_; }  // clauses, expiry first
  nlohmann::ordered_json document() const;                              // of fb_rights
  // All that binds in one sentence for standard error: "rights: ...; ...". "" where nothing does.
  std::string note() const;

 private:
  bool stated_ = false, expired_ = false;
  std::vector<std::string> binding_;
  std::string json_;
};

// What is said about the character, rights included, among the texts that a .glb carries, if anything is.
void carry_about(const facebaker::Model& model, std::vector<std::pair<std::string, std::string>>& texts);

}  // namespace fb::tool
