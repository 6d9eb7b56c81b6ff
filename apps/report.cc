#include "apps/report.h"

#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/json_output.h"
#include "apps/mission_json.h"
#include "apps/model_picture.h"
#include "apps/page.h"
#include "apps/view_picture.h"
#include "lib/common/files.h"
#include "lib/fusion/dempster_shafer.h"

namespace secondlook::apps {

void WriteReport(const RunConfig& config, const Mission& mission, const Story& story,
                 const std::filesystem::path& folder) {
  // A picture of an earlier mission would pass for one of this.
  for (int i = 0; std::filesystem::remove(folder / fmt::format("view_{}.png", i)); ++i) {
  }
  WriteJson(ToJson(mission.belief(), mission.record(), config.seed),
            (folder / "mission.json").string());
  WriteFile(folder / "report.html", Page(story.All()));
  SaveRunConfig(config, folder / "config.yaml");
  for (int i = 0; i < static_cast<int>(mission.belief().views.size()); ++i) {
    cv::Mat bgr;
    cv::cvtColor(DrawView(mission.belief(), i), bgr, cv::COLOR_RGB2BGR);
    std::vector<unsigned char> png;
    cv::imencode(".png", bgr, png);
    WriteFile(folder / fmt::format("view_{}.png", i),
              {reinterpret_cast<const char*>(png.data()), png.size()});
  }
  for (const ModelledThing& thing : mission.record().modelled) {
    if (thing.model.empty()) continue;
    SaveModelPicture(thing.scanned.full, folder / fmt::format("model_{}.png", thing.model));
  }
}

void PrintSummary(const Mission& mission, double processor_seconds) {
  fmt::print("\n{:>3}  {:10} {:16} {:>6}  {:>5}  {:24}  {}\n", "id", "state", "class", "belief",
             "views", "position in W [m]", "why");
  for (const world::ObjectBelief& object : mission.belief().objects) {
    if (object.state == world::ObjectState::kRejected) continue;
    const world::PoseHypothesis* best = object.Best();
    const bool classified = object.state == world::ObjectState::kClassified;
    const bool unknown =
        object.state == world::ObjectState::kUnknown || (best == nullptr && !classified);
    const std::string name = unknown ? "-" : classified ? object.LeadingClass() : best->model;
    const double belief = unknown ? fusion::NormalisedIgnorance(object.masses)
                                  : fusion::NormalisedBelief(object.masses, name);
    const Eigen::Vector3d p = object.extent_W.center();
    fmt::print("{:3}  {:10} {:16} {:6.3f}  {:5}  ({:6.3f}, {:6.3f}, {:5.3f})  {}\n", object.id,
               ToString(object.state), name, belief, object.sightings.size(), p.x(), p.y(), p.z(),
               object.reason);
  }
  const MissionRecord& record = mission.record();
  fmt::print(
      "\n{} looks, {:.1f} m, {:.0f} s of robot time ({:.0f} s moving, {:.0f} s thinking); {:.1f} s "
      "of processor time\n{}\n",
      record.looks.size(), record.metres, record.total_seconds, record.motion_seconds,
      record.compute_seconds, processor_seconds, record.end);
}

}  // namespace secondlook::apps
