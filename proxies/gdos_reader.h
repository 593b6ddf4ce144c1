// The texts of a file, piece by piece: a line may end in the next piece, and what is no text is
// counted and passed over.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "proxies/gdos_record.h"

namespace rack::gdos {

class RecordReader {
 public:
  // No line of ours is longer. What is, is no text.
  static constexpr std::size_t kLineMax = 16384;

  template <typename Take>  // (Record&&)
  void read(std::string_view piece, Take take) {
    while (!piece.empty()) {
      const std::size_t end = piece.find('\n');
      add(piece.substr(0, end));
      if (end == std::string_view::npos) return;
      if (auto record = finish_line()) take(std::move(*record));
      piece.remove_prefix(end + 1);
    }
  }
  // The last line may still be written to: without its end it is not looked at.

  [[nodiscard]] std::uint64_t strange() const { return strange_; }  // lines that are no texts

 private:
  void add(std::string_view part) {
    too_long_ = too_long_ || line_.size() + part.size() > kLineMax;
    if (!too_long_) line_ += part;
  }
  std::optional<Record> finish_line() {
    auto record = too_long_ ? std::nullopt : record_of(line_);
    if (!record) ++strange_;
    line_.clear();
    too_long_ = false;
    return record;
  }

  std::string line_;
  bool too_long_ = false;
  std::uint64_t strange_ = 0;
};

}  // namespace rack::gdos
