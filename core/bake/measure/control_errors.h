// Errors by control: what each control of an archive moves, alone and among others, against the rig.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"
#include "figures/member_list.h"
#include "model/packed_model.h"

namespace fb::bake {

// Distances are the largest at a vertex, over D.
struct ControlError {
  std::string name;
  double alone = 0;         // error with all other controls at rest
  double alone_motion = 0;  // by which the control then moves the rig
  double among = 0;         // error of what moving the control adds where others are active
  double among_share = 0;   // rms of those errors over the rms of what moving the control adds; 0 to about 1
  std::string place = {};   // of the vertex with the largest of these errors, see FaceMap::name_of
};

// Of the documents.
template <class Visit, MaybeConst<ControlError> Struct>
void visit_fields(Visit& visit, Struct& error) {
  visit("name", error.name);
  visit("alone", error.alone);
  visit("among", error.among);
  visit("among_share", error.among_share);
}

// Poses that control_errors evaluates on a rig.
std::uint64_t control_error_calls(std::size_t controls);

// Evaluates every control alone, at both ends of its range and at eight values drawn from equal parts of it, and in 4
// to 32 (256 over the number of controls) of 32 random poses, in which a quarter of the controls are active, with the
// control active and at rest. One for every control, in their order. Fails with invalid_argument on a recording, and as
// check_same_face does.
std::vector<ControlError> control_errors(const PackedModel& model, RigEvaluator& rig, std::uint64_t seed,
                                         Progress& progress);

// The controls that an archive does not reproduce, worst first: those off by more than 0.5 % of the diagonal and half
// of their motion alone, or by more than 2 % among others and, as an rms, 70 % of what they add there.
std::vector<ControlError> unlearnt_controls(std::vector<ControlError> errors);

// A sentence that names the control and its errors.
std::string warning_of(const ControlError& error);

}  // namespace fb::bake
