#include "lib/kinematics/calibration_file.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::kinematics {
namespace {

TEST(CalibrationFile, IsReadAsAPersonWritesIt) {
  const TemporaryFolder folder;
  WriteFile(folder / "c.yaml",
            "X_BH0: {position: [0.1, 0, 1.25]}\nX_HC: {rpy_deg: [-90, 0, -90]}\n");
  const Calibration calibration = LoadCalibration(folder / "c.yaml");
  EXPECT_EQ(calibration.head.X_BH0.translation(), Eigen::Vector3d(0.1, 0.0, 1.25));
  // The camera looks along H's x, its image's right is H's right (-y), its down H's down (-z).
  const Eigen::Matrix3d& R_HC = calibration.head.X_HC.linear();
  EXPECT_TRUE(R_HC.col(0).isApprox(-Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_TRUE(R_HC.col(1).isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(R_HC.col(2).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_FALSE(calibration.X_EC.has_value());
}

TEST(CalibrationFile, ReadsBackWhatIsWritten) {
  const TemporaryFolder folder;
  Calibration written;
  written.head = HeadCalibration::AtHeight(1.3);
  written.head.X_HC.translation() = Eigen::Vector3d(0.01, -0.02, 0.03);
  written.head.X_HC.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 3).normalized()));
  written.X_EC = Pose(Eigen::Translation3d(0.06, 0.0, 0.03));
  written.X_EL = Pose(Eigen::Translation3d(-0.06, 0.0, 0.04));
  written.residuals = CalibrationResiduals{12, 0.31, 0.4, 0.02};
  written.hand_residuals = CalibrationResiduals{60, 0.29, 0.3, 0.03};
  SaveCalibration(written, folder / "c.yaml");
  const Calibration read = LoadCalibration(folder / "c.yaml");
  EXPECT_TRUE(read.head.X_BH0.isApprox(written.head.X_BH0, 1e-9));
  EXPECT_TRUE(read.head.X_HC.isApprox(written.head.X_HC, 1e-9));
  EXPECT_TRUE(read.X_EC->isApprox(*written.X_EC, 1e-9));
  EXPECT_TRUE(read.X_EL->isApprox(*written.X_EL, 1e-9));
  EXPECT_EQ(read.residuals->views, 12);
  EXPECT_EQ(read.residuals->degrees, 0.02);
  EXPECT_EQ(read.hand_residuals->views, 60);
}

TEST(CalibrationFile, WritesSmallAnglesAsSmallOnes) {
  const TemporaryFolder folder;
  Calibration written;
  written.X_EC = Pose::Identity();
  written.X_EC->linear() = RotationFromRollPitchYaw(-0.01, 0.02, -0.03);
  SaveCalibration(written, folder / "c.yaml");
  const std::string text = ReadFile(folder / "c.yaml");
  EXPECT_NE(text.find("rpy_deg: [-0.57295"), std::string::npos) << text;
  EXPECT_TRUE(LoadCalibration(folder / "c.yaml").X_EC->isApprox(*written.X_EC, 1e-9));
}

TEST(CalibrationFile, NamesWhatIsMissingOrWrong) {
  const TemporaryFolder folder;
  const auto refuses = [&](const std::string& text, const std::string& why) {
    WriteFile(folder / "c.yaml", text);
    EXPECT_THROWS(LoadCalibration(folder / "c.yaml"), ConfigError, why);
    EXPECT_THROWS(LoadCalibration(folder / "c.yaml"), ConfigError, (folder / "c.yaml").string());
  };
  refuses("X_BH0: {}\n", "'X_HC' is missing: the camera in the pan-tilt head");
  refuses("X_HC: {}\n", "'X_BH0' is missing: the pan-tilt head's mount in the base");
  refuses("X_BH0: {position: [0, 0, 1250]}\nX_HC: {}\n", "no robot is: give metres");
  refuses("X_BH0: {}\nX_HC: {}\nX_CE: {}\n", "unknown key 'X_CE'");
  EXPECT_THROWS(LoadCalibration(folder / "none.yaml"), ConfigError, "none.yaml");
}

}  // namespace
}  // namespace secondlook::kinematics
