#include "components/pictures/camera_calibration.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::pictures {
namespace camera_calibration_test {

using testing::ElementsAre;
using testing::HasSubstr;

// As camera_calibration of ROS writes it.
constexpr const char* kRos = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/left
camera_matrix:
  rows: 3
  cols: 3
  data: [ 438.78356,    0.     ,  305.59366,
            0.     ,  437.30295,  243.73845,
            0.     ,    0.     ,    1.     ]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.000000]
rectification_matrix:
  rows: 3
  cols: 3
  data: [ 0.999978, 0.002789, -0.006046,
         -0.002816, 0.999986, -0.004401,
          0.006034, 0.004417, 0.999972]
projection_matrix:
  rows: 3
  cols: 4
  data: [ 393.653, 0.0, 322.797, -30.5,
            0.0, 393.653, 241.090, 0.0,
            0.0, 0.0, 1.0, 0.0]
)";

std::string with(const std::string& from, const std::string& to) {
  std::string text = kRos;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}
// Without the key and its indented lines.
std::string without(const std::string& key) {
  std::string text = kRos;
  const std::size_t begin = text.find(key + ":");
  std::size_t end = text.find('\n', begin) + 1;
  while (end < text.size() && text[end] == ' ') end = text.find('\n', end) + 1;
  return text.erase(begin, end - begin);
}
std::string reason(const std::string& text) {
  const auto read = read_calibration(text);
  EXPECT_FALSE(read) << text;
  if (read) return {};
  EXPECT_EQ(read.error().code(), tims::Errc::kMalformed);
  return read.error().detail();
}

TEST(CameraCalibration, ReadsFilesOfRos) {
  const auto read = read_calibration(kRos);
  ASSERT_TRUE(read) << read.error().detail();
  EXPECT_EQ(read->width, 640);
  EXPECT_EQ(read->height, 480);
  EXPECT_EQ(read->name, "narrow_stereo/left");
  EXPECT_EQ(read->camera, (CameraMatrix{438.78356, 437.30295, 305.59366, 243.73845}));
  EXPECT_THAT(read->distortion, ElementsAre(-0.361976, 0.110510, 0.001014, 0.000505, 0));
  EXPECT_EQ(read->rotation[2], -0.006046);
  EXPECT_EQ(read->rectified, (CameraMatrix{393.653, 393.653, 322.797, 241.090}));
  EXPECT_THAT(read->shift, ElementsAre(-30.5, 0, 0));
}

TEST(CameraCalibration, IsWrittenAsItIsRead) {
  for (const std::string& text :
       {std::string(kRos), with("narrow_stereo/left", "'yes: # \\ no'"),
        with("plumb_bob", "rational_polynomial")
            .replace(0, 0,
                     "distortion_coefficients: {rows: 1, cols: 8, data: [1,2,3,4,5,6,7,8]}\n")}) {
    auto read = read_calibration(text);
    if (!read) {  // the second key replaced the first
      EXPECT_THAT(read.error().detail(), HasSubstr("requires 8"));
      continue;
    }
    const std::string written = to_yaml(*read, "two lines:\n25 views");
    EXPECT_TRUE(written.starts_with("# two lines:\n# 25 views\nimage_width: 640\n"));
    const auto again = read_calibration(written);
    ASSERT_TRUE(again) << again.error().detail() << written;
    EXPECT_EQ(*again, *read) << written;
  }
}

TEST(CameraCalibration, ModelsOfLenses) {
  const std::string five = "cols: 5\n  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.000000]";
  EXPECT_THAT(read_calibration(with(five, "cols: 4\n  data: [1, 2, 3, 4]"))->distortion,
              ElementsAre(1, 2, 3, 4, 0));
  std::string eight = with(five, "cols: 8\n  data: [1, 2, 3, 4, 5, 6, 7, 8]");
  EXPECT_THAT(reason(eight), HasSubstr("plumb_bob requires 5"));
  eight.replace(eight.find("plumb_bob"), 9, "rational_polynomial");
  const auto rational = read_calibration(eight);
  ASSERT_TRUE(rational);
  EXPECT_EQ(*read_calibration(to_yaml(*rational)), *rational);
  EXPECT_THAT(reason(with("plumb_bob", "equidistant")), HasSubstr("fisheyes are not supported"));
  EXPECT_THAT(reason(with("plumb_bob", "rational_polynomial")), HasSubstr("requires 8"));
}

TEST(CameraCalibration, KeysThatMayBeMissing) {
  const auto plain = read_calibration(without("projection_matrix"));
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->rectified, plain->camera);
  EXPECT_EQ(read_calibration(without("rectification_matrix"))->rotation[0], 1);
  EXPECT_TRUE(read_calibration(without("camera_name")));
  EXPECT_TRUE(read_calibration(without("distortion_model")));
  EXPECT_TRUE(read_calibration(std::string(kRos) + "unknown: {a: [b]}\n"));
  for (const char* key :
       {"image_width", "image_height", "camera_matrix", "distortion_coefficients"})
    EXPECT_THAT(reason(without(key)), HasSubstr("no "));
}

TEST(CameraCalibration, LimitsOfSizes) {
  for (const char* width : {"1", "32766"}) {
    auto text = with("image_width: 640", std::string("image_width: ") + width);
    text.replace(text.find("305.59366"), 9, "0");
    text.replace(text.find("322.797"), 7, "0");
    EXPECT_TRUE(read_calibration(text)) << width;
  }
  for (const char* width :
       {"0", "-1", "32767", "640.5", "1e300", ".inf", "nan", "~", "[640]", "wide"})
    EXPECT_THAT(reason(with("image_width: 640", std::string("image_width: ") + width)),
                HasSubstr("line 1: image_width: must be 1 to 32766 pixels"));
  EXPECT_EQ(reason(std::string(kCalibrationFileMax + 1, ' ')),
            "more than 64 KiB: this is not the calibration of a camera");
  EXPECT_TRUE(read_calibration(with("narrow_stereo/left", std::string(100, 'x'))));
  EXPECT_THAT(reason(with("narrow_stereo/left", std::string(101, 'x'))), HasSubstr("camera_name"));
  EXPECT_THAT(reason(with("narrow_stereo/left", "Kam\xC3\xA9ra")), HasSubstr("ASCII"));
}

TEST(CameraCalibration, WrongMatricesAreNamed) {
  EXPECT_THAT(reason(with("438.78356", "0.99")),
              HasSubstr("camera_matrix: fx and fy must be 1 to"));
  EXPECT_THAT(reason(with("438.78356", "1000001")), HasSubstr("camera_matrix: fx and fy"));
  EXPECT_TRUE(read_calibration(with("438.78356", "1")));
  auto nothing = with("438.78356", "0");
  nothing.replace(nothing.find("437.30295"), 9, "0");
  EXPECT_THAT(reason(nothing), HasSubstr("the camera was not calibrated"));
  EXPECT_THAT(reason(with("305.59366", "1281")), HasSubstr("cx and cy are far outside"));
  EXPECT_TRUE(read_calibration(with("305.59366", "-1280")));
  EXPECT_THAT(reason(with("438.78356,    0.  ", "438.78356,    0.1 ")),
              HasSubstr("must be [fx, 0, cx"));
  EXPECT_THAT(reason(with("305.59366", "abc")), HasSubstr("camera_matrix: data must be finite"));
  EXPECT_THAT(reason(with("305.59366", ".nan")), HasSubstr("finite"));
  EXPECT_THAT(reason(with("305.59366,", "305.59366, 1,")),
              HasSubstr("camera_matrix: must have rows: 3, cols: 3, data: [9 numbers]"));
  EXPECT_THAT(reason(with("rows: 3", "rows: 9")), HasSubstr("must have rows: 3"));
  EXPECT_THAT(reason(with("0.999978", "0.99")), HasSubstr("is not a rotation"));
  EXPECT_THAT(reason(with("-0.361976", "-10001")), HasSubstr("are too large"));
  EXPECT_THAT(reason(with("393.653, 0.0, 322.797", "0, 0.0, 322.797")),
              HasSubstr("projection_matrix: fx and fy"));
  EXPECT_THAT(reason(with("-30.5", "-1.1e9")), HasSubstr("last column"));
}

TEST(CameraCalibration, OtherFilesAreRefused) {
  EXPECT_THAT(reason(""), HasSubstr("expected `key: value`"));
  EXPECT_THAT(reason("[1, 2]"), HasSubstr("expected `key: value`"));
  EXPECT_THAT(reason("image: map.pgm\nresolution: 0.05\n"), HasSubstr("not a calibration of ROS"));
  EXPECT_THAT(reason("a: [1\nb: 2\n"), HasSubstr("line "));
  EXPECT_THAT(reason("[a]: 1\n"), HasSubstr("line 1: expected `key: value`"));
  EXPECT_THAT(reason("&a a: *a\n"), testing::Not(testing::IsEmpty()));
  EXPECT_THAT(reason(std::string(60000, '[')), testing::Not(testing::IsEmpty()));
}

TEST(CameraCalibration, IsScaledToTheSizeOfPictures) {
  const CameraCalibration whole = *read_calibration(kRos);
  const auto half = calibration_for(whole, 320, 240);
  ASSERT_TRUE(half);
  EXPECT_DOUBLE_EQ(half->camera.fx, whole.camera.fx / 2);
  EXPECT_DOUBLE_EQ(half->rectified.fy, whole.rectified.fy / 2);
  // The middle between pixels 0 and 1 is the middle of pixel 0 of half the size.
  CameraCalibration at_half = whole;
  at_half.camera.cx = 0.5;
  EXPECT_DOUBLE_EQ(scaled(at_half, 320, 240).camera.cx, 0);
  EXPECT_EQ(half->distortion, whole.distortion);
  EXPECT_EQ(*calibration_for(whole, 640, 480), whole);
  for (const auto& [width, height] : {std::pair(101, 75), std::pair(101, 76), std::pair(1280, 960)})
    EXPECT_TRUE(calibration_for(whole, width, height)) << width << "x" << height;
  for (const auto& [width, height] : {std::pair(640, 360), std::pair(480, 640), std::pair(640, 481),
                                      std::pair(640, 479), std::pair(0, 0), std::pair(640, 0)}) {
    const auto other = calibration_for(whole, width, height);
    ASSERT_FALSE(other) << width << "x" << height;
    EXPECT_EQ(other.error().code(), tims::Errc::kInvalidArgument);
    EXPECT_THAT(other.error().detail(), HasSubstr("for pictures of 640x480 pixels"));
  }
}

}  // namespace camera_calibration_test
}  // namespace rack::pictures
