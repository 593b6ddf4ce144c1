// Files and generations on the disk.
#include "tools/configuration/folder.h"

#include <filesystem>
#include <fstream>

#include <boost/json/parse.hpp>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/temporary_folder.h"
#include "tools/configuration/store.h"

namespace timsctl::configuration {
namespace folder_test {

namespace fs = std::filesystem;

TEST(FileName, IsOneOfThreeForms) {
  for (const std::string good :
       {"router.toml", "router.d/a.toml", "robots/scout.toml", "robots/A-1_b.toml"})
    EXPECT_TRUE(is_file_name(good)) << good;
  for (const std::string bad :
       {"", "router", "x.toml", "/etc/passwd", "../router.toml", "robots/../router.toml",
        "robots/.toml", "robots/..toml", "robots/a/b.toml", "robots/-a.toml", "robots/a b.toml",
        "robots/a.toml/", "robots//a.toml", "./router.toml", "ROBOTS/a.toml", "robots/a.dxf"})
    EXPECT_FALSE(is_file_name(bad)) << bad;
  EXPECT_TRUE(is_file_name("robots/" + std::string(31, 'a') + ".toml"));
  EXPECT_FALSE(is_file_name("robots/" + std::string(32, 'a') + ".toml"));
  EXPECT_FALSE(is_file_name(std::string("robots/a\0.toml", 14)));
}

class FolderTest : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name) << text;
  }
  tims::test::TemporaryFolder folder_;
  Folder files_{folder_.path()};
};

TEST_F(FolderTest, ReadsPlainFilesOnly) {
  write("router.toml", "a");
  write("robots/scout.toml", "b");
  write("robots/floor.dxf", "no");
  write("secret", "no");
  fs::create_symlink(folder_.path() / "secret", folder_.path() / "robots" / "link.toml");
  ASSERT_EQ(::mkfifo((folder_.path() / "robots" / "pipe.toml").c_str(), 0600), 0);
  fs::create_directory(folder_.path() / "robots" / "folder.toml");
  const auto all = files_.read();
  ASSERT_TRUE(all) << all.error().detail();
  EXPECT_EQ(*all, (Texts{{"robots/scout.toml", "b"}, {"router.toml", "a"}}));
}

TEST_F(FolderTest, ALinkedFolderIsNone) {
  write("elsewhere/x.toml", "no");
  fs::create_directory_symlink(folder_.path() / "elsewhere", folder_.path() / "robots");
  EXPECT_EQ(files_.read().value(), Texts{});
}

TEST_F(FolderTest, WriteMakesTheFilesTheseAndNoOthers) {
  write("robots/old.toml", "old");
  write("robots/same.toml", "same");
  const auto before = fs::last_write_time(folder_.path() / "robots/same.toml");
  const Texts wanted{
      {"robots/new.toml", "n"}, {"robots/same.toml", "same"}, {"router.d/a.toml", "a"}};
  ASSERT_TRUE(files_.write(wanted));
  EXPECT_EQ(files_.read().value(), wanted);
  EXPECT_EQ(fs::last_write_time(folder_.path() / "robots/same.toml"), before);
}

TEST_F(FolderTest, NeverWritesThroughALink) {
  write("secret", "secret");
  fs::create_directory(folder_.path() / "robots");
  fs::create_symlink(folder_.path() / "secret", folder_.path() / "robots" / "link.toml");
  EXPECT_FALSE(files_.write({{"robots/link.toml", "x"}}));
  std::ifstream secret(folder_.path() / "secret");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(secret), {}), "secret");
}

TEST_F(FolderTest, SizesAndNumbersAreBounded) {
  write("robots/a.toml", std::string(kFileMax, '#'));
  EXPECT_TRUE(files_.read());
  write("robots/a.toml", std::string(kFileMax + 1, '#'));
  EXPECT_FALSE(files_.read());
  write("robots/a.toml", "");
  for (std::size_t i = 1; i < kFilesMax; ++i) write("robots/r" + std::to_string(i) + ".toml", "");
  EXPECT_TRUE(files_.read());
  write("robots/more.toml", "");
  EXPECT_FALSE(files_.read());
}

Record full_record() {
  Record record{.current = 2, .last = 3};
  record.items.push_back({.generation = 2, .from = 1, .outcome = Outcome::kConfirmed});
  record.items.push_back({.generation = 3,
                          .from = 2,
                          .change = "00112233445566aa",
                          .who = "a \"b\"",
                          .why = "c",
                          .time = "t",
                          .reason = "r",
                          .others = {"0x01010001"}});
  record.pending = Record::Pending{.generation = 3, .state = State::kSettling, .reason = "x"};
  record.untold["00112233445566ff"] = {"0x02010001", "0x03010001"};
  return record;
}

TEST(Store, ARecordComesBackAsItWas) {
  const tims::test::TemporaryFolder folder;
  const Store store(folder.path() / "a" / "state");
  EXPECT_EQ(store.load().value(), Record{});
  const Record record = full_record();
  ASSERT_TRUE(store.save(record));
  EXPECT_EQ(store.load().value(), record);
}

TEST(Store, KeepsTheFilesOfKnownGenerationsOnly) {
  const tims::test::TemporaryFolder folder;
  const Store store(folder.path());
  const Texts texts{{"router.toml", "a\r\n\0b"}, {"robots/x.toml", ""}};
  for (const Generation each : {1U, 2U, 3U, 4U}) ASSERT_TRUE(store.keep(each, texts));
  EXPECT_EQ(store.files(2).value(), texts);
  ASSERT_TRUE(store.save(full_record()));
  EXPECT_FALSE(store.files(1)) << "no longer in the record";
  EXPECT_TRUE(store.files(3));
  EXPECT_TRUE(store.files(4)) << "is being made";
}

TEST(Store, ADamagedRecordIsAnError) {
  const tims::test::TemporaryFolder folder;
  const Store store(folder.path());
  for (const std::string text : {"", "{", "[]", R"({"items": [{}]})",
                                 R"({"pending": {"generation": 9, "state": "waiting"}})"}) {
    std::ofstream(folder.path() / "record.json") << text;
    EXPECT_FALSE(store.load()) << text;
  }
}

}  // namespace folder_test
}  // namespace timsctl::configuration
