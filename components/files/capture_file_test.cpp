// Recordings survive the end or crash of their program and a full disk.
#include "components/files/capture_file.h"

#include <array>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>

#include "os/clock.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"

namespace rack::device {
namespace capture_file_test {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr std::array kBytes = {std::byte{0x41}, std::byte{0x42}};

class CaptureFileTest : public testing::Test {
 protected:
  std::unique_ptr<CaptureFile> create(tims::Time begin = tims::os::now()) {
    auto file = CaptureFile::create(path_, "serial:/dev/x", begin);
    EXPECT_TRUE(file) << file.error().message();
    return file ? std::move(*file) : nullptr;
  }
  // The records that can be played.
  std::vector<CaptureRecord> records() const {
    std::ifstream file(path_);
    std::vector<CaptureRecord> all;
    CaptureRecord record;
    for (std::string line; std::getline(file, line);)
      if (const auto parsed = parse_record(line, record); parsed && *parsed) all.push_back(record);
    return all;
  }
  std::string content() const { return tims::os::read_file(path_).value_or("unreadable"); }

  tims::test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() / "x.cap";
};

TEST_F(CaptureFileTest, WhatWasAddedIsThereWhenItIsClosed) {
  const tims::Time begin = tims::os::now();
  {
    const auto file = create(begin);
    file->add(begin + 1s, Direction::kSent, 0, kBytes);
    file->add(begin + 2s, Direction::kReceived, 0x181, kBytes);
    file->add_event(begin + 3s, "gone");
    EXPECT_EQ(file->lost(), 0U);
  }
  const auto all = records();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].time, 1s);
  EXPECT_EQ(all[1].id, 0x181U);
  EXPECT_EQ(all[2].event, "gone");
}

TEST_F(CaptureFileTest, OneThatIsThereIsContinuedAndTimesGoOn) {
  for (int i = 0; i < 3; ++i) {
    const tims::Time begin = tims::os::now();
    create(begin)->add(begin + 10s, Direction::kReceived, 0, kBytes);
  }
  const auto all = records();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_GE(all[1].time, 20s);
  EXPECT_LT(all[1].time, 25s);
  EXPECT_GE(all[2].time, 30s);
}

TEST_F(CaptureFileTest, ALineThatACrashHasCutIsLeftBehind) {
  std::ofstream(path_) << "# rack capture 1 x y\n1.5 < 4142\n2.5 < 4";
  const tims::Time begin = tims::os::now();
  create(begin)->add(begin, Direction::kReceived, 0, kBytes);
  const auto all = records();
  ASSERT_EQ(all.size(), 2U) << content();
  EXPECT_GE(all[1].time, 1500ms);
  EXPECT_THAT(content(), testing::Not(HasSubstr("2.5")));
}

TEST_F(CaptureFileTest, WhatIsNoRecordingIsNotOverwritten) {
  std::ofstream(path_) << "my thesis\n";
  const auto file = CaptureFile::create(path_, "x", tims::os::now());
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().detail(), HasSubstr("not overwritten"));
  EXPECT_EQ(content(), "my thesis\n");
}

TEST_F(CaptureFileTest, AFolderIsRefusedWithAReason) {
  const auto file = CaptureFile::create(folder_.path(), "x", tims::os::now());
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().detail(), HasSubstr("directory"));
}

TEST_F(CaptureFileTest, RecordsLostAtTheEndAreReported) {
  auto file = CaptureFile::create("/dev/full", "x", tims::os::now());
  ASSERT_TRUE(file);
  (*file)->add(tims::os::now(), Direction::kReceived, 0, kBytes);
  (*file)->finish();
  EXPECT_EQ((*file)->lost(), 2U) << "with its head";
  EXPECT_EQ((*file)->take_event(), "/dev/full could not be written; 2 records are missing in it");
}

TEST_F(CaptureFileTest, WhatIsNoFileLosesNothing) {
  auto file = CaptureFile::create("/dev/null", "x", tims::os::now());
  ASSERT_TRUE(file);
  (*file)->add(tims::os::now(), Direction::kReceived, 0, kBytes);
  (*file)->finish();
  EXPECT_EQ((*file)->lost(), 0U);
  EXPECT_FALSE((*file)->take_event());
}

// Only whole records are written; when there is space again, recording continues.
TEST_F(CaptureFileTest, AFullDiskCostsRecordsThatAreCounted) {
  if (::mount("none", folder_.path().c_str(), "tmpfs", 0, "size=256k") != 0)
    GTEST_SKIP() << "no right to mount a small disk";
  const std::string ballast = folder_.path() / "ballast";
  std::ofstream(ballast) << std::string(200 << 10, 'x');
  const std::vector<std::byte> piece(20 << 10);
  {
    const auto file = create();
    for (int i = 0; i < 10; ++i) file->add(tims::os::now(), Direction::kReceived, 0, piece);
    EXPECT_TRUE(tims::test::eventually([&] { return file->lost() >= 10; }, "all are lost"));
    EXPECT_THAT(file->take_event().value_or(""), HasSubstr("No space left on device"));
    EXPECT_FALSE(file->take_event()) << "once";
    std::filesystem::remove(ballast);
    file->add(tims::os::now(), Direction::kReceived, 7, kBytes);
    file->finish();
    EXPECT_THAT(file->take_event().value_or(""),
                HasSubstr("is written again; " + std::to_string(file->lost()) + " records"));
  }
  const auto all = records();
  ASSERT_EQ(all.size(), 1U) << "and no half of one";
  EXPECT_EQ(all[0].id, 7U);
  ::umount(folder_.path().c_str());
}

}  // namespace capture_file_test
}  // namespace rack::device
