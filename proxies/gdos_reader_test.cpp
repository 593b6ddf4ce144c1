#include "proxies/gdos_reader.h"

#include <vector>

#include <gtest/gtest.h>

namespace rack::gdos {
namespace {

std::string line(const std::string& text) { return to_line({.time = {}, .text = text}); }

TEST(GdosReader, HoweverAFileIsCutIntoPieces) {
  const std::string file = line("one") + "nonsense\n" + line("two");
  for (std::size_t size = 1; size <= file.size(); ++size) {
    RecordReader reader;
    std::vector<std::string> texts;
    for (std::size_t at = 0; at < file.size(); at += size)
      reader.read(std::string_view(file).substr(at, size),
                  [&](Record&& record) { texts.push_back(record.text); });
    EXPECT_EQ(texts, (std::vector<std::string>{"one", "two"})) << size << " bytes each";
    EXPECT_EQ(reader.strange(), 1U);
  }
}

TEST(GdosReader, ALineWithoutEndTakesNoMemory) {
  RecordReader reader;
  int texts = 0;
  const auto count = [&](const Record&) { ++texts; };
  for (int i = 0; i < 1000; ++i) reader.read(std::string(10000, '{'), count);
  reader.read("\n" + line("one") + line("two").substr(0, 20), count);
  EXPECT_EQ(texts, 1);
  EXPECT_EQ(reader.strange(), 1U);
}

}  // namespace
}  // namespace rack::gdos
