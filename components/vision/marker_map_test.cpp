#include "components/vision/marker_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack::vision {
namespace marker_map_test {

using testing::HasSubstr;

std::vector<Marker> read(const std::string& text) {
  MarkerFile file = read_marker_map({"markers.toml", text});
  for (const auto& problem : file.problems) ADD_FAILURE() << problem.to_string();
  return file.markers;
}
std::string problem_of(const std::string& text) {
  const MarkerFile file = read_marker_map({"markers.toml", text});
  return file.problems.empty() ? "it was read" : file.problems.front().to_string();
}

TEST(MarkerMap, HasMarkersWithDefaults) {
  const auto markers = read(
      "size = 200\nheight = 1400\n"
      "[[marker]]\nid = 3\nat = [1000, -250.5, 90]\n"
      "[[marker]]\nid = 4\nat = [0, 0, -90]\nheight = 900\nsize = 80\nfamily = \"tag16h5\"\n");
  ASSERT_EQ(markers.size(), 2U);
  EXPECT_EQ(markers[0].family, Family::kTag36h11);
  EXPECT_EQ(markers[0].id, 3);
  EXPECT_EQ(markers[0].at.x, 1000);
  EXPECT_EQ(markers[0].at.y, -250.5);
  EXPECT_NEAR(markers[0].rho, kPi / 2, 1e-9);
  EXPECT_EQ(markers[0].height, 1400);
  EXPECT_EQ(markers[0].size, 200);
  EXPECT_NEAR(markers[1].rho, 3 * kPi / 2, 1e-9);
  EXPECT_EQ(markers[1].height, 900);
  EXPECT_EQ(markers[1].size, 80);
  EXPECT_TRUE(read("").empty());
}

TEST(MarkerMap, DefaultsMayFollowInTheFileOfAnotherProgram) {
  EXPECT_EQ(read("marker = [{ id = 1, at = [0, 0, 0] }]\nsize = 99\n").at(0).size, 99);
}

TEST(MarkerMap, ReportsWhatIsWrongAndWhere) {
  const std::string at = "at = [0, 0, 0]\n";
  EXPECT_THAT(problem_of("size = 9"), HasSubstr("markers.toml:1:"));
  EXPECT_THAT(problem_of("size = 5001"), HasSubstr("markers.toml:1:"));
  EXPECT_THAT(problem_of("sice = 100"), HasSubstr("size"));
  EXPECT_THAT(problem_of("family = \"tag36h10\""), HasSubstr("tag36h11"));
  EXPECT_THAT(problem_of("[[marker]]\nid = 1\n"), HasSubstr("needs `at"));
  EXPECT_THAT(problem_of("[[marker]]\nid = 1\nat = [0, 0]\n"), HasSubstr("[x, y, direction]"));
  EXPECT_THAT(problem_of("[[marker]]\n" + at), HasSubstr("from 0 to 586"));
  EXPECT_THAT(problem_of("[[marker]]\nid = 587\n" + at), HasSubstr("from 0 to 586"));
  EXPECT_THAT(problem_of("[[marker]]\nid = 1\n" + at + "[[marker]]\nid = 1\n" + at),
              HasSubstr("looks the same"));
  EXPECT_THAT(problem_of("[[marker]\n"), HasSubstr("markers.toml:1:"));
}

TEST(MarkerMap, HasLimits) {
  EXPECT_EQ(read("size = 10\n[[marker]]\nid = 586\nat = [1e7, -1e7, 360]\n").at(0).id, 586);
  EXPECT_EQ(read("size = 5000\n[[marker]]\nid = 0\nat = [0, 0, 0]\n").at(0).size, 5000);
}

}  // namespace marker_map_test
}  // namespace rack::vision
