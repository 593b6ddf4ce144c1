#include "os/wakeup.h"

#include <array>

#include <gtest/gtest.h>
#include <sys/mman.h>

namespace tims::os {

namespace wakeup_test {

TEST(Readable, WhenSomethingCame) {
  const Pipe pipe = *make_pipe();
  EXPECT_FALSE(is_readable(pipe.read.get()));
  EXPECT_FALSE(is_readable(pipe.read.get(), std::chrono::milliseconds(1)));
  ASSERT_EQ(::write(pipe.write.get(), "1", 1), 1);
  EXPECT_TRUE(is_readable(pipe.read.get()));
  EXPECT_TRUE(is_readable(pipe.read.get(), std::chrono::hours(1)));
  EXPECT_FALSE(is_readable(-1));
}

TEST(Readable, WhenItHasEnded) {
  Pipe pipe = *make_pipe();
  pipe.write.reset();
  EXPECT_TRUE(is_readable(pipe.read.get()));
}

TEST(AnyOf, IsReadableWhenOneOfThemIs) {
  const Pipe one = *make_pipe();
  const Pipe other = *make_pipe();
  const File file(::memfd_create("test", MFD_CLOEXEC));
  const auto any = any_of(std::array{one.read.get(), -1, file.get(), other.read.get()});
  ASSERT_TRUE(any) << any.error().message();
  EXPECT_FALSE(is_readable(any->get()));
  ASSERT_EQ(::write(other.write.get(), "1", 1), 1);
  EXPECT_TRUE(is_readable(any->get()));
}

TEST(AnyOf, NeedsDescriptors) { EXPECT_FALSE(any_of(std::array{1 << 20})); }

}  // namespace wakeup_test

}  // namespace tims::os
