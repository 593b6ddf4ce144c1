#include "router/config/files.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace tims::config {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void write(const fs::path& name, std::string_view text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }

  // "name=text" of every file read.
  [[nodiscard]] std::vector<std::string> read(const fs::path& name) const {
    const auto files = read_files(folder_ / name);
    if (!files) return {"refused"};
    std::vector<std::string> list;
    for (const File& file : *files)
      list.push_back(fs::relative(file.name, folder_).string() + "=" + file.text);
    return list;
  }

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(Files, AFileAlone) {
  write("router.toml", "a");
  EXPECT_THAT(read("router.toml"), testing::ElementsAre("router.toml=a"));
}

TEST_F(Files, AFileAndTheFolderBesideItInOrder) {
  write("router.toml", "a");
  write("router.d/20-b.toml", "c");
  write("router.d/10-a.toml", "b");
  write("router.d/notes.txt", "no");
  write("other.d/x.toml", "no");
  EXPECT_THAT(read("router.toml"), testing::ElementsAre("router.toml=a", "router.d/10-a.toml=b",
                                                        "router.d/20-b.toml=c"));
}

TEST_F(Files, AFolder) {
  write("b.toml", "2");
  write("a.toml", "1");
  EXPECT_THAT(read("."), testing::ElementsAre("a.toml=1", "b.toml=2"));
}

TEST_F(Files, AFileThatIsNotThereIsAnErrorThatNamesIt) {
  const auto files = read_files(folder_ / "no.toml");
  ASSERT_FALSE(files.ok());
  EXPECT_EQ(files.error().detail(),
            "cannot read " + (folder_ / "no.toml").string() + ": No such file or directory");
}

}  // namespace
}  // namespace tims::config
