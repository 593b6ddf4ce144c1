// Texts in the journal of the host, with a real journald in separate namespaces.
#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <unistd.h>

#include "tests/system/gdos_log_fixture.h"

namespace tims::test {
namespace gdos_log_journal_test {

namespace json = boost::json;

// Runs a command in its own mount and process namespaces, so its mounts and processes end with it.
constexpr const char* kInItsCorner = R"(
mount -t tmpfs none /run && mkdir -p /run/systemd/journal /run/log/journal || exit 1
mount -t tmpfs none /var/log || exit 1
/lib/systemd/systemd-journald >/dev/null 2>&1 &
until test -S /run/systemd/journal/socket; do sleep 0.02; done
exec "$@"
)";

class GdosLogJournalTest : public GdosLogTest {
 protected:
  void SetUp() override {
    if (::geteuid() != 0) GTEST_SKIP() << "needs root to mount";
    if (::access("/lib/systemd/systemd-journald", X_OK) != 0) GTEST_SKIP() << "no journald here";
    GdosLogTest::SetUp();
    ChildOptions options = at_router();
    options.environment.emplace_back("JOURNAL_STREAM=1:1");  // as set by systemd
    auto log = ChildProcess::start(
        {"unshare", "-m", "-p", "-f", "--kill-child", "bash", "-c", kInItsCorner, "corner",
         std::string(TIMS_PROGRAMS) + "/gdos-log", "--directory=" + folder().string()},
        options);
    ASSERT_TRUE(log) << log.error().message();
    log_.emplace(std::move(*log));
    if (!log_->wait_for_line("Texts are kept in")) GTEST_SKIP() << log_->output();
  }
  // The entries of the journal that match.
  std::vector<json::object> journal(const std::string& match) {
    auto child =
        ChildProcess::start({"nsenter", "-m", "-t", std::to_string(log_->pid()), "journalctl", "-D",
                             "/run/log/journal", "-o", "json", "--no-pager", "-q", match});
    std::vector<json::object> entries;
    if (!child || !child->wait()) return entries;
    std::istringstream lines(child->standard_output());
    for (std::string line; std::getline(lines, line);)
      entries.push_back(json::parse(line).as_object());
    return entries;
  }

  std::optional<ChildProcess> log_;
};

TEST_F(GdosLogJournalTest, TextsAreFoundByTheirFields) {
  send_text("look out", rack::gdos::Level::kWarning);
  send_text("two\nlines \x1b[31m", rack::gdos::Level::kError);
  std::vector<json::object> entries;
  ASSERT_TRUE(eventually(
      [&] {
        entries = journal("TIMS_ADDRESS=0x00020001");
        return entries.size() == 2;
      },
      "both texts in the journal"));
  const auto field = [&](std::size_t entry, const char* name) {
    const json::value& value = entries.at(entry).at(name);
    return value.is_string() ? std::string(value.as_string()) : "no text";
  };
  EXPECT_EQ(field(0, "MESSAGE"), "look out");
  EXPECT_EQ(field(0, "PRIORITY"), "4");
  EXPECT_EQ(field(0, "SYSLOG_IDENTIFIER"), "GUI(0/0):1");
  EXPECT_EQ(field(0, "TIMS_COMPONENT"), "GUI(0/0):1");
  EXPECT_EQ(field(0, "TIMS_LEVEL"), "warning");
  EXPECT_EQ(field(1, "PRIORITY"), "3");
  EXPECT_EQ(field(1, "MESSAGE"), "two lines  [31m");
  EXPECT_TRUE(comes_to_be_kept("look out")) << "and in the files as well";
}

}  // namespace gdos_log_journal_test
}  // namespace tims::test
