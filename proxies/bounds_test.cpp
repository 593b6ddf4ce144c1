// Every sequence at its limit: one element less, the maximum, one more; encoded and decoded in both
// byte orders. Also the lengths that follow from other fields.
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rack/proxies/camera.h"
#include "rack/proxies/datalog.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/gdos_log.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/io.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/planner.h"
#include "rack/proxies/scan2d.h"
#include "rack/proxies/scan3d.h"

namespace rack {
namespace bounds_test {

using tims::Errc;

template <typename T>
std::vector<std::byte> encoded(const T& value, std::endian order) {
  std::vector<std::byte> body(encoded_size(value));
  const auto size = encode(value, body, order);
  EXPECT_TRUE(size) << size.error().message();
  return body;
}

template <typename T>
Errc refusal(const T& value) {
  std::vector<std::byte> body(encoded_size(value));
  const auto size = encode(value, body);
  return size ? Errc::kEmpty : size.error().code();
}

// A message with one sequence, which begins directly after its count.
template <typename T>
struct WithSequence {
  using Message = T;
  static constexpr std::size_t kSequence = reflect::kFieldCount<T> - 1;
  static constexpr std::size_t kMax = reflect::Field<T, kSequence>::kMax;

  static T of(std::size_t count) {
    T value{};
    boost::pfr::get<kSequence>(value).resize(count);
    return value;
  }
  static std::size_t count(const T& value) { return boost::pfr::get<kSequence>(value).size(); }
};

template <typename T>
class BoundsTest : public testing::Test {};
using Messages =
    testing::Types<ParameterList, ParameterEffects, RuntimeData, ListenersData, DescriptionPage,
                   LadarData, Scan2dData, PilotData, PilotMultiDestData, PathData, PathRddfData,
                   FeatureMapData, FeatureMapLayerData, FileName, MclData, ObjRecogData, IoData,
                   DatalogData, PlannerData, PlannerCommand, GdosData, GdosTexts>;
TYPED_TEST_SUITE(BoundsTest, Messages);

TYPED_TEST(BoundsTest, UpToTheLimitAndNotBeyond) {
  using With = WithSequence<TypeParam>;
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    for (const std::size_t count : {std::size_t{0}, With::kMax - 1, With::kMax}) {
      const auto again = decode<TypeParam>(encoded(With::of(count), order), order);
      ASSERT_TRUE(again) << again.error().message();
      EXPECT_EQ(With::count(*again), count);
    }
  }
  EXPECT_EQ(refusal(With::of(With::kMax + 1)), Errc::kInvalidArgument);
}

TYPED_TEST(BoundsTest, ACountThatLiesIsRefused) {
  using With = WithSequence<TypeParam>;
  constexpr std::size_t kCountAt = wire_size<TypeParam>() - 4;
  for (const std::int64_t lie : {std::int64_t{With::kMax} + 1, std::int64_t{-1},
                                 std::int64_t{std::numeric_limits<i32>::max()},
                                 std::int64_t{std::numeric_limits<i32>::min()}}) {
    // With all bytes that such a count would need, up to the size of the buffer.
    std::vector<std::byte> body(body_max<TypeParam>() + 1000);
    bytes::write(&body[kCountAt], std::endian::big, static_cast<i32>(lie));
    const auto again = decode<TypeParam>(body, std::endian::big);
    ASSERT_FALSE(again);
    EXPECT_EQ(again.error().code(), Errc::kMalformed);
    EXPECT_NE(again.error().detail().find(" is " + std::to_string(lie) + ", allowed are"),
              std::string::npos)
        << again.error().message();
  }
}

TYPED_TEST(BoundsTest, NoMoreMemoryThanThereAreBytes) {
  using With = WithSequence<TypeParam>;
  std::vector<std::byte> body(wire_size<TypeParam>());
  bytes::write(&body[body.size() - 4], std::endian::little, static_cast<i32>(With::kMax));
  TypeParam into{};
  EXPECT_FALSE(decode(body, std::endian::little, into));
  EXPECT_EQ(boost::pfr::get<With::kSequence>(into).capacity(), 0U);
}

TEST(Bounds, CameraImage) {
  CameraData camera = {.width = 1280, .height = 1024, .depth = 24};
  camera.image.resize(std::size_t{1280} * 1024 * 3);
  EXPECT_TRUE(decode<CameraData>(encoded(camera, std::endian::big), std::endian::big));
  camera.depth = 32;
  camera.image.resize(std::size_t{1280} * 1024 * 4);
  EXPECT_EQ(refusal(camera), Errc::kInvalidArgument);
  camera.image.resize(1);
  EXPECT_EQ(refusal(camera), Errc::kInvalidArgument);
}

TEST(Bounds, CameraJpegHasTheStatedLength) {
  CameraData camera = {.width = 640, .height = 480, .depth = 24, .mode = camera_mode::kJpeg};
  camera.colorFilterId = 3;
  camera.image.resize(3);
  const auto again = decode<CameraData>(encoded(camera, std::endian::big), std::endian::big);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->image.size(), 3U);
}

TEST(Bounds, GridMapCells) {
  for (const auto& [x, y, good] :
       {std::tuple(500, 500, true), std::tuple(499, 500, true), std::tuple(501, 500, false),
        std::tuple(-5, -5, false), std::tuple(0x7FFFFFFF, 0x7FFFFFFF, false)}) {
    std::vector<std::byte> body(24 + 250500);
    bytes::write(&body[16], std::endian::little, x);
    bytes::write(&body[20], std::endian::little, y);
    if (good) body.resize(24 + static_cast<std::size_t>(x * y));
    EXPECT_EQ(decode<GridMapData>(body, std::endian::little).ok(), good) << x << " " << y;
  }
}

TEST(Bounds, Scan3dPointsOrTheirCompressedForm) {
  Scan3dData scan = {.pointNum = 2, .points = Tail<ScanPoint, kScan3dPointsMax>(2)};
  EXPECT_EQ(encoded(scan, std::endian::little).size(), 68U + 40);
  scan.compressed = 7;
  EXPECT_EQ(refusal(scan), Errc::kInvalidArgument);
  scan.points.clear();
  scan.compressedPoints.resize(7);
  const auto again = decode<Scan3dData>(encoded(scan, std::endian::big), std::endian::big);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->pointNum, 2);
  EXPECT_EQ(again->compressedPoints.size(), 7U);
  scan.compressed = -1;
  EXPECT_EQ(refusal(scan), Errc::kInvalidArgument);
}

TEST(Bounds, RangeImageWithAndWithoutJavasSurplus) {
  Scan3dRangeImageData image = {.scanNum = 2, .scanPointNum = 3};
  image.points.resize(6);
  std::vector<std::byte> body = encoded(image, std::endian::big);
  EXPECT_EQ(body.size(), 16U + 24);
  body.resize(body.size() + 24);
  EXPECT_TRUE(decode<Scan3dRangeImageData>(body, std::endian::big));
  body.pop_back();
  EXPECT_FALSE(decode<Scan3dRangeImageData>(body, std::endian::big));
  image.scanNum = -2;
  image.scanPointNum = -3;
  EXPECT_EQ(refusal(image), Errc::kInvalidArgument);
}

TEST(Bounds, FileNamesOfCAndOfJava) {
  const auto body = encoded(FileName::of("map.dat"), std::endian::little);
  EXPECT_EQ(body.size(), 132U);
  for (const std::size_t size : {std::size_t{132}, std::size_t{4 + 7}}) {
    const auto name = decode<FileName>(std::span(body).first(size), std::endian::little);
    ASSERT_TRUE(name) << name.error().message();
    EXPECT_EQ(name->view(), "map.dat");
  }
  EXPECT_FALSE(decode<FileName>(std::span(body).first(131), std::endian::little));
}

TEST(Bounds, WholeTablesOfC) {
  const std::vector<std::byte> datalog(6448);
  EXPECT_TRUE(decode<DatalogData>(datalog, std::endian::little));
  const std::vector<std::byte> planner(4212);
  EXPECT_TRUE(decode<PlannerData>(planner, std::endian::little));
  EXPECT_FALSE(decode<PlannerData>(std::span(planner).first(4211), std::endian::little));
}

TEST(Bounds, ParametersOfOriginalsMayHoldGarbage) {
  std::vector<std::byte> body(4 + 172, std::byte{'x'});
  bytes::write(body.data(), std::endian::little, i32{1});
  const auto list = decode<ParameterList>(body, std::endian::little);
  ASSERT_TRUE(list);
  EXPECT_EQ(list->parameters[0].name.view(), std::string(79, 'x'));
}

}  // namespace bounds_test
}  // namespace rack
