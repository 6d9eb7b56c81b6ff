#include "apps/model_watch.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "lib/common/files.h"
#include "tests/support/small_world.h"

namespace secondlook::apps {
namespace {

class WatchedWorld : public ::testing::Test {
 protected:
  void Add(const std::string& name) {
    world::AddModel(world_ / "mesh" / "mesh.obj", geometry::LengthUnit::kMetre, name,
                    world_.models());
  }

  testing::SmallWorld world_;
  ModelWatch watch_{world_.models(), world::ObjectDatabase::Load(world_.models())};
};

TEST_F(WatchedWorld, GivesEachNewModelOnce) {
  EXPECT_TRUE(watch_.Take().empty());
  Add("slab");
  Add("brick");
  const std::vector<world::ObjectModel> models = watch_.Take();
  ASSERT_EQ(models.size(), 2U);
  EXPECT_EQ(models[0].name, "brick");
  EXPECT_EQ(models[1].name, "slab");
  EXPECT_FALSE(models[1].mesh.empty());
  EXPECT_TRUE(watch_.Take().empty());
}

TEST_F(WatchedWorld, LeavesOutWhatIsHalfWrittenUntilItIsWhole) {
  Add("slab");
  const auto unfinished = world_.models() / ".slab.unfinished";
  std::filesystem::rename(world_.models() / "slab", unfinished);
  EXPECT_TRUE(watch_.Take().empty());
  std::filesystem::rename(unfinished, world_.models() / "slab");
  EXPECT_EQ(watch_.Take().size(), 1U);
}

TEST_F(WatchedWorld, GivesAnObjectThatWasScannedMeanwhile) {
  const geometry::Mesh mesh = geometry::MakeSphere(0.05, 12, {0.5F, 0.5F, 0.5F});
  world::StoreModel({"ball", mesh, mesh, {"striper", 3, 0.8, Time(Seconds(60))}}, world_.models());
  const std::vector<world::ObjectModel> models = watch_.Take();
  ASSERT_EQ(models.size(), 1U);
  EXPECT_EQ(models[0].name, "ball");
  EXPECT_EQ(models[0].provenance->scans, 3);
}

TEST_F(WatchedWorld, LeavesOutWhatCannotBeRead) {
  Add("slab");
  WriteFile(world_.models() / "slab" / "model.yaml", "format: 9\n");
  Add("wedge");
  const std::vector<world::ObjectModel> models = watch_.Take();
  ASSERT_EQ(models.size(), 1U);
  EXPECT_EQ(models[0].name, "wedge");
}

}  // namespace
}  // namespace secondlook::apps
