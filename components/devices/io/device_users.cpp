#include "components/devices/io/device_users.h"

#include <filesystem>
#include <fstream>
#include <set>

#include "base/text.h"

namespace rack::device {
namespace {

namespace fs = std::filesystem;

std::set<std::string> open_device_files(const fs::path& process) {
  std::set<std::string> files;
  std::error_code error;
  for (fs::directory_iterator at(process / "fd", error), end; !error && at != end;
       at.increment(error)) {
    std::error_code is_closed;
    const std::string target = fs::read_symlink(at->path(), is_closed);
    if (!is_closed && target.starts_with("/dev/")) files.insert(target);
  }
  return files;
}

std::string command_of(const fs::path& process) {
  std::ifstream file(process / "comm");
  std::string line;
  std::getline(file, line);
  return tims::base::printable(line);
}

}  // namespace

std::multimap<std::string, std::string> device_users(const std::string& proc) {
  std::map<int, fs::path> processes;
  std::error_code error;
  for (fs::directory_iterator at(proc, error), end; !error && at != end; at.increment(error))
    if (const auto pid = tims::base::parse_number<int>(at->path().filename().string()))
      processes.emplace(*pid, at->path());
  std::multimap<std::string, std::string> users;
  for (const auto& [pid, process] : processes)
    for (const std::string& file : open_device_files(process))
      users.emplace(file, command_of(process) + " (pid " + std::to_string(pid) + ")");
  return users;
}

}  // namespace rack::device
