#include "lib/world/object_database.h"

#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/support/expect_throws.h"

namespace secondlook::world {
namespace {

namespace fs = std::filesystem;
using geometry::LengthUnit;

/// A database folder, and a mesh file of a tetrahedron beside it.
class ObjectDatabaseFolder : public ::testing::Test {
 protected:
  ObjectDatabaseFolder()
      : root_(fs::path(::testing::TempDir()) /
              (std::string("database_") +
               ::testing::UnitTest::GetInstance()->current_test_info()->name())),
        models_(root_ / "models"),
        mesh_(root_ / "tetrahedron.obj") {
    fs::remove_all(root_);
    WriteFile(mesh_,
              "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nv 0 0 0.2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  }
  ~ObjectDatabaseFolder() override { fs::remove_all(root_); }

  void Add(const std::string& name) { AddModel(mesh_, LengthUnit::kMetre, name, models_); }

  /// Replaces `from` by `to` in a file of the database.
  static void Edit(const fs::path& file, const std::string& from, const std::string& to) {
    std::string text = ReadFile(file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << text;
    WriteFile(file, text.replace(at, from.size(), to));
  }

  fs::path root_;
  fs::path models_;
  fs::path mesh_;
};

TEST_F(ObjectDatabaseFolder, GivesBackWhatWasAddedInTheOrderOfNames) {
  Add("pyramid");
  AddModel(mesh_, LengthUnit::kMetre, "Block-2", models_);
  const ObjectDatabase database = ObjectDatabase::Load(models_);
  ASSERT_EQ(database.models().size(), 2U);
  EXPECT_EQ(database.models()[0].name, "Block-2");
  EXPECT_EQ(database.models()[1].name, "pyramid");
  ASSERT_NE(database.Find("pyramid"), nullptr);
  EXPECT_EQ(database.Find("pyramid")->mesh.triangles.size(), 4U);
  EXPECT_NEAR(geometry::Diameter(database.Find("pyramid")->mesh), 0.2 * std::sqrt(3.0), 1e-5);
  EXPECT_EQ(database.Find("sphere"), nullptr);
}

TEST_F(ObjectDatabaseFolder, IsNotReadWhereAModelIsHalfWritten) {
  Add("pyramid");
  fs::copy(models_ / "pyramid", models_ / ".cone.unfinished", fs::copy_options::recursive);
  EXPECT_EQ(ModelFolders(models_), std::vector<fs::path>{models_ / "pyramid"});
}

TEST_F(ObjectDatabaseFolder, GrowsInTheOrderOfNamesAndByNewNamesAlone) {
  Add("pyramid");
  Add("cone");
  ObjectDatabase database({ReadModel(models_ / "pyramid")});
  database.Add(ReadModel(models_ / "cone"));
  EXPECT_EQ(database.models()[0].name, "cone");
  EXPECT_THROWS(database.Add(ReadModel(models_ / "cone")), InvalidArgument,
                "two objects are named 'cone'");
}

TEST_F(ObjectDatabaseFolder, KeepsDeclaredSymmetriesAndKnowsThemByTheHash) {
  Add("pyramid");
  AddModel(mesh_, LengthUnit::kMetre, "turned", models_,
           {ParseSymmetry("z"), ParseSymmetry("0,3,4:2")});
  const ObjectDatabase database = ObjectDatabase::Load(models_);
  const ObjectModel& turned = *database.Find("turned");
  ASSERT_EQ(turned.symmetries.size(), 2U);
  EXPECT_EQ(turned.symmetries[0].direction_M, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(turned.symmetries[0].fold, 0);
  EXPECT_TRUE(turned.symmetries[1].direction_M.isApprox(Eigen::Vector3d(0.0, 0.6, 0.8)));
  EXPECT_EQ(turned.symmetries[1].fold, 2);
  // What was trained without the declaration must not be used with it.
  EXPECT_NE(turned.hash, database.Find("pyramid")->hash);
}

TEST_F(ObjectDatabaseFolder, NamesTheFileOfASymmetryThatIsNone) {
  AddModel(mesh_, LengthUnit::kMetre, "pyramid", models_, {ParseSymmetry("z:4")});
  Edit(models_ / "pyramid" / "model.yaml", "z:4", "w:4");
  EXPECT_THROWS(ReadModel(models_ / "pyramid"), ConfigError,
                "model.yaml: symmetry 'w:4': give an axis (x, y, z, or a direction such as 0,1,1)");
}

TEST(ParseSymmetry, RefusesWhatIsNoAxisOrNoNumberOfSteps) {
  for (const char* text : {"", ":", "z:", "z:1", "z:25", "z:2.5", "z:-4", "zz", "0,0,0", "1,2",
                           "1,2,nan", "z:4:4", "Z"}) {
    EXPECT_THROWS(ParseSymmetry(text), InvalidArgument, "from 2 to 24, such as z:4") << text;
  }
}

TEST_F(ObjectDatabaseFolder, ScalesMillimetresToMetres) {
  WriteFile(mesh_,
            "v 0 0 0\nv 200 0 0\nv 0 200 0\nv 0 0 200\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  AddModel(mesh_, LengthUnit::kMillimetre, "pyramid", models_);
  const ObjectDatabase database = ObjectDatabase::Load(models_);
  EXPECT_NEAR(geometry::Bounds(database.models()[0].mesh).max().x(), 0.2, 1e-6);
}

TEST_F(ObjectDatabaseFolder, ModelsOfTheSameContentHaveTheSameHash) {
  Add("one");
  Add("two");
  const ObjectDatabase database = ObjectDatabase::Load(models_);
  EXPECT_EQ(database.models()[0].hash, database.models()[1].hash);
  EXPECT_NE(database.models()[0].hash, 0U);
}

TEST_F(ObjectDatabaseFolder, LeavesNothingBehindWhenTheMeshIsRefused) {
  EXPECT_THROWS(AddModel(mesh_, LengthUnit::kMillimetre, "pyramid", models_), ConfigError,
                "tetrahedron.obj");
  EXPECT_FALSE(fs::exists(models_ / "pyramid"));
}

TEST_F(ObjectDatabaseFolder, ANameIsTakenOnce) {
  Add("pyramid");
  EXPECT_THROWS(Add("pyramid"), ConfigError, "there is a model of this name already");
}

TEST_F(ObjectDatabaseFolder, ANameMustBeAPlainFileName) {
  for (const char* name : {"", "..", "a/b", ".hidden", "a b", "a\n"}) {
    EXPECT_THROWS(Add(name), ConfigError, "is no plain file name");
    EXPECT_THROWS(RemoveModel(name, models_), ConfigError, "is no plain file name");
  }
}

TEST_F(ObjectDatabaseFolder, AModelNamesNothingOutsideItsFolder) {
  Add("pyramid");
  Edit(models_ / "pyramid/model.yaml", "name: \"pyramid\"", "name: \"../pyramid\"");
  EXPECT_THROWS(ObjectDatabase::Load(models_), ConfigError, "must be plain file names");
  Edit(models_ / "pyramid/model.yaml", "name: \"../pyramid\"", "name: \"pyramid\"");
  Edit(models_ / "pyramid/model.yaml", "mesh: mesh.obj", "mesh: /etc/passwd");
  EXPECT_THROWS(ObjectDatabase::Load(models_), ConfigError, "mesh '/etc/passwd' must be plain");
}

TEST_F(ObjectDatabaseFolder, AModelThatWasRemovedIsGone) {
  Add("one");
  Add("two");
  RemoveModel("one", models_);
  const ObjectDatabase database = ObjectDatabase::Load(models_);
  ASSERT_EQ(database.models().size(), 1U);
  EXPECT_EQ(database.models()[0].name, "two");
  EXPECT_THROWS(RemoveModel("one", models_), ConfigError, "there is no model named 'one'");
}

TEST_F(ObjectDatabaseFolder, NamesAFolderThatIsMissingOrEmpty) {
  EXPECT_THROWS(ObjectDatabase::Load(models_), ConfigError, "no such folder of models");
  fs::create_directories(models_);
  EXPECT_THROWS(ObjectDatabase::Load(models_), ConfigError, "no models");
}

TEST_F(ObjectDatabaseFolder, RefusesAnotherFormat) {
  Add("pyramid");
  Edit(models_ / "pyramid/model.yaml", "format: 1", "format: 2");
  EXPECT_THROWS(ObjectDatabase::Load(models_), ConfigError,
                "pyramid/model.yaml: format 2; this program reads format 1");
}

TEST_F(ObjectDatabaseFolder, RefusesFilesThatHaveChanged) {
  Add("pyramid");
  WriteFile(models_ / "pyramid/mesh.obj", ReadFile(models_ / "pyramid/mesh.obj") + "# edited\n");
  EXPECT_THROWS(ObjectDatabase::Load(models_), ConfigError, "they have changed");
}

TEST_F(ObjectDatabaseFolder, RefusesTwoFoldersWithOneName) {
  Add("pyramid");
  fs::copy(models_ / "pyramid", models_ / "copy");
  EXPECT_THROWS(ObjectDatabase::Load(models_), ConfigError, "two objects are named 'pyramid'");
}

TEST_F(ObjectDatabaseFolder, NamesAKeyItDoesNotKnowAndAUnitThatIsNone) {
  Add("pyramid");
  Edit(models_ / "pyramid/model.yaml", "unit: m", "unit: inch");
  EXPECT_THROWS(ObjectDatabase::Load(models_), ConfigError, "inch");
  Edit(models_ / "pyramid/model.yaml", "unit: inch", "colour: red\nunit: m");
  EXPECT_THROWS(ObjectDatabase::Load(models_), ConfigError, "unknown key 'colour'");
}

TEST(ObjectDatabase, ReadsTheModelsThatComeWithTheProject) {
  const ObjectDatabase database = ObjectDatabase::Load("sim/models");
  EXPECT_GE(database.models().size(), 16U);
  EXPECT_NE(database.Find("mug"), nullptr);
}

TEST(ObjectDatabase, RefusesTwoModelsOfOneName) {
  ObjectModel model;
  model.name = "mug";
  EXPECT_THROWS(ObjectDatabase({model, model}), InvalidArgument, "two objects are named 'mug'");
}

TEST(AddModel, RefusesTheNameThatMeansNoModel) {
  EXPECT_THROWS(AddModel("any.obj", geometry::LengthUnit::kMetre, "unknown", "any"), ConfigError,
                "model name 'unknown' is what an object is called that no model fits");
}

/// A ball that was scanned, with more detail than it is recognised by.
ScannedModel Ball(const std::string& name) {
  using geometry::MakeSphere;
  return {name,
          MakeSphere(0.05, 60, {0.2F, 0.4F, 0.6F}),
          MakeSphere(0.05, 12, {0.2F, 0.4F, 0.6F}),
          {"striper", 7, 0.925, Time(Seconds(1'772'368'496.25))}};
}

/// No file grows beyond `bytes` while this lives, as on a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limited{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limited);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST_F(ObjectDatabaseFolder, KeepsAScannedObjectWithWhereItComesFrom) {
  StoreModel(Ball("ball"), models_);
  const ObjectDatabase database = ObjectDatabase::Load(models_);
  ASSERT_EQ(database.models().size(), 1U);
  const ObjectModel& ball = database.models()[0];
  EXPECT_EQ(ball.mesh.triangles.size(), Ball("").mesh.triangles.size());
  EXPECT_EQ(ReadFullMesh(models_ / "ball").triangles.size(), Ball("").full.triangles.size());
  ASSERT_TRUE(ball.provenance.has_value());
  EXPECT_EQ(ball.provenance->sensor, "striper");
  EXPECT_EQ(ball.provenance->scans, 7);
  EXPECT_EQ(ball.provenance->coverage, 0.925);
  EXPECT_EQ(ball.provenance->finished, Time(Seconds(1'772'368'496.25)));
  EXPECT_EQ(DateOf(*ball.provenance), "2026-03-01T12:34:56Z");  // date -d @1772368496
}

TEST(DateOf, OfASimulatedClockIsNoDate) {
  EXPECT_EQ(DateOf({.sensor = "striper", .scans = 1, .finished = Time(Seconds(83.75))}),
            "after 83 s of simulated time");
}

TEST_F(ObjectDatabaseFolder, AGivenMeshIsAllThatThereIsOfIt) {
  Add("pyramid");
  EXPECT_FALSE(ReadModel(models_ / "pyramid").provenance.has_value());
  EXPECT_EQ(ReadFullMesh(models_ / "pyramid").triangles.size(), 4U);
}

TEST_F(ObjectDatabaseFolder, AScannedObjectDoesNotReplaceAnother) {
  Add("ball");
  EXPECT_THROWS(StoreModel(Ball("ball"), models_), ConfigError,
                "ball: there is a model of this name already; remove it first");
  EXPECT_EQ(ReadModel(models_ / "ball").mesh.triangles.size(), 4U);
  EXPECT_EQ(UnusedName("object", models_), "object_1");
  StoreModel(Ball("object_1"), models_);
  EXPECT_EQ(UnusedName("object", models_), "object_2");
  EXPECT_EQ(UnusedName("object", root_ / "none"), "object_1");
}

TEST_F(ObjectDatabaseFolder, NothingIsLeftOfAModelForWhichTheDiskHadNoRoom) {
  StoreModel(Ball("first"), models_);
  {
    const FullDisk disk(60'000);  // room for the coarse mesh, not for the full one
    EXPECT_THROWS(StoreModel(Ball("second"), models_), ConfigError, "full/mesh.obj: cannot be");
  }
  EXPECT_EQ(ModelFolders(models_).size(), 1U);
  EXPECT_EQ(std::distance(fs::directory_iterator(models_), fs::directory_iterator()), 1);
  StoreModel(Ball("second"), models_);  // as soon as there is room
  EXPECT_EQ(ObjectDatabase::Load(models_).models().size(), 2U);
}

TEST_F(ObjectDatabaseFolder, RefusesAFullMeshThatHasChanged) {
  StoreModel(Ball("ball"), models_);
  Edit(models_ / "ball" / "full" / "mesh.obj", "f ", "\nf ");
  EXPECT_THROWS(ReadFullMesh(models_ / "ball"), ConfigError, "full: its files have hash");
  EXPECT_NO_THROW(ReadModel(models_ / "ball"));
}

TEST_F(ObjectDatabaseFolder, RefusesAScannedModelThatIsNone) {
  ScannedModel model = Ball("ball");
  model.provenance.scans = 0;
  EXPECT_THROWS(StoreModel(model, models_), InvalidArgument,
                "model 'ball': made from 0 scans by 'striper' with a coverage of 0.925");
  model = Ball("ball");
  model.full = {};
  EXPECT_THROWS(StoreModel(model, models_), InvalidArgument, "has no triangle");
  EXPECT_THROWS(StoreModel(Ball("a/b"), models_), ConfigError, "no plain file name");
  EXPECT_FALSE(fs::exists(models_));
}

}  // namespace
}  // namespace secondlook::world
