#include "rack/devices/recording.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace rack::device {
namespace recording_test {

namespace fs = std::filesystem;

constexpr std::string_view kBegin = "# rack capture 1 serial:/dev/a 2026-11-23T09:30:00Z\n";

std::unique_ptr<Recording> open(const fs::path& path) {
  DeviceAddress address;
  address.place = path;
  auto recording = open_recording(address, 9600);
  EXPECT_TRUE(recording) << recording.error().message();
  return recording ? std::move(*recording) : nullptr;
}

// A line that no driver has written must not fill the memory. The next one can be read.
TEST(Recording, ALineOf300MegabytesIsRefused) {
  const tims::test::TemporaryFolder folder;
  const fs::path path = folder.path() / "a.cap";
  std::ofstream(path) << kBegin << "0.1 < 01\n";
  fs::resize_file(path, 300 << 20);
  std::ofstream(path, std::ios::app) << "\n0.2 < 02\n";
  const auto recording = open(path);
  ASSERT_TRUE(recording);
  CaptureRecord record;
  EXPECT_TRUE(recording->next(record).value());
  const auto large = recording->next(record);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code(), tims::Errc::kTooBig);
  EXPECT_EQ(large.error().detail(),
            "line 3: longer than 16 MB, so it is not a recording of a device");
  ASSERT_TRUE(recording->next(record).value());
  EXPECT_EQ(record.bytes, std::vector{std::byte{2}});
  EXPECT_FALSE(recording->next(record).value());
}

// Pieces of lines end anywhere.
TEST(Recording, LinesMayBeAsLongAsThoseOfACamera) {
  const tims::test::TemporaryFolder folder;
  const fs::path path = folder.path() / "a.cap";
  for (const std::size_t size : {1U, 32'000U, 32'763U, 32'764U, 65'535U, 8'000'000U}) {
    std::string text(kBegin);
    for (int i = 0; i < 3; ++i) {
      text += "0.1 < ";
      for (std::size_t j = 0; j < size; ++j) text += "5a";
      text += i < 2 ? "\n" : "";
    }
    std::ofstream(path) << text;
    const auto recording = open(path);
    ASSERT_TRUE(recording);
    CaptureRecord record;
    for (int i = 0; i < 3; ++i) {
      const auto next = recording->next(record);
      ASSERT_TRUE(next) << next.error().message();
      ASSERT_TRUE(*next) << size << ", line " << i;
      EXPECT_EQ(record.bytes.size(), size);
    }
    EXPECT_FALSE(recording->next(record).value());
    recording->rewind();
    EXPECT_TRUE(recording->next(record).value());
  }
}

TEST(Recording, AFolderWithTheNameOfAPictureIsNone) {
  const tims::test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "a.jpg");
  DeviceAddress address;
  address.place = folder.path();
  const auto none = open_recording(address, 0);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().detail(), address.place + " is a folder without pictures (.jpg)");
  std::ofstream(folder.path() / "b.jpg") << "picture";
  const auto pictures = open(folder.path());
  ASSERT_TRUE(pictures);
  CaptureRecord record;
  EXPECT_TRUE(pictures->next(record).value());
  EXPECT_EQ(record.bytes.size(), 7U);
  EXPECT_FALSE(pictures->next(record).value());
}

TEST(Recording, APictureHasABound) {
  const tims::test::TemporaryFolder folder;
  std::ofstream(folder.path() / "a.jpg") << "x";
  fs::resize_file(folder.path() / "a.jpg", 300 << 20);
  const auto pictures = open(folder.path());
  ASSERT_TRUE(pictures);
  CaptureRecord record;
  const auto next = pictures->next(record);
  ASSERT_FALSE(next);
  EXPECT_EQ(next.error().detail(), (folder.path() / "a.jpg").string() + ": larger than 36 MB");
}

}  // namespace recording_test
}  // namespace rack::device
