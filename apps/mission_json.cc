#include "apps/mission_json.h"

#include <cmath>

#include "apps/json_output.h"
#include "lib/fusion/dempster_shafer.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;
using world::ObjectBelief;
using world::ObjectState;

Json VectorToJson(const Eigen::Vector3d& v) { return Json{v.x(), v.y(), v.z()}; }

Json CovarianceToJson(const Eigen::Matrix<double, 6, 6>& matrix) {
  Json rows = Json::array();
  for (int i = 0; i < 6; ++i) {
    Json row = Json::array();
    for (int j = 0; j < 6; ++j) row.push_back(matrix(i, j));
    rows.push_back(row);
  }
  return rows;
}

/// The normalised belief in each class, and what is left to the unknown: they sum to 1.
Json Posterior(const world::MassFunction& masses) {
  Json posterior = Json::object();
  for (const auto& [c, mass] : masses.singletons) {
    const double belief = fusion::NormalisedBelief(masses, c);
    if (belief >= 1e-4) posterior[c] = belief;
  }
  posterior["unknown"] = fusion::NormalisedIgnorance(masses);
  return posterior;
}

/// What every view said of a hypothesis.
Json ToJson(const world::PoseHypothesis& hypothesis) {
  Json json;
  json["model"] = hypothesis.model;
  json["X_WM"] = MatrixToJson(hypothesis.X_WM);
  json["support"] = hypothesis.support;
  json["struck"] = hypothesis.struck;
  json["reason"] = hypothesis.reason;
  json["evidence"] = Json::array();
  for (const world::ViewEvidence& e : hypothesis.evidence) {
    const world::Verification& v = e.hypothesis.verification;
    json["evidence"].push_back(
        {{"view", e.view},
         {"score", e.hypothesis.score},
         {"quality", v.quality},
         {"visible", v.visible},
         {"visible_fraction", v.visible_fraction},
         {"matching", v.matching},
         {"see_through", v.see_through},
         {"color_agreement",
          std::isfinite(v.color_agreement) ? Json(v.color_agreement) : Json(nullptr)},
         {"accepted", v.accepted},
         {"reason", v.reason}});
  }
  return json;
}

Json ToJson(const ObjectBelief& object) {
  const bool verified = object.state == ObjectState::kVerified;
  const world::PoseHypothesis* best = object.Best();
  Json json;
  json["id"] = object.id;
  json["state"] = ToString(object.state);
  json["class"] = object.state == ObjectState::kUnknown      ? Json("unknown")
                  : object.state == ObjectState::kClassified ? Json(object.LeadingClass())
                  : best == nullptr                          ? Json(nullptr)
                                                             : Json(best->model);
  json["posterior"] = Posterior(object.masses);
  json["p_WO"] = VectorToJson(object.extent_W.center());
  json["extent"] = VectorToJson(object.extent_W.sizes());
  json["X_WM"] = verified ? MatrixToJson(best->X_WM) : Json(nullptr);
  json["verified_in"] = verified ? Json(best->BestView()->view) : Json(nullptr);
  json["covariance"] = verified ? CovarianceToJson(best->covariance) : Json(nullptr);
  json["views"] = object.sightings.size();
  json["model"] = verified ? Json(best->model) : Json(nullptr);
  json["reason"] = object.reason;
  json["looks_taken"] = object.looks_taken;
  json["hypotheses"] = Json::array();
  for (const world::PoseHypothesis& h : object.hypotheses) json["hypotheses"].push_back(ToJson(h));
  return json;
}

Json ToJson(const world::Look& look, int step, const std::string& outcome) {
  Json json;
  json["step"] = step;
  json["kind"] = look.kind;
  json["target"] = look.target;
  json["way"] = ToString(look.way);
  json["reason"] = look.reason;
  json["chosen"] = look.chosen;
  json["score"] = look.score;
  json["seconds"] = look.seconds;
  json["metres"] = look.metres;
  json["gain"] = look.gain;
  json["visibility"] = look.visibility;
  json["X_WB"] = Json{look.X_WB.x, look.X_WB.y, look.X_WB.yaw};
  json["outcome"] = look.chosen ? Json(outcome) : Json(nullptr);
  return json;
}

Json ToJson(const ModelledThing& thing) {
  const bool made = !thing.model.empty();
  Json json;
  json["object"] = thing.object;
  json["model"] = made ? Json(thing.model) : Json(nullptr);
  json["coverage"] = thing.coverage;
  json["refused"] = thing.refused;
  json["reason"] = thing.reason;
  json["not_kept"] = thing.not_kept.empty() ? Json(nullptr) : Json(thing.not_kept);
  json["triangles"] = thing.scanned.mesh.triangles.size();
  return json;
}

}  // namespace

Json ToJson(const world::SceneBelief& belief, const MissionRecord& record, std::uint64_t seed) {
  Json json;
  json["objects"] = Json::array();
  for (const ObjectBelief& object : belief.objects) {
    if (object.state != ObjectState::kRejected) json["objects"].push_back(ToJson(object));
  }
  json["looks"] = Json::array();
  for (std::size_t i = 0; i < record.looks.size(); ++i) {
    const TakenLook& taken = record.looks[i];
    for (const world::Look& look : taken.candidates) {
      json["looks"].push_back(ToJson(look, static_cast<int>(i) + 1, taken.outcome));
    }
  }
  if (!record.modelled.empty()) json["modelled"] = Json::array();
  for (const ModelledThing& thing : record.modelled) json["modelled"].push_back(ToJson(thing));
  json["seconds"] = {{"compute", record.compute_seconds},
                     {"motion", record.motion_seconds},
                     {"total", record.total_seconds}};
  json["metres"] = record.metres;
  json["seed"] = seed;
  json["end"] = record.end;
  return json;
}

}  // namespace secondlook::apps
