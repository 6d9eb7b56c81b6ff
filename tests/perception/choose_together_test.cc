#include "lib/perception/choose_together.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/perception/synthetic_view.h"

namespace secondlook::perception {
namespace {

const Eigen::Vector3f kGrey(0.5F, 0.5F, 0.5F);
const Eigen::Vector3f kRed(0.8F, 0.1F, 0.1F);

/// A large and a small box, and what was made of clusters of them.
class Choosing : public ::testing::Test {
 protected:
  static const std::vector<RecognitionModel>& Models() {
    static const std::vector<RecognitionModel> models =
        TrainModels(world::ObjectDatabase({MakeBoxModel("crate", {0.2, 0.12, 0.1}, kGrey, kGrey),
                                           MakeBoxModel("cube", {0.05, 0.05, 0.05}, kRed, kRed),
                                           MakeBoxModel("card", {0.2, 0.1, 0.003}, kRed, kGrey)}));
    return models;
  }

  /// `model` at (x, y) of the table, with `matching` pixels.
  static world::Hypothesis At(const char* model, double x, double y, double score, int matching) {
    world::Hypothesis h;
    h.model = model;
    h.X_CM = Upright(x, y, 0.0);
    h.score = score;
    h.verification.accepted = true;
    h.verification.matching = matching;
    return h;
  }

  static world::Detection Of(std::vector<world::Hypothesis> hypotheses) {
    world::Detection detection;
    detection.hypotheses = std::move(hypotheses);
    return detection;
  }

  static std::vector<Choice> Choose(const std::vector<world::Detection>& detections) {
    return ChooseTogether(detections, Models(), {});
  }
};

TEST_F(Choosing, KeepsThingsThatStandSideBySide) {
  const auto choices =
      Choose({Of({At("crate", 0.0, 0.0, 0.99, 5000)}), Of({At("cube", 0.128, 0.0, 0.99, 500)})});
  EXPECT_EQ(choices[0].hypothesis, 0);
  EXPECT_EQ(choices[1].hypothesis, 0);
}

TEST_F(Choosing, LetsNothingStandInSomethingBetterSeen) {
  const auto choices =
      Choose({Of({At("cube", 0.06, 0.0, 0.999, 500)}), Of({At("crate", 0.0, 0.0, 0.99, 5000)})});
  EXPECT_EQ(choices[0].hypothesis, -1);
  EXPECT_EQ(choices[0].reason, "cube (score 0.999) would stand in the crate (score 0.990)");
  EXPECT_EQ(choices[1].hypothesis, 0);
}

TEST_F(Choosing, SettlesByWhatStandsBesideItWhatIsOpenAlone) {
  // Alone, crate and cube are equally likely; the crate would stand in the one beside it.
  const std::vector<world::Detection> detections{
      Of({At("crate", 0.1, 0.0, 0.99, 500), At("cube", 0.2, 0.0, 0.985, 500)}),
      Of({At("crate", 0.0, 0.0, 0.99, 5000)})};
  EXPECT_EQ(ChooseHypotheses(detections, Models(), {})[0].hypothesis, -1);
  EXPECT_EQ(Choose(detections)[0].hypothesis, 1);
}

TEST_F(Choosing, CountsAThingCutInTwoOnce) {
  const auto choices =
      Choose({Of({At("crate", 0.0, 0.0, 0.99, 800)}), Of({At("crate", 0.003, 0.0, 0.99, 3000)})});
  EXPECT_EQ(choices[0].hypothesis, -1);
  EXPECT_EQ(choices[0].reason, "is a part of the crate beside it");
  EXPECT_EQ(choices[1].hypothesis, 0);
}

TEST_F(Choosing, CountsAThinThingSeenFromBothItsSidesOnce) {
  // 8 mm below its surface nothing of it is left that the other could stand in.
  const auto choices =
      Choose({Of({At("card", 0.0, 0.0, 0.99, 3000)}), Of({At("card", 0.002, 0.0, 0.99, 1000)})});
  EXPECT_EQ(choices[0].hypothesis, 0);
  EXPECT_EQ(choices[1].hypothesis, -1);
  EXPECT_EQ(choices[1].reason, "is a part of the card beside it");
}

TEST_F(Choosing, CountsTwoOfAKindTwice) {
  const auto choices =
      Choose({Of({At("cube", 0.0, 0.0, 0.99, 800)}), Of({At("cube", 0.052, 0.0, 0.99, 900)})});
  EXPECT_EQ(choices[0].hypothesis, 0);
  EXPECT_EQ(choices[1].hypothesis, 0);
}

}  // namespace
}  // namespace secondlook::perception
