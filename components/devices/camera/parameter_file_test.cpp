#include "components/devices/camera/parameter_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device {
namespace parameter_file_test {

TEST(ParameterFileTest, NamesAndNumbersAreTaken) {
  CameraParamData all;
  ASSERT_TRUE(
      add_parameters("f 8.5\r\nfx 812.5 pixels\n fy\t813\nk1 -1.5e-3\ncalibration_width 640\n"
                     "calibration_height 480\ne0 320.5\nremark: none\n\nsx 0.5",
                     all));
  ASSERT_TRUE(add_parameters("r1 1\nr9 -1\nt1 10\nt3 30\nr0 7\nt4 7\nrx 7\n", all));
  EXPECT_EQ(all.f, 8.5F);
  EXPECT_EQ(all.fx, 812.5F);
  EXPECT_EQ(all.fy, 813.0F);
  EXPECT_EQ(all.k1, -1.5e-3F);
  EXPECT_EQ(all.calibration_width, 640);
  EXPECT_EQ(all.calibration_height, 480);
  EXPECT_EQ(all.e0, 320.5F);
  EXPECT_EQ(all.sx, 0.5F);
  EXPECT_EQ(all.sy, 1.0F) << "not in the file";
  EXPECT_EQ(all.coordinateRotation, (std::array<f32, 9>{1, 0, 0, 0, 0, 0, 0, 0, -1}));
  EXPECT_EQ(all.coordinateTranslation[0], 10.0F);
  EXPECT_EQ(all.coordinateTranslation[2], 30.0F);
}

TEST(ParameterFileTest, ANameWithoutANumberIsReportedWithItsLine) {
  for (const char* text :
       {"f 1\nfx\nfy 1", "f 1\nfx pixels", "\nfx nan", "\nfx 1e10", "\nfx 1,5"}) {
    CameraParamData all;
    const auto added = add_parameters(text, all);
    ASSERT_FALSE(added) << text;
    EXPECT_THAT(added.error().detail(), testing::HasSubstr("line 2: \"fx\""));
  }
  CameraParamData all;
  EXPECT_TRUE(add_parameters("", all));
  EXPECT_TRUE(add_parameters("\n\n", all));
}

}  // namespace parameter_file_test
}  // namespace rack::device
