#include "components/devices/scanners/cola_front.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace cola_front_test {

TEST(ColaFrontTest, FamiliesAreKnownByTheirNames) {
  for (const char* name : {"TiM240", "TIM240-2112345 V1.0", "LRS4581R", "LRS4000", "NAV245"})
    EXPECT_EQ(front_of_name(name), (ColaFront{.degrees = 0})) << name;
  for (const char* name : {"NAV310", "NAV310-3211", "LRS3600", "LRS3610", "OEM1501"})
    EXPECT_EQ(front_of_name(name), (ColaFront{.degrees = 180, .is_clockwise = true})) << name;
  for (const char* name : {"NAV350", "LRS3601", "LRS3611"})
    EXPECT_EQ(front_of_name(name), (ColaFront{.degrees = 180})) << name;
  for (const char* name : {"LMS111 V1.80", "LMS511", "TiM561", "TiM781S", "TiM443", "MRS1104", "",
                           "TiM", "LRS36", "NAV"})
    EXPECT_NE(front_of_name(name).value_or(ColaFront{}), (ColaFront{.degrees = 0})) << name;
}

TEST(ColaFrontTest, OtherScansAreKnownByTheirRange) {
  EXPECT_EQ(front_of_range(-1200000).degrees, 0);
  EXPECT_EQ(front_of_range(-600001).degrees, 0);
  EXPECT_EQ(front_of_range(-600000).degrees, 90);
  EXPECT_EQ(front_of_range(-450000).degrees, 90);
  EXPECT_EQ(front_of_range(0).degrees, 90);
}

}  // namespace cola_front_test
}  // namespace rack::device
