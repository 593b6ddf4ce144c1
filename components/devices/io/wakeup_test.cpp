#include "rack/devices/wakeup.h"

#include <gtest/gtest.h>

#include "os/wakeup.h"

namespace rack::device {
namespace wakeup_test {

TEST(WakeupTest, IsReadableFromTheSignalUntilItIsDrained) {
  Wakeup wakeup;
  wakeup.signal();  // has no effect yet
  wakeup.drain();
  EXPECT_EQ(wakeup.descriptor(), -1);
  ASSERT_TRUE(wakeup.open().ok());
  const int descriptor = wakeup.descriptor();
  EXPECT_FALSE(tims::os::is_readable(descriptor));
  for (int i = 0; i < 3; ++i) wakeup.signal();
  EXPECT_TRUE(tims::os::is_readable(descriptor));
  ASSERT_TRUE(wakeup.open().ok());
  EXPECT_EQ(wakeup.descriptor(), descriptor) << "opened once";
  wakeup.drain();
  EXPECT_FALSE(tims::os::is_readable(descriptor));
}

}  // namespace wakeup_test
}  // namespace rack::device
