// Where the texts of a robot are kept: what writes them and what reads them agree here.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rack::gdos {

// The file that grows; what it held before is in texts.000001.jsonl and so on, the newest with the
// highest number.
inline constexpr std::string_view kCurrentFile = "texts.jsonl";
std::string numbered_file(std::uint32_t number);
std::optional<std::uint32_t> file_number(std::string_view name);

struct LogFiles {
  std::vector<std::uint32_t> numbers;  // rising
  bool current = false;
  [[nodiscard]] std::uint32_t next_number() const {
    return numbers.empty() ? 1 : numbers.back() + 1;
  }
};
LogFiles log_files(const std::filesystem::path& folder);
// Oldest first.
std::vector<std::filesystem::path> log_paths(const std::filesystem::path& folder);

// $LOGS_DIRECTORY (what a systemd unit has); else /var/log/tims for root, and $XDG_STATE_HOME/tims
// or
// ~/.local/state/tims for others.
std::filesystem::path folder_to_write();
// The same where texts are there; else /var/log/tims.
std::filesystem::path folder_to_read();

}  // namespace rack::gdos
