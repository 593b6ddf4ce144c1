#include "tests/support/recording.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include "tests/support/temporary_folder.h"

namespace tims::test {
namespace recording_test {

class RecordingTest : public testing::Test {
 protected:
  Result<Recording> read(const std::string& text) const {
    gzFile file = ::gzopen(path_.c_str(), "wb");
    ::gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
    ::gzclose(file);
    return read_recording(path_);
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_.path() / "recording.jsonl.gz";
};

TEST_F(RecordingTest, EveryKindOfLine) {
  const auto recording = read(
      R"({"t_us":1,"ev":"mark","text":"begin"})"
      "\n"
      R"({"t_us":2,"ev":"connect","conn":0,"peer":"gui"})"
      "\n"
      R"({"t_us":3,"conn":0,"peer":"gui","dir":"c2r","hex":"03130000000000000000000010000000"})"
      "\n"
      R"({"t_us":4,"ev":"partial","conn":0,"peer":"gui","dir":"c2r","hex":"0001","bytes":9})"
      "\n"
      R"({"t_us":5,"ev":"close","conn":0,"peer":"gui","by":"router","how":"reset"})"
      "\n");
  ASSERT_TRUE(recording) << recording.error().message();
  ASSERT_EQ(recording->lines.size(), 5U);
  EXPECT_EQ(std::get<recorded::Mark>(recording->lines[0].event).text, "begin");
  EXPECT_TRUE(std::holds_alternative<recorded::Connect>(recording->lines[1].event));
  const auto& message = std::get<recorded::Message>(recording->lines[2].event);
  EXPECT_TRUE(message.to_router);
  EXPECT_EQ(message.view().header.type, 19);
  const auto& partial = std::get<recorded::Partial>(recording->lines[3].event);
  EXPECT_EQ(partial.first_bytes.size(), 2U);
  EXPECT_EQ(partial.size, 9U);
  const auto& close = std::get<recorded::Close>(recording->lines[4].event);
  EXPECT_TRUE(close.by_router);
  EXPECT_TRUE(close.reset);
  EXPECT_EQ(recording->lines[4].number, 5);
  EXPECT_EQ(recording->lines[4].peer, "gui");
  EXPECT_EQ(recording->lines[4].time, std::chrono::microseconds(5));
}

TEST_F(RecordingTest, ErrorsNameTheLine) {
  const std::string good = R"({"t_us":1,"ev":"mark","text":"begin"})";
  for (const char* bad :
       {"nonsense", "[]", R"({"ev":"mark","text":"no time"})", R"({"t_us":1,"ev":"party"})",
        R"({"t_us":1,"ev":"connect","conn":"zero","peer":"gui"})",
        R"({"t_us":1,"conn":0,"peer":"gui","dir":"up","hex":"03130000000000000000000010000000"})",
        R"({"t_us":1,"conn":0,"peer":"gui","dir":"c2r","hex":"0313000000000000000000001000000"})",
        R"({"t_us":1,"conn":0,"peer":"gui","dir":"c2r","hex":"03130000000000000000000011000000"})",
        R"({"t_us":1,"conn":0,"peer":"gui","dir":"c2r","hex":"0313"})"}) {
    const auto recording = read(good + "\n" + bad + "\n");
    ASSERT_FALSE(recording) << bad;
    EXPECT_NE(recording.error().message().find(path_ + ":2: "), std::string::npos)
        << recording.error().message();
  }
}

TEST(Recording, NoSuchFile) { EXPECT_FALSE(read_recording("/no/such/file")); }

}  // namespace recording_test
}  // namespace tims::test
