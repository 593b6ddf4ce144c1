// gdos-log keeps the texts of components, also malformed ones, and also when it is killed.
#include <csignal>

#include "rack/proxies/chassis.h"
#include "tests/system/gdos_log_fixture.h"

namespace tims::test {
namespace gdos_log_test {

TEST_F(GdosLogTest, TextsOfComponentsAreKeptAndFound) {
  start_log();
  start("ChassisSim");
  ASSERT_TRUE(proxy<rack::ChassisProxy>(0x00110000).on());
  EXPECT_TRUE(comes_to_be_kept("Module on"));
  send_text("look out");
  EXPECT_TRUE(comes_to_be_kept("look out"));
  const std::string chassis = shown({"-c", "Chassis"});
  EXPECT_THAT(chassis, HasSubstr("Chassis(0/0)       print   Module on\n"));
  EXPECT_THAT(chassis, Not(HasSubstr("look out")));
  EXPECT_THAT(shown({"-n", "1", "-l", "warning", "-c", "GUI"}), HasSubstr("warning look out\n"));
  EXPECT_THAT(shown({"--json", "-c", "GUI/0/0"}),
              HasSubstr(R"("level":"warning","text":"look out")"));
  EXPECT_THAT(shown({"-c", "Ladar"}, 1), HasSubstr("no messages found"));
  EXPECT_THAT(shown({"--until", "1h"}, 1), HasSubstr("no messages found"));
  EXPECT_THAT(shown({"--since", "1h", "-c", "GUI"}), HasSubstr("look out"));
}

TEST_F(GdosLogTest, IsAComponentLikeOthers) {
  start_log();
  auto log = proxy<rack::GdosLogProxy>(kLog);
  const auto is = [&](rack::Status status) {
    const auto now = log.status();
    return now && *now == status;
  };
  EXPECT_TRUE(eventually([&] { return is(rack::Status::kEnabled); }, "on by itself"));
  ASSERT_TRUE(log.off());
  EXPECT_TRUE(eventually([&] { return is(rack::Status::kDisabled); }, "off"));
  EXPECT_TRUE(session_->open({.address = text_sink()})) << "the sink is free while it is off";
  ASSERT_TRUE(log.on());
  send_text("here again");
  EXPECT_TRUE(comes_to_be_kept("here again"));
}

// For who comes late, on any host.
TEST_F(GdosLogTest, SendsTheNewestTexts) {
  start_log();
  EXPECT_TRUE(comes_to_be_kept("Module on"));
  send_text("look out");
  EXPECT_TRUE(comes_to_be_kept("look out"));
  auto log = proxy<rack::GdosLogProxy>(kLog);
  const auto texts = log.get_texts();
  ASSERT_TRUE(texts) << texts.error().message();
  EXPECT_EQ(std::string(texts->as_text()), kept());
}

// Texts in either byte order and with numeric arguments; and messages that are not texts.
TEST_F(GdosLogTest, AllKindsOfTextsAreDecodedAndHarmless) {
  start_log();
  const auto send = [&](const std::string& body, std::uint8_t order) {
    EXPECT_TRUE(
        work_->send({.dest = text_sink(), .type = -125, .body_order = order}, bytes_of(body)));
  };
  using namespace std::string_literals;
  send("port %d of %s\0\0\0\x01\x02lms\0"s, 0);
  send("port %d\0\x03\x01\0\0"s, flag::kBodyLittleEndian);
  send("from Java", 0);
  send(
      "\x1b]0;evil\a K\xE4"
      "fer \"quoted\"",
      0);
  send("%d %d\0", 0);
  send(std::string(256, '%'), 0);
  send("", 0);
  send_text("last");
  EXPECT_TRUE(comes_to_be_kept("last"));
  const std::string all = kept();
  for (const char* text :
       {"port 258 of lms", "port 259", "from Java", R"(Käfer \"quoted\")", "(malformed)"})
    EXPECT_THAT(all, HasSubstr(text));
  EXPECT_EQ(all.find('\x1b'), std::string::npos);
  EXPECT_THAT(shown({"-c", "GUI"}), Not(HasSubstr("no texts"))) << "every line can be decoded";
}

TEST_F(GdosLogTest, CommandsToTheSinkAreAnswered) {
  start_log();
  for (const auto& [command, answer] :
       {std::pair<std::int8_t, std::int8_t>{21, -21}, {1, -1}, {99, -1}}) {
    ASSERT_TRUE(work_->send({.dest = text_sink(), .type = command}, bytes_of("x")));
    const auto got = work_->peek_for(kPatience);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->header().type, answer);
    EXPECT_EQ(got->header().src, text_sink());
  }
}

TEST_F(GdosLogTest, KillingItLosesNothing) {
  start_log();
  send_text("before");
  ASSERT_TRUE(comes_to_be_kept("before"));
  kill("gdos-log");
  std::ofstream(folder() / rack::gdos::kCurrentFile, std::ios::app) << R"({"time":"2026)";
  EXPECT_THAT(start_log().output(), HasSubstr("removed 13 bytes of an incomplete text"));
  send_text("after");
  EXPECT_TRUE(comes_to_be_kept("after"));
  const std::string all = shown({"-c", "GUI"});
  EXPECT_THAT(all, HasSubstr("before"));
  EXPECT_THAT(all, Not(HasSubstr("no texts")));
}

TEST_F(GdosLogTest, FilesAreFewAndSmall) {
  start_log({"--fileSize=1", "--files=2"});
  for (int i = 0; i < 40; ++i)
    send_text("number " + std::to_string(i) + " " + std::string(100, 'x'));
  EXPECT_TRUE(comes_to_be_kept("number 39"));
  const auto paths = rack::gdos::log_paths(folder());
  EXPECT_EQ(paths.size(), 2U);
  for (const auto& path : paths) EXPECT_LE(std::filesystem::file_size(path), 1024U);
  EXPECT_THAT(kept(), Not(HasSubstr("number 0 ")));
}

TEST_F(GdosLogTest, AFloodIsCutShort) {
  start_log();
  send_text("first", rack::gdos::Level::kError);
  ASSERT_TRUE(comes_to_be_kept("first"));
  for (int i = 0; i < 900; ++i) send_text("detail", rack::gdos::Level::kDetail);
  send_text("still received", rack::gdos::Level::kError);
  EXPECT_TRUE(comes_to_be_kept("still received"));
  EXPECT_TRUE(comes_to_be_kept("texts suppressed: too many at once"));
  std::istringstream lines(kept());
  int details = 0;
  for (std::string line; std::getline(lines, line);)
    details += line.find("\"detail\"}") != std::string::npos;
  EXPECT_LT(details, 400);
  EXPECT_GE(details, 100);
}

TEST_F(GdosLogTest, AFullDiskIsReportedOnceAndDoesNotStopIt) {
  std::filesystem::create_directories(folder());
  std::filesystem::create_symlink("/dev/full", folder() / rack::gdos::kCurrentFile);
  auto& log = start_log();
  for (int i = 0; i < 3; ++i) send_text("nowhere");
  EXPECT_TRUE(log.wait_for_line("Texts are not kept: the disk is full: "));
  std::filesystem::remove(folder() / rack::gdos::kCurrentFile);
  EXPECT_TRUE(eventually(
      [&] {
        send_text("room");
        return kept().find("Texts are kept again; ") != std::string::npos;
      },
      "room"));
  EXPECT_THAT(kept(), HasSubstr("\"room\""));
  const std::string output = log.output();
  EXPECT_EQ(output.find("not kept:"), output.rfind("not kept:")) << output;
}

TEST_F(GdosLogTest, NoFolderIsAnErrorThatNamesIt) {
  auto& log = start("gdos-log", {"--directory=/proc/nowhere"});
  EXPECT_TRUE(log.wait_for_line("error: the operating system refused: /proc/nowhere"));
}

}  // namespace gdos_log_test
}  // namespace tims::test
