#include "tools/deploy/repository.h"

#include <gmock/gmock.h>

namespace timsctl::deploy {
namespace repository_test {

using testing::ElementsAre;
using testing::IsEmpty;

std::string paragraph(const std::string& name, const std::string& version,
                      const std::string& more = "") {
  return "Package: " + name + "\nVersion: " + version + "\nArchitecture: amd64\n" + more +
         "Filename: ./" + name + "_" + version +
         "_amd64.deb\nSize: 10\nSHA256: " + std::string(64, 'a') + "\n\n";
}

std::vector<std::string> files(const std::vector<Package>& packages) {
  std::vector<std::string> all;
  for (const Package& package : packages) all.push_back(package.file);
  return all;
}

TEST(DeployRepository, ReadsAnIndex) {
  const auto all = packages_in(
      paragraph("tims-router", "1.0",
                "Depends: libc6 (>= 2.36), tims-common (= 1.0) | tims-old, python3:any\n"
                "Pre-Depends: init [amd64]\nDescription: x\n Depends: nothing\n"));
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].name, "tims-router");
  EXPECT_THAT(all[0].needs, ElementsAre("libc6", "tims-common", "tims-old", "python3", "init"));
  EXPECT_EQ(all[0].file, "tims-router_1.0_amd64.deb");
  EXPECT_EQ(all[0].size, 10U);
}

TEST(DeployRepository, LeavesOutWhatIsNoPackage) {
  for (const char* file : {"../x.deb", "a/b.deb", "-x.deb", ".x.deb", "a b.deb", ""}) {
    std::string text = paragraph("a", "1");
    text.replace(text.find("./a_1_amd64.deb"), 15, file);
    EXPECT_THAT(packages_in(text), IsEmpty()) << file;
  }
  EXPECT_THAT(packages_in("\n\n\n:\n x\nPackage: a"), IsEmpty());
}

TEST(DeployRepository, ComparesVersionsAsDpkgDoes) {
  const char* const rising[] = {"0~",
                                "0",
                                "0.1~rc1",
                                "0.1",
                                "0.2.0",
                                "0.2.0+20261127.1",
                                "0.2.0+20261128.1",
                                "0.2.1~a",
                                "0.2.1",
                                "0.2.1-1",
                                "0.2.1-1a",
                                "0.2.1-1+b1",
                                "0.10",
                                "1a",
                                "1.0",
                                "1:0.1"};
  for (std::size_t a = 0; a < std::size(rising); ++a)
    for (std::size_t b = 0; b < std::size(rising); ++b) {
      const int order = compare_versions(rising[a], rising[b]);
      EXPECT_EQ(order < 0, a < b) << rising[a] << " " << rising[b];
      EXPECT_EQ(order == 0, a == b) << rising[a] << " " << rising[b];
    }
  EXPECT_EQ(compare_versions("1.00", "1.0"), 0);
  EXPECT_EQ(compare_versions("0:1", "1-0"), 0);
}

TEST(DeployRepository, FindsTheNewestAndWhatItNeeds) {
  const auto all =
      packages_in(paragraph("router", "1.0", "Depends: old\n") +
                  paragraph("router", "1.1", "Depends: common (= 1.1), libc6\n") +
                  paragraph("common", "1.1", "Depends: router\n") + paragraph("common", "1.0") +
                  paragraph("old", "1") + paragraph("other", "1"));
  const std::string wanted[] = {"router", "missing"};
  EXPECT_THAT(files(needed(all, wanted, "amd64")),
              ElementsAre("common_1.1_amd64.deb", "router_1.1_amd64.deb"));
  EXPECT_THAT(needed(all, wanted, "arm64"), IsEmpty());
}

}  // namespace repository_test
}  // namespace timsctl::deploy
