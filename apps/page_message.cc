#include "apps/page_message.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

#include "lib/transport/channels.h"

#include "bot_core/images_t.hpp"

namespace secondlook::apps {
namespace {

namespace channel = transport::channel;
using Json = nlohmann::ordered_json;

/// 512 bits that are all zero, as the message reader writes them.
const std::string kNothingOccupied = std::string(86, 'A') + "==";

void Round(Json* json) {
  if (json->is_structured()) {
    for (Json& value : *json) Round(&value);
  } else if (json->is_number_float()) {
    *json = std::round(json->get<double>() * 1e4) / 1e4;
  }
}

void Erase(std::initializer_list<const char*> keys, Json* json) {
  for (const char* key : keys) json->erase(key);
}

void ReduceImages(Json* images) {
  Json left = Json::array();
  for (std::size_t i = 0; i < (*images)["images"].size(); ++i) {
    Json& image = (*images)["images"][i];
    if ((*images)["image_types"][i] != bot_core::images_t::LEFT) continue;
    left.push_back({{"width", image["width"]}, {"height", image["height"]}});
    left.back()["data"] = std::move(image["data"]);
  }
  *images = {{"utime", (*images)["utime"]}, {"images", std::move(left)}};
}

void ReduceVerification(Json* verification) {
  Erase({"rendered", "visible", "matching", "see_through"}, verification);
}

void ReduceView(Json* view) {
  Erase({"sequence", "X_WC_measured"}, view);
  (*view)["camera"].erase("distortion");
  for (Json& detection : (*view)["detections"]) {
    Erase({"num_contour", "box", "center_W", "num_hypotheses"}, &detection);
    for (Json& hypothesis : detection["hypotheses"]) {
      hypothesis.erase("X_CM");
      ReduceVerification(&hypothesis["verification"]);
    }
  }
}

void ReduceObjects(Json* objects) {
  for (Json& object : (*objects)["objects"]) {
    Erase({"num_posterior", "X_WM", "covariance", "num_hypotheses"}, &object);
    for (Json& hypothesis : object["hypotheses"]) {
      Erase({"X_WM", "num_evidence"}, &hypothesis);
      for (Json& evidence : hypothesis["evidence"]) ReduceVerification(&evidence["verification"]);
    }
  }
}

/// Blocks without an occupied voxel stay as empty ones: something may have stood there before.
void ReduceOccupancy(Json* map) {
  for (Json& block : (*map)["blocks"]) {
    block.erase("free");
    if (block["occupied"] == kNothingOccupied) block["occupied"] = "";
  }
}

void ReduceLook(Json* look) {
  Erase({"head", "num_path", "checks", "num_checks", "num_terms"}, look);
}

/// There are hundreds of them in a step. What was refused has no worth.
void ReduceCandidates(Json* candidates) {
  for (Json& look : (*candidates)["looks"]) {
    ReduceLook(&look);
    Erase({"utime", "step", "path_W"}, &look);
    if (look["feasible"] == true) continue;
    Erase({"X_WC", "terms", "score", "seconds", "metres", "chosen"}, &look);
  }
}

}  // namespace

Json ForPage(std::string_view on, Json message) {
  if (on == channel::kImage) {
    ReduceImages(&message);
  } else if (on == channel::kView) {
    ReduceView(&message);
  } else if (on == channel::kObjects) {
    ReduceObjects(&message);
  } else if (on == channel::kOccupancy) {
    ReduceOccupancy(&message);
  } else if (on == channel::kCandidates) {
    ReduceCandidates(&message);
  } else if (on == channel::kLook) {
    ReduceLook(&message);
  } else if (on != channel::kMission && on != channel::kStatus && on != channel::kPlane &&
             on != channel::kNavStatus && on != channel::kTiming && on != channel::kTask) {
    return nullptr;  // NAV_GOAL says what LOOK says
  }
  Round(&message);
  return message;
}

void RemoveEvidence(Json* objects) {
  for (Json& object : (*objects)["objects"]) {
    for (Json& hypothesis : object["hypotheses"]) hypothesis["evidence"] = Json::array();
  }
}

}  // namespace secondlook::apps
