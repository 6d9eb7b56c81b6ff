#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/commands/commands.h"
#include "apps/model_picture.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/perception/training_file.h"
#include "lib/world/object_database.h"

namespace secondlook::apps {
namespace {

struct ModelOptions {
  std::string mesh;
  std::string unit;
  std::string name;
  std::string models;
  std::string pictures;
  std::vector<std::string> symmetries;
};

void Remove(const std::string& name, const std::string& folder) {
  world::RemoveModel(name, folder);
  std::filesystem::remove(perception::TrainingFile(std::filesystem::path(folder) / name));
}

void Add(const ModelOptions& options) {
  std::vector<world::DeclaredSymmetry> symmetries;
  for (const std::string& text : options.symmetries) {
    symmetries.push_back(world::ParseSymmetry(text));
  }
  world::AddModel(options.mesh, geometry::ParseLengthUnit(options.unit), options.name,
                  options.models, symmetries);
  // What recognition trains is made here once, so that no mission has to. A model that can't be
  // trained doesn't stay.
  const std::filesystem::path folder = std::filesystem::path(options.models) / options.name;
  std::filesystem::remove(perception::TrainingFile(folder));
  try {
    perception::TrainModels(world::ObjectDatabase({world::ReadModel(folder)}));
  } catch (const InvalidArgument&) {
    Remove(options.name, options.models);
    throw;
  }
}

/// How a model came to be, in words.
std::string MadeBy(const world::ObjectModel& model) {
  if (!model.provenance) return "from a mesh";
  const world::Provenance& made = *model.provenance;
  return fmt::format("{} scans by {}, {:.0f} % seen, {}", made.scans, made.sensor,
                     100.0 * made.coverage, world::DateOf(made));
}

/// Lists `folder` and, unless it is "", leaves a picture of each model in `pictures`.
void List(const std::string& folder, const std::string& pictures) {
  if (!pictures.empty()) MakeWritableFolder(pictures);
  const auto database = world::ObjectDatabase::Load(folder);
  fmt::print("{:24} {:>22} {:>10}  {:16}  {}\n", "model", "size [m]", "triangles", "hash", "made");
  for (const world::ObjectModel& model : database.models()) {
    const Eigen::Vector3d size = geometry::Bounds(model.mesh).sizes();
    fmt::print("{:24} {:6.3f} x {:5.3f} x {:5.3f} {:10}  {:016x}  {}\n", model.name, size.x(),
               size.y(), size.z(), model.mesh.triangles.size(), model.hash, MadeBy(model));
    if (pictures.empty()) continue;
    SaveModelPicture(world::ReadFullMesh(model.folder),
                     std::filesystem::path(pictures) / (model.name + ".png"));
  }
}

}  // namespace

void AddModel(CLI::App* app, int*) {
  CLI::App* model = app->add_subcommand("model", "The objects the robot knows");
  model->require_subcommand(1);
  const auto options = std::make_shared<ModelOptions>();  // outlives this function in callbacks

  CLI::App* add = model->add_subcommand("add", "Adds a mesh to a model folder");
  add->add_option("--mesh", options->mesh, "OBJ, PLY, GLB or STL file")->required();
  add->add_option("--unit", options->unit, "Its unit of length: m or mm")->required();
  add->add_option("--name", options->name, "What the object is to be called")->required();
  add->add_option("--models", options->models, "Model folder; made when missing")->required();
  add->add_option("--symmetry", options->symmetries,
                  "A turn that leaves it as it is: an axis (x, y, z or a direction 0,1,1), with :N "
                  "for the steps of a whole turn; may be repeated");
  add->callback([options] {
    Add(*options);
    fmt::print("added '{}' to {}\n", options->name, options->models);
  });

  CLI::App* list = model->add_subcommand("list", "Lists a model folder");
  list->add_option("--models", options->models, "Model folder")->required();
  list->add_option("--pictures", options->pictures, "Folder for a picture of each");
  list->callback([options] { List(options->models, options->pictures); });

  CLI::App* remove = model->add_subcommand("remove", "Removes a model from a model folder");
  remove->add_option("--name", options->name, "Name of the model")->required();
  remove->add_option("--models", options->models, "Model folder")->required();
  remove->callback([options] {
    Remove(options->name, options->models);
    fmt::print("removed '{}' from {}\n", options->name, options->models);
  });
}

}  // namespace secondlook::apps
