#include "lib/planning/aspect_graph.h"
#include "lib/planning/choose_look.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/parallel.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using secondlook::testing::LookingAt;
using world::VoxelSpace;

constexpr double kPi = std::numbers::pi;
constexpr geometry::CameraModel kCamera{640, 480, 577.0, 577.0, 319.5, 239.5};
const Vector3d kTarget(0.0, 0.0, 0.85);

/// Cameras on a circle of `radius` around the target, 1.2 m high.
std::vector<world::Look> Ring(int count, double radius = 1.2) {
  std::vector<world::Look> looks(count);
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * i / count;
    looks[i].X_WC = LookingAt({radius * std::cos(angle), radius * std::sin(angle), 1.2}, kTarget);
    looks[i].seconds = 2.0;
    looks[i].feasible = true;
  }
  return looks;
}

/// A space in which everything around the target is free.
VoxelSpace FreeSpace() {
  VoxelSpace space;
  space.ClearBox(AlignedBox3d(Vector3d(-1.4, -1.4, 0.7), Vector3d(1.4, 1.4, 1.3)));
  return space;
}

struct Model {
  explicit Model(geometry::Mesh m) : mesh(std::move(m)), caster(mesh) {}

  PosedModel At(const Vector3d& p_WM, double yaw = 0.0, double belief = 0.5) const {
    Pose X_WM = Pose::Identity();
    X_WM.linear() = RotationFromRollPitchYaw(0, 0, yaw);
    X_WM.translation() = p_WM;
    return {&mesh, &caster, X_WM, belief, 0.9};
  }

  geometry::Mesh mesh;
  geometry::RayCaster caster;
};

const Vector3f kGrey = Vector3f::Constant(0.5F);

AspectTarget BoxTarget(const Vector3d& size) {
  AspectTarget target;
  target.id = 3;
  target.box_W = AlignedBox3d(kTarget - 0.5 * size, kTarget + 0.5 * size);
  return target;
}

AspectGraph Score(const VoxelSpace& space, const AspectTarget& target,
                  std::vector<world::Look> looks, const AspectGraphConfig& config = {}) {
  Rng rng(1);
  return ScoreAspectGraph(space, kCamera, target, std::move(looks), &rng, config);
}

TEST(AspectGraph, InFreeSpaceAllRaysToABoxOfTheModelsSizeHitIt) {
  const Vector3d size(0.1, 0.2, 0.15);
  const Model box(geometry::MakeBox(size, kGrey));
  AspectTarget target = BoxTarget(size);
  target.hypotheses = {box.At(kTarget)};
  const VoxelSpace space = FreeSpace();
  const AspectGraph graph = Score(space, target, Ring(8));
  for (int i = 0; i < 8; ++i) {
    const AspectScore& score = graph.scores[i];
    EXPECT_GT(score.box_rays, 100);
    EXPECT_EQ(score.blocked, 0.0);
    EXPECT_NEAR(score.surviving, 1.0, 1e-12);
    EXPECT_NEAR(score.models[0].box_share, 1.0, 0.02);
    EXPECT_NEAR(score.models[0].view_share, score.box_rays / (160.0 * 120.0), 0.001);
    EXPECT_NEAR(graph.looks[i].visibility, score.models[0].box_share, 1e-12);
    // Half believed, and all that is left to see of it seen: most of the loss of 1 goes.
    EXPECT_GT(graph.looks[i].gain, 0.6);
    EXPECT_LT(graph.looks[i].gain, 1.0);
    EXPECT_GE(graph.looks[i].score, graph.looks[i].gain / 7.0 - 1e-12);
    EXPECT_TRUE(graph.looks[i].feasible);
  }
  // From +x: the face of 0.2 m x 0.15 m and the top of 0.1 m x 0.2 m.
  EXPECT_NEAR(graph.scores[0].models[0].area, 0.2 * 0.15 + 0.1 * 0.2, 0.005);
  // From +y: the face of 0.1 m x 0.15 m and the top.
  EXPECT_NEAR(graph.scores[2].models[0].area, 0.1 * 0.15 + 0.1 * 0.2, 0.004);
}

TEST(AspectGraph, AWallTakesTheRaysFromItsSideAlone) {
  const Vector3d size(0.1, 0.1, 0.1);
  const Model box(geometry::MakeBox(size, kGrey));
  AspectTarget target = BoxTarget(size);
  target.hypotheses = {box.At(kTarget)};
  VoxelSpace space = FreeSpace();
  std::vector<Vector3d> wall;
  for (double y = -0.3; y <= 0.3; y += 0.01) {
    for (double z = 0.75; z <= 1.2; z += 0.01) wall.emplace_back(0.3, y, z);
  }
  space.MarkOccupied(wall);
  AspectGraph graph = Score(space, target, Ring(4));
  EXPECT_EQ(graph.scores[0].blocked, 1.0);
  EXPECT_FALSE(graph.looks[0].feasible);
  EXPECT_THAT(graph.looks[0].reason, ::testing::HasSubstr("visible: 0 % of"));
  for (int i = 1; i < 4; ++i) {
    EXPECT_EQ(graph.scores[i].blocked, 0.0);
    EXPECT_TRUE(graph.looks[i].feasible);
  }
  const LookChoice choice = ChooseLook(&graph.looks);
  EXPECT_EQ(choice.index, 1);
  EXPECT_THAT(choice.reason, ::testing::HasSubstr("1 of 4 refused: 1 visible"));
}

TEST(AspectGraph, AThinThingFillsLittleOfItsBoxAndIsSeenAllTheSame) {
  // A rod along the diagonal of its box, seen across.
  const Model rod(geometry::MakeBox({0.4, 0.008, 0.008}, kGrey));
  AspectTarget target = BoxTarget(Vector3d::Constant(0.235));
  target.hypotheses = {rod.At(kTarget)};
  target.hypotheses[0].X_WM.linear() =
      RotationFromRollPitchYaw(0.0, std::asin(1.0 / std::sqrt(3.0)), kPi / 4.0);
  const AspectGraph graph = Score(FreeSpace(), target, Ring(8));
  for (const int i : {3, 7}) {
    EXPECT_LT(graph.looks[i].visibility, AspectGraphConfig().min_visibility);
    EXPECT_NEAR(graph.scores[i].models[0].seen, 1.0, 1e-12);
    EXPECT_TRUE(graph.looks[i].feasible) << graph.looks[i].reason;
  }
}

TEST(AspectGraph, HalfAWallTakesHalfOfTheRays) {
  const Vector3d size(0.1, 0.2, 0.1);
  AspectTarget target = BoxTarget(size);
  VoxelSpace space = FreeSpace();
  std::vector<Vector3d> wall;
  for (double y = 0.01; y <= 0.4; y += 0.02) {
    for (double z = 0.75; z <= 1.2; z += 0.01) wall.emplace_back(0.61, y, z);
  }
  space.MarkOccupied(wall);
  const AspectGraph graph = Score(space, target, Ring(1));
  EXPECT_NEAR(graph.scores[0].blocked, 0.5, 0.03);
  EXPECT_NEAR(graph.looks[0].visibility, 0.5, 0.03);
}

TEST(AspectGraph, FewerRaysTellHowMuchOfARegionIsVisible) {
  AspectTarget region = BoxTarget({0.1, 0.4, 0.12});
  region.id = -1;
  VoxelSpace space = FreeSpace();
  // Half way to the region, in voxels of 20 mm: from y = -0.04 on it hides what lies beyond -0.08.
  std::vector<Vector3d> wall;
  for (double y = -0.03; y <= 0.4; y += 0.01) {
    for (double z = 0.75; z <= 1.2; z += 0.01) wall.emplace_back(0.61, y, z);
  }
  space.MarkOccupied(wall);
  const AspectGraph few = Score(space, region, Ring(1));
  AspectGraphConfig config;
  config.region_ray_columns = config.ray_columns;
  const AspectGraph many = Score(space, region, Ring(1), config);
  EXPECT_NEAR(few.looks[0].visibility, 0.3, 0.03);
  EXPECT_NEAR(few.looks[0].visibility, many.looks[0].visibility, 0.02);
  EXPECT_LT(4 * few.scores[0].box_rays, 1.1 * many.scores[0].box_rays);
}

TEST(AspectGraph, UnknownSpaceCountsAsProbablyOccludedForUsAndFreeForThePaper) {
  const Vector3d size(0.1, 0.1, 0.1);
  const Model box(geometry::MakeBox(size, kGrey));
  AspectTarget target = BoxTarget(size);
  target.hypotheses = {box.At(kTarget)};
  VoxelSpace space = FreeSpace();
  space.RemoveRegion(AlignedBox3d(Vector3d(0.3, -1, 0.7), Vector3d(0.6, 1, 1.3)));
  const AspectGraph graph = Score(space, target, Ring(2));
  EXPECT_EQ(graph.scores[0].through_unknown, 1.0);
  EXPECT_NEAR(graph.scores[0].models[0].box_share, 0.5, 0.02);
  EXPECT_EQ(graph.scores[1].through_unknown, 0.0);
  EXPECT_NEAR(graph.scores[1].models[0].box_share, 1.0, 0.03);
  EXPECT_NEAR(graph.scores[0].view_score, graph.scores[1].view_score, 1e-4);
}

TEST(AspectGraph, ThePapersChoiceIsTheViewOfTheLargestFace) {
  const Vector3d size(0.05, 0.25, 0.2);  // a book that faces +x and -x
  const Model book(geometry::MakeBox(size, kGrey));
  AspectTarget target = BoxTarget(size);
  target.hypotheses = {book.At(kTarget)};
  AspectGraphConfig config;
  config.strategy = "McGreavy";
  const VoxelSpace space = FreeSpace();
  std::vector<world::Look> looks = Ring(12);
  looks[3].seconds = 0.1;  // the spine at once, which the paper does not care about
  AspectGraph graph = Score(space, target, looks, config);
  const LookChoice choice = ChooseLook(&graph.looks);
  ASSERT_TRUE(choice.index.has_value());
  EXPECT_TRUE(*choice.index == 0 || *choice.index == 6) << *choice.index;
  EXPECT_TRUE(graph.looks[*choice.index].chosen);
  EXPECT_THAT(choice.reason, ::testing::HasSubstr("none of 12 refused"));
}

TEST(AspectGraph, SeveralHypothesesScoreTheirSumMinusTheirDifferences) {
  const Vector3d size(0.2, 0.2, 0.2);
  const Model large(geometry::MakeBox(size, kGrey));
  const Model small(geometry::MakeBox({0.1, 0.1, 0.1}, kGrey));
  AspectTarget target = BoxTarget(size);
  target.hypotheses = {large.At(kTarget), small.At(kTarget)};
  const VoxelSpace space = FreeSpace();
  const AspectScore score = Score(space, target, Ring(1)).scores[0];
  const double a = score.models[0].view_share;
  const double b = score.models[1].view_share;
  EXPECT_GT(a, 2.0 * b);
  EXPECT_NEAR(score.view_score, 2.0 * b, 1e-12);  // a + b - |a - b|
}

/// Two boxes alike but for a knob on the +y side of one.
struct Twins {
  Vector3d size{0.12, 0.12, 0.16};
  Model plain{geometry::MakeBox(size, kGrey)};
  Model knobbed{[this] {
    geometry::Mesh mesh = geometry::MakeBox(size, kGrey);
    const geometry::Mesh knob = geometry::MakeBox({0.04, 0.05, 0.04}, kGrey);
    const int offset = static_cast<int>(mesh.vertices.size());
    for (const Vector3f& v : knob.vertices) mesh.vertices.push_back(v + Vector3f(0, 0.08F, 0));
    for (const Eigen::Vector3i& t : knob.triangles) {
      mesh.triangles.push_back(t + Eigen::Vector3i::Constant(offset));
    }
    mesh.triangle_material.assign(mesh.triangles.size(), 0);
    if (!mesh.vertex_colors.empty()) mesh.vertex_colors.resize(mesh.vertices.size(), kGrey);
    if (!mesh.uv.empty()) mesh.uv.resize(mesh.vertices.size(), Eigen::Vector2f::Zero());
    return mesh;
  }()};

  AspectTarget Target() const {
    AspectTarget target;
    target.id = 3;
    target.box_W =
        AlignedBox3d(kTarget - Vector3d(0.06, 0.06, 0.08), kTarget + Vector3d(0.06, 0.105, 0.08));
    target.hypotheses = {plain.At(kTarget), knobbed.At(kTarget)};
    return target;
  }
};

TEST(AspectGraph, LookAlikesAreToldApartWhereTheyDiffer) {
  const Twins twins;
  const VoxelSpace space = FreeSpace();
  AspectGraph graph = Score(space, twins.Target(), Ring(12));
  // From -y the knob is hidden; from +y it stands 5 cm nearer; from the side it is seen in profile.
  EXPECT_NEAR(graph.scores[9].difference, 0.0, 1e-12);
  EXPECT_NEAR(graph.looks[9].score, 0.0, 1e-12);
  EXPECT_GT(graph.scores[3].difference, 0.05);
  EXPECT_GT(graph.scores[0].difference, 0.05);
  const LookChoice choice = ChooseLook(&graph.looks);
  ASSERT_TRUE(choice.index.has_value());
  EXPECT_GT(graph.looks[*choice.index].X_WC.translation().y(), -0.1);
  // The paper's compromise has no preference for the knob's side.
  EXPECT_NEAR(graph.scores[9].view_score, graph.scores[3].view_score,
              0.2 * graph.scores[9].view_score);
}

TEST(AspectGraph, ALookIsWorthWhatItSettlesAndNothingWhereAllLookAlike) {
  Twins twins;
  AspectTarget target = twins.Target();
  target.hypotheses[0].belief = target.hypotheses[1].belief = 0.5;  // surely one of the two
  const VoxelSpace space = FreeSpace();
  const AspectGraph graph = Score(space, target, Ring(12));
  EXPECT_NEAR(graph.looks[9].gain, 0.0, 1e-9);
  EXPECT_GT(graph.looks[3].gain, 0.3);
  EXPECT_FALSE(graph.looks[9].feasible && graph.looks[9].score > graph.looks[3].score);
}

TEST(AspectGraph, ALookThatBringsLessThanItsTimeCostsIsRefused) {
  const Vector3d size(0.1, 0.1, 0.1);
  const Model box(geometry::MakeBox(size, kGrey));
  AspectTarget target = BoxTarget(size);
  target.hypotheses = {box.At(kTarget)};
  std::vector<world::Look> looks = Ring(2);
  looks[1].seconds = 1000.0;
  AspectGraphConfig config;
  config.look_ahead.firsts = 0;
  config.loss.per_second = 0.01;
  const VoxelSpace space = FreeSpace();
  const AspectGraph graph = Score(space, target, looks, config);
  EXPECT_TRUE(graph.looks[0].feasible);
  EXPECT_FALSE(graph.looks[1].feasible);
  EXPECT_THAT(graph.looks[1].reason, ::testing::HasSubstr("worth its time: "));
  EXPECT_THAT(graph.looks[1].reason, ::testing::HasSubstr("at least 0.01 wanted"));
}

TEST(AspectGraph, AViewThatShowsAThingAsRimAloneIsNoEvidenceForIt) {
  const auto evidence = [](const Vector3d& size) {
    const Model thing(geometry::MakeBox(size, kGrey));
    AspectTarget target = BoxTarget({0.3, 0.3, 0.1});
    target.hypotheses = {thing.At(kTarget, 0.4)};
    return Score(FreeSpace(), target, Ring(4)).scores[1].prospects.at(0).evidence;
  };
  const Eigen::MatrixXd of_box = evidence({0.2, 0.1, 0.1});
  EXPECT_NEAR(of_box(0, 1), of_box(1, 0), 0.02 * of_box(1, 0));
  const Eigen::MatrixXd of_wire = evidence({0.3, 0.002, 0.002});  // 1 pixel
  EXPECT_GT(of_wire(1, 0), 0.0) << "against it";
  EXPECT_LT(of_wire(0, 1), 1e-3 * of_wire(1, 0));
}

TEST(AspectGraph, TwinsOfDifferentColourDifferEverywhere) {
  const Vector3d size(0.1, 0.1, 0.1);
  const Model red(geometry::MakeBox(size, {0.8F, 0.1F, 0.1F}));
  const Model blue(geometry::MakeBox(size, {0.1F, 0.1F, 0.8F}));
  const Model reddish(geometry::MakeBox(size, {0.7F, 0.1F, 0.1F}));
  AspectTarget target = BoxTarget(size);
  const VoxelSpace space = FreeSpace();
  target.hypotheses = {red.At(kTarget), blue.At(kTarget)};
  EXPECT_NEAR(Score(space, target, Ring(1)).scores[0].difference, 1.0, 1e-12);
  target.hypotheses = {red.At(kTarget), reddish.At(kTarget)};
  EXPECT_NEAR(Score(space, target, Ring(1)).scores[0].difference, 0.0, 1e-12);
  // A pair nobody believes in does not count: 0.5 0.5 of the pairs (0, 2) alone.
  target.hypotheses = {red.At(kTarget), blue.At(kTarget, 0.0, 0.0), reddish.At(kTarget)};
  EXPECT_NEAR(Score(space, target, Ring(1)).scores[0].difference, 0.0, 1e-12);
}

TEST(AspectGraph, ADirectionThatDidNotHelpIsNoNews) {
  const Vector3d size(0.1, 0.1, 0.1);
  const Model box(geometry::MakeBox(size, kGrey));
  AspectTarget target = BoxTarget(size);
  target.hypotheses = {box.At(kTarget)};
  const std::vector<world::Look> looks = Ring(36);
  target.seen_from_W = {(looks[0].X_WC.translation() - kTarget).normalized()};
  const VoxelSpace space = FreeSpace();
  AspectGraph graph = Score(space, target, looks);
  EXPECT_NEAR(graph.scores[0].novelty, 0.1, 1e-12);
  EXPECT_NEAR(graph.scores[1].novelty, 0.1, 1e-12);  // 10 degrees of azimuth
  EXPECT_GT(graph.scores[4].novelty, 0.5);
  EXPECT_NEAR(graph.scores[6].novelty, 1.0, 1e-12);
  // Without a model a direction has to be farther away to be new.
  target.hypotheses.clear();
  graph = Score(space, target, looks);
  EXPECT_LT(graph.scores[6].novelty, 0.6);
  EXPECT_NEAR(graph.scores[18].novelty, 1.0, 1e-12);
  EXPECT_NEAR(graph.looks[18].visibility, 1.0, 1e-12);
}

TEST(AspectGraph, ANearerLookWinsWhereBothSeeTheSame) {
  const Vector3d size(0.1, 0.1, 0.1);
  const Model box(geometry::MakeBox(size, kGrey));
  AspectTarget target = BoxTarget(size);
  target.hypotheses = {box.At(kTarget)};
  std::vector<world::Look> looks = Ring(4);
  looks[2].seconds = 1.0;
  looks[3].feasible = false;
  looks[3].checks = {{"collision", false, "with the map"}};
  looks[3].reason = "collision: with the map";
  const VoxelSpace space = FreeSpace();
  AspectGraph graph = Score(space, target, looks);
  EXPECT_EQ(graph.scores[3].box_rays, 0);
  const LookChoice choice = ChooseLook(&graph.looks);
  EXPECT_EQ(choice.index, 2);
  EXPECT_THAT(choice.reason, ::testing::HasSubstr("sees 100 % of the rays to the box"));
  EXPECT_THAT(choice.reason, ::testing::HasSubstr("1.0 s and 0.00 m to drive"));
  EXPECT_THAT(choice.reason, ::testing::HasSubstr("times the next"));
  EXPECT_THAT(choice.reason, ::testing::HasSubstr("1 of 4 refused: 1 collision"));
  EXPECT_EQ(graph.looks[3].reason, "collision: with the map");
}

TEST(AspectGraph, BaselinesChooseByTheirOwnRule) {
  const Vector3d size(0.1, 0.1, 0.1);
  AspectTarget target = BoxTarget(size);
  std::vector<world::Look> looks = Ring(12);
  for (int i = 0; i < 12; ++i) looks[i].seconds = 1.0 + (i + 5) % 12;
  target.seen_from_W = {(looks[2].X_WC.translation() - kTarget).normalized()};
  const VoxelSpace space = FreeSpace();
  AspectGraphConfig config;
  config.strategy = "nearest";
  AspectGraph graph = Score(space, target, looks, config);
  EXPECT_EQ(ChooseLook(&graph.looks).index, 7);
  config.strategy = "fixed step";
  graph = Score(space, target, looks, config);
  EXPECT_EQ(ChooseLook(&graph.looks).index, 8);
  config.fixed_step_deg = 90.0;
  graph = Score(space, target, looks, config);
  EXPECT_EQ(ChooseLook(&graph.looks).index, 5);
  config.strategy = "random";
  std::vector<int> chosen(12);
  Rng rng(5);
  Rng again(5);
  for (int i = 0; i < 200; ++i) {
    graph = ScoreAspectGraph(space, kCamera, target, looks, &rng, config);
    const int index = ChooseLook(&graph.looks).index.value_or(-1);
    graph = ScoreAspectGraph(space, kCamera, target, looks, &again, config);
    EXPECT_EQ(ChooseLook(&graph.looks).index, index);
    ++chosen.at(index);
  }
  for (const int count : chosen) EXPECT_GT(count, 3);
}

TEST(AspectGraph, IsTheSameForAnyNumberOfThreads) {
  const Twins twins;
  const VoxelSpace space = FreeSpace();
  std::vector<double> scores[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    for (const world::Look& look : Score(space, twins.Target(), Ring(38)).looks) {
      scores[threads - 1].push_back(look.score);
    }
  }
  EXPECT_EQ(scores[0], scores[1]);
}

TEST(ChooseLook, SaysWhyThereIsNone) {
  std::vector<world::Look> looks(38);
  for (int i = 0; i < 38; ++i) {
    looks[i].checks = {{"pan-tilt limits", i != 0, ""}};
    if (i > 0) looks[i].checks.push_back({"collision", i > 20, ""});
    if (i > 20) looks[i].checks.push_back({"path", false, ""});
  }
  const LookChoice choice = ChooseLook(&looks);
  EXPECT_FALSE(choice.index.has_value());
  EXPECT_EQ(choice.reason, "38 of 38 refused: 20 collision, 17 path, 1 pan-tilt limits");
  looks.clear();
  EXPECT_EQ(ChooseLook(&looks).reason, "there are no candidates");
}

TEST(AspectGraph, ATargetUnderTheTableIsSeenFromNowhere) {
  VoxelSpace space = FreeSpace();
  std::vector<Vector3d> top;
  for (double x = -0.6; x <= 0.6; x += 0.01) {
    for (double y = -0.6; y <= 0.6; y += 0.01) top.emplace_back(x, y, 0.95);
  }
  space.MarkOccupied(top);
  AspectGraph graph = Score(space, BoxTarget({0.1, 0.1, 0.1}), Ring(8, 0.9));
  EXPECT_FALSE(ChooseLook(&graph.looks).index.has_value());
  for (const world::Look& look : graph.looks) {
    EXPECT_THAT(look.reason, ::testing::StartsWith("visible: 0 % of "));
    EXPECT_THAT(look.reason, ::testing::HasSubstr("(100 % blocked"));
  }
}

TEST(AspectGraph, RefusesBadInput) {
  const Model box(geometry::MakeBox({0.1, 0.1, 0.1}, kGrey));
  const VoxelSpace space;
  AspectTarget target = BoxTarget({0.1, 0.1, 0.1});
  target.hypotheses = {box.At({NAN, 0, 0})};
  EXPECT_THROWS(Score(space, target, Ring(1)), InvalidArgument, "X_WM of hypothesis 0 of target 3");
  target.hypotheses = {PosedModel{}};
  EXPECT_THROWS(Score(space, target, Ring(1)), InvalidArgument, "has no mesh");
  target.hypotheses = {box.At(kTarget, 0.0, -1.0)};
  EXPECT_THROWS(Score(space, target, Ring(1)), InvalidArgument, "with belief -1");
  target.hypotheses = {box.At(kTarget, 0.0, 0.8), box.At(kTarget, 0.0, 0.4)};
  EXPECT_THROWS(Score(space, target, Ring(1)), InvalidArgument, "sum to 1.2");
  EXPECT_THROWS(Score(space, BoxTarget({0.0, 0.0, 0.0}), Ring(1)), InvalidArgument,
                "the box of target 3");
  EXPECT_THROWS(Score(space, BoxTarget({NAN, 0.1, 0.1}), Ring(1)), InvalidArgument,
                "at least 1 mm wide");
  target = BoxTarget({0.1, 0.1, 0.1});
  target.seen_from_W = {Vector3d(2, 0, 0)};
  EXPECT_THROWS(Score(space, target, Ring(1)), InvalidArgument, "is no unit vector");
  AspectGraphConfig config;
  config.strategy = "best";
  EXPECT_THROWS(config.Validate(), ConfigError,
                "strategy 'best' is none of 'expected loss', 'McGreavy'");
  config = {};
  config.unknown_survival = 1.5;
  EXPECT_THROWS(config.Validate(), ConfigError, "unknown_survival = 1.5 must lie in 0..1");
  config = {};
  config.region_ray_columns = 4;
  EXPECT_THROWS(config.Validate(), ConfigError, "region_ray_columns = 4 must lie in 8..4096");
}

TEST(AspectGraph, AnEmptyListOfCandidatesIsNoError) {
  const VoxelSpace space;
  AspectGraph graph = Score(space, BoxTarget({0.1, 0.1, 0.1}), {});
  EXPECT_TRUE(graph.looks.empty());
  EXPECT_FALSE(ChooseLook(&graph.looks).index.has_value());
}

}  // namespace
}  // namespace secondlook::planning
