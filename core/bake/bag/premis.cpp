#include "bake/bag/premis.h"

#include <algorithm>

#include "bake/bag/tag_files.h"
#include "bake/bag/xml_writer.h"
#include "base/file_extension.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr const char *of_path = "path in the bag", *of_bag = "local to this document",
                     *of_software = "name and version";
constexpr const char* root_attributes =
    " xmlns=\"http://www.loc.gov/premis/v3\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\""
    " xsi:schemaLocation=\"http://www.loc.gov/premis/v3 https://www.loc.gov/standards/premis/premis.xsd\""
    " version=\"3.0\"";

// Elements of PREMIS come in pairs of type and value under one name.
void add_identifier(XmlWriter& xml, const std::string& name, const char* type, const std::string& value) {
  xml.open(name.c_str());
  xml.text((name + "Type").c_str(), type);
  xml.text((name + "Value").c_str(), value);
  xml.close();
}

std::string format_name(const std::string& path) {
  static const std::map<std::string, const char*> names = {{".png", "Portable Network Graphics"},
                                                           {".glb", "glTF binary"},
                                                           {".gltf", "glTF"},
                                                           {".md", "Markdown"},
                                                           {".txt", "Plain text"},
                                                           {".py", "Python source"},
                                                           {".json", "JSON"},
                                                           {".xml", "XML"},
                                                           {".npy", "NumPy array"},
                                                           {".obj", "Wavefront OBJ"},
                                                           {".sig", "CMS signature"},
                                                           {".pem", "PEM"}};
  const auto found = names.find(file_extension(path));
  return found == names.end() ? "unknown" : found->second;
}

class Premis {
 public:
  Premis(const std::vector<FaceRecord>& faces, const std::string& date, const std::string& software)
      : faces_(faces), date_(date), software_(software) {}

  std::string write(const std::map<std::string, BaggedFile>& files) {
    xml_.open("premis", root_attributes);
    for (const auto& [path, file] : files)
      if (path.starts_with(payload_prefix)) add_object(path, file);
    for (std::size_t i = 0; i < faces_.size(); ++i) add_events(i);
    add_bagging();
    for (const std::string& agent : agents()) add_agent(agent);
    for (std::size_t i = 0; i < faces_.size(); ++i) add_rights(i);
    xml_.close();
    return xml_.finish();
  }

 private:
  void add_object(const std::string& path, const BaggedFile& file);
  void add_format(const std::string& path, const FaceRecord* face);
  void add_events(std::size_t face);
  void add_event(const std::string& identifier, const char* type, const std::string& date, const std::string& detail,
                 const std::string& outcome, const std::string& agent, const std::vector<std::string>& objects);
  void add_bagging();
  void add_agent(const std::string& name);
  void add_rights(std::size_t face);
  void add_statement(const std::string& identifier, const FaceRecord& face);
  std::vector<std::string> agents() const;

  const FaceRecord* face_at(const std::string& path) const {
    const auto found = std::ranges::find(faces_, path, &FaceRecord::file);
    return found == faces_.end() ? nullptr : &*found;
  }
  // The face that this is an access copy of.
  const FaceRecord* copied_face(const std::string& path) const {
    const auto found = std::ranges::find_if(
        faces_, [&](const FaceRecord& face) { return std::ranges::find(face.copies, path) != face.copies.end(); });
    return found == faces_.end() ? nullptr : &*found;
  }

  XmlWriter xml_;
  const std::vector<FaceRecord>& faces_;
  const std::string &date_, &software_;
};

void Premis::add_format(const std::string& path, const FaceRecord* face) {
  xml_.open("format");
  xml_.open("formatDesignation");
  xml_.text("formatName", face ? "FaceBaker archive" : format_name(path));
  if (face) xml_.text("formatVersion", face->version);
  xml_.close();
  if (face) {
    xml_.open("formatRegistry");
    xml_.text("formatRegistryName", "PRONOM");
    xml_.text("formatRegistryKey", "not assigned yet");
    xml_.close();
    xml_.text("formatNote",
              "media type application/x-facebaker; begins with the bytes 89 46 42 4B 0D 0A 1A 0A; "
              "data/texts/FORMAT.md describes it");
  }
  xml_.close();
}

void Premis::add_object(const std::string& path, const BaggedFile& file) {
  const FaceRecord* const face = face_at(path);
  xml_.open("object", " xsi:type=\"file\"");
  add_identifier(xml_, "objectIdentifier", of_path, path);
  xml_.open("objectCharacteristics");
  xml_.text("compositionLevel", "0");
  xml_.open("fixity");
  xml_.text("messageDigestAlgorithm", "SHA-512");
  xml_.text("messageDigest", file.digest);
  xml_.text("messageDigestOriginator", software_);
  xml_.close();
  xml_.text("size", std::to_string(file.bytes));
  add_format(path, face);
  if (face && !face->creator.empty()) {
    xml_.open("creatingApplication");
    xml_.text("creatingApplicationName", face->creator);
    if (!face->created.empty()) xml_.text("dateCreatedByApplication", face->created);
    xml_.close();
  }
  xml_.close();
  if (face) xml_.text("originalName", face->name);
  if (const FaceRecord* const copied = copied_face(path)) {
    xml_.open("relationship");
    xml_.text("relationshipType", "derivation");
    xml_.text("relationshipSubType", "has source");
    add_identifier(xml_, "relatedObjectIdentifier", of_path, copied->file);
    xml_.close();
  }
  xml_.close();
}

void Premis::add_event(const std::string& identifier, const char* type, const std::string& date,
                       const std::string& detail, const std::string& outcome, const std::string& agent,
                       const std::vector<std::string>& objects) {
  xml_.open("event");
  add_identifier(xml_, "eventIdentifier", of_bag, identifier);
  xml_.text("eventType", type);
  xml_.text("eventDateTime", date);
  xml_.open("eventDetailInformation");
  xml_.text("eventDetail", detail);
  xml_.close();
  if (!outcome.empty()) {
    xml_.open("eventOutcomeInformation");
    xml_.text("eventOutcome", outcome);
    xml_.close();
  }
  if (!agent.empty()) add_identifier(xml_, "linkingAgentIdentifier", of_software, agent);
  for (const std::string& object : objects) add_identifier(xml_, "linkingObjectIdentifier", of_path, object);
  xml_.close();
}

void Premis::add_events(std::size_t index) {
  const FaceRecord& face = faces_[index];
  const std::string number = format(" %zu", index + 1);
  if (!face.created.empty())
    add_event("creation" + number, "creation", face.created,
              "baked; data/metadata/" + face.name + ".provenance.txt says of what and how", "", face.creator,
              {face.file});
  add_event("validation" + number, "validation", date_, "every checksum of the archive, and the poses of its proof",
            face.poses > 0
                ? format("pass: %zu poses of %zu vertices evaluate as archived, bit for bit", face.poses, face.vertices)
                : "pass: whole; it carries no poses to compare",
            software_, {face.file});
  if (!face.copies.empty())
    add_event("access copies" + number, "migration", date_, "copies for viewing, which are approximations", "",
              software_, face.copies);
}

void Premis::add_bagging() {
  std::vector<std::string> archives;
  for (const FaceRecord& face : faces_) archives.push_back(face.file);
  add_event("bag", "information package creation", date_, "written as a bag (BagIt 1.0, RFC 8493) with SHA-512", "",
            software_, archives);
}

std::vector<std::string> Premis::agents() const {
  std::vector<std::string> names = {software_};
  for (const FaceRecord& face : faces_)
    if (!face.creator.empty() && std::ranges::find(names, face.creator) == names.end()) names.push_back(face.creator);
  return names;
}

void Premis::add_agent(const std::string& name) {
  xml_.open("agent");
  add_identifier(xml_, "agentIdentifier", of_software, name);
  xml_.text("agentName", name);
  xml_.text("agentType", "software");
  xml_.close();
}

void Premis::add_rights(std::size_t index) {
  const FaceRecord& face = faces_[index];
  const bool stated = !face.licence.empty() || std::ranges::any_of(face.about, [](const auto& field) {
    return field.first.starts_with("rights.");
  });
  if (!stated) return;
  xml_.open("rights");
  xml_.open("rightsStatement");
  add_statement(format("rights %zu", index + 1), face);
  xml_.close();
  xml_.close();
}

void Premis::add_statement(const std::string& identifier, const FaceRecord& face) {
  add_identifier(xml_, "rightsStatementIdentifier", of_bag, identifier);
  const std::string agreement = face.right("agreement"), expires = face.right("expires"), uses = face.right("uses");
  xml_.text("rightsBasis", face.licence.empty() ? "other" : "license");
  if (!face.licence.empty()) {
    xml_.open("licenseInformation");
    xml_.text("licenseTerms", face.licence);
    xml_.close();
  }
  xml_.open("otherRightsInformation");
  if (!agreement.empty())
    add_identifier(xml_, "otherRightsDocumentationIdentifier", "agreement as the archive names it", agreement);
  xml_.text("otherRightsBasis", "stated by the archive");
  for (const auto& [name, value] : face.about)
    if (name.starts_with("rights.")) xml_.text("otherRightsNote", name.substr(7) + ": " + value);
  xml_.close();
  if (!uses.empty() || !expires.empty()) {
    xml_.open("rightsGranted");
    xml_.text("act", "use");
    if (!uses.empty()) xml_.text("restriction", uses);
    if (!expires.empty()) {
      xml_.open("termOfGrant");
      xml_.text("startDate", "unknown");  // as EDTF has it
      xml_.text("endDate", expires);
      xml_.close();
    }
    xml_.close();
  }
  add_identifier(xml_, "linkingObjectIdentifier", of_path, face.file);
}

}  // namespace

std::string premis_xml(const std::map<std::string, BaggedFile>& files, const std::vector<FaceRecord>& faces,
                       const std::string& date, const std::string& software) {
  return Premis(faces, date, software).write(files);
}

}  // namespace fb::bake
