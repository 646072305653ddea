// The errors that an archive states of itself: see FORMAT.md, "certificate".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bake/measure/level_errors.h"
#include "bake/rig/pose_set.h"
#include "figures/face_figures.h"

namespace fb::bake {

// What is measured of a packed face and certified.
struct CertifiedFace {
  bool learned = true;                    // from sampled poses, which fit networks, say; false: see Learning
  Errors quantisation;                    // against the float model, on training and random poses
  Errors dependency;                      // on training poses
  HeldBackErrors held_back;               // on those that nothing was fitted to; without frames where there are none
  std::optional<Errors> exact;            // on the poses that are kept exact; absent where there are none
  std::optional<EvalReport> independent;  // on clips of one split that were not trained on, with quality; absent where
                                          // there are none
  std::vector<LevelErrors> levels;        // of its levels of detail, on the same poses; on training poses without them
  std::vector<std::string> warnings;      // sentences on what is wrong with the face or its rig
};

// "yes" or "no": what certificates and provenance say as "learned".
const char* learned_text(bool learned);

// A JSON object, with the key of warnings only where there are some.
std::string certificate(const CertifiedFace& face);

// Adds to a certificate (whatever text it is) the errors made by repacking, "repacked": displacements of vertices from
// where the archive before had them. Those of several repackings are summed. Where the certificate has measured errors,
// "bound" becomes their sum with the displacements: an upper estimate of the error of the repacked face.
void add_requantisation_errors(std::string& certificate, const Errors& moved);

// Adds to the errors on poses that are kept exact how far repacking has moved these, in upper bounds.
void add_exact_errors(std::string& certificate, const Errors& moved);

// What a certificate says of a face's errors, over D.
struct CertifiedErrors {
  double largest = 0;   // displacement of a vertex from the rig, on unseen and on training poses
  double repacked = 0;  // largest displacement by earlier repackings
};

// None if the text is no certificate with measured errors.
std::optional<CertifiedErrors> certified_errors(const std::string& certificate);

// The main figures and warnings in a few lines for people, each ending in a newline; "" without any.
std::string certificate_summary(const std::string& certificate);

// XXH64 of the training data: of the positions of each pose in order (little-endian floats, in the source's units),
// each seeded with the hash before, the first with 0; then likewise of all controls.
std::uint64_t training_hash(const PoseSet& poses);

}  // namespace fb::bake
