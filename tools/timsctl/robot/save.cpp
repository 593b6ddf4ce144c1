#include "tools/timsctl/robot/save.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "os/file.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/robot/parameter_edit.h"

namespace timsctl::robot {

namespace {

namespace fs = std::filesystem;
using tims::os::File;

[[noreturn]] void cannot_write(const std::string& path) {
  throw Failure(Exit::kDenied, "cannot_write", tims::os::system_error(path).detail(),
                "may you write there?");
}

void write_all(const File& file, std::string_view text, const std::string& path) {
  while (!text.empty()) {
    const ssize_t size = ::write(file.get(), text.data(), text.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) cannot_write(path);
    text.remove_prefix(static_cast<std::size_t>(size));
  }
}

// Whoever reads it, also after a power cut, sees all of the old text or all of the new one.
void replace_file(const std::string& path, std::string_view text) {
  struct stat old {};
  if (::stat(path.c_str(), &old) != 0) cannot_write(path);
  const std::string made = path + ".new";
  ::unlink(made.c_str());  // of somebody who did not get further
  const File file(::open(made.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (!file) cannot_write(made);
  try {
    write_all(file, text, made);
    // It stays whose it is, if that is allowed.
    if (::fchown(file.get(), old.st_uid, old.st_gid) != 0 && errno != EPERM) cannot_write(made);
    if (::fchmod(file.get(), old.st_mode & 07777) != 0 || ::fsync(file.get()) != 0 ||
        ::rename(made.c_str(), path.c_str()) != 0)
      cannot_write(made);
  } catch (const Failure&) {
    ::unlink(made.c_str());
    throw;
  }
  const std::string folder = fs::path(path).parent_path();
  const File opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened || ::fsync(opened.get()) != 0) cannot_write(folder);
}

}  // namespace

json::object save_parameters(RobotText& source, std::size_t component,
                             const std::map<std::string, std::string>& parameters, bool dry_run) {
  if (source.file.empty())
    throw Failure(Exit::kNoSuch, "no_robot_file", "this robot was not read from a file here",
                  "its file is where `timsctl up` was given it");
  std::error_code error;
  const std::string path = fs::canonical(source.file, error);  // not a link to it
  std::ifstream stream(path);
  const std::string now{std::istreambuf_iterator<char>(stream), {}};
  if (error || !stream)
    throw Failure(Exit::kNoSuch, "no_robot_file", source.file + ": cannot be read any more",
                  "has it been moved?");
  if (now != source.text)
    throw Failure(Exit::kNo, "file_changed",
                  source.file + " has changed since this robot was read from it",
                  "write the parameters there by hand, or start the robot anew from it");
  const auto edited = with_parameters({source.file, now}, source.system, component, parameters);
  if (!edited)
    throw Failure(Exit::kNo, "cannot_write", edited.error().detail(),
                  "`--dry-run` shows what would change");
  if (!dry_run && !edited->changes.empty()) {
    replace_file(path, edited->text);
    source.text = edited->text;
  }
  json::array changes;
  for (const ParameterChange& change : edited->changes)
    changes.push_back({{"name", change.name},
                       {"before", change.before ? json::value(*change.before) : json::value()},
                       {"after", change.after}});
  return {{"schema", "tims/parameters_saved/1"},
          {"file", source.file},
          {"written", !dry_run && !edited->changes.empty()},
          {"changes", std::move(changes)}};
}

}  // namespace timsctl::robot
