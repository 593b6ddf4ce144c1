// Recorded sessions of original programs with the original router: tests/data/recordings/*.jsonl.gz
// (format: the README there).
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "tims/message.h"
#include "tims/result.h"

namespace tims::test {

namespace recorded {

struct Message {  // one complete TiMS message
  bool to_router = false;
  std::vector<std::byte> bytes;

  [[nodiscard]] MessageView view() const;
};
struct Connect {};
struct Close {
  bool by_router = false;
  bool reset = false;
};
struct Partial {  // an incomplete message, directly before a close
  bool to_router = false;
  std::vector<std::byte> first_bytes;
  std::size_t size = 0;
};
struct Mark {  // note of the next action during the recording
  std::string text;
};

struct Line {
  int number = 0;  // in the file, from 1
  std::chrono::microseconds time{0};
  int conn = -1;  // connections count from 0; -1 for marks
  std::string peer{};
  std::variant<Mark, Message, Connect, Close, Partial> event;
};

}  // namespace recorded

struct Recording {
  std::string name;  // of the file
  std::vector<recorded::Line> lines;
};

// An error contains the file and the line number.
Result<Recording> read_recording(const std::string& path);

}  // namespace tims::test
