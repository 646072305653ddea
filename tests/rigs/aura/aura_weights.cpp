#include "aura/aura_weights.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace rigs {

AuraWeights::AuraWeights(const std::string& rig_json) {
  const auto rig = nlohmann::json::parse(rig_json);
  controls_ = rig.at("controls").size();
  for (const auto& tent : rig.at("inbetweens")) {
    add_term(tent.at("control"), true, tent.at("x1"), tent.at("x2"), tent.at("x3"));
    first_.push_back(terms_.size());
  }
  for (const auto& product : rig.at("combinations")) {
    for (const auto& term : product) {
      if (term.contains("control")) {
        add_term(term.at("control"), false, 0, 0, 0);
      } else {
        const auto& tent = term.at("tent");
        add_term(tent.at(0), true, tent.at(1), tent.at(2), tent.at(3));
      }
    }
    first_.push_back(terms_.size());
  }
}

void AuraWeights::add_term(std::size_t control, bool tent, double x1, double x2, double x3) {
  if (control >= controls_) throw std::runtime_error("rig.json: a shape depends on a control that is not there");
  if (tent && !(x1 < x2 && x2 <= x3)) throw std::runtime_error("rig.json: the points of a tent do not ascend");
  terms_.push_back({control, tent, x1, x2, x3});
}

void AuraWeights::evaluate(const float* controls, double* weights) const {
  for (std::size_t control = 0; control < controls_; ++control) weights[control] = controls[control];
  for (std::size_t product = 0; product + 1 < first_.size(); ++product) {
    double weight = 1;
    for (std::size_t i = first_[product]; i < first_[product + 1] && weight != 0; ++i) {
      const Term& term = terms_[i];
      const double x = controls[term.control];
      if (!term.tent)
        weight *= x;
      else if (x < term.x1 || x > term.x3)
        weight = 0;
      else if (x < term.x2)
        weight *= (x - term.x1) / (term.x2 - term.x1);
      else if (term.x2 < term.x3)
        weight *= (term.x3 - x) / (term.x3 - term.x2);
    }
    weights[controls_ + product] = weight;
  }
}

}  // namespace rigs
