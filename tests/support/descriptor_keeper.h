// Plays systemd for one service of Type=notify: receives what it reports, keeps the descriptors
// that it stores, and gives them to its next run (FileDescriptorStoreMax).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "os/file.h"
#include "tests/support/child_process.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::test {

class DescriptorKeeper {
 public:
  // `path`: of $NOTIFY_SOCKET, which is made.
  static Result<DescriptorKeeper> listen(const std::string& path);

  // Starts the program with all that is kept.
  Result<ChildProcess> start(const std::vector<std::string>& command);
  // Until it reports READY=1. Returns the names of descriptors that it let go.
  Result<std::vector<std::string>> wait_until_ready();
  // Signals it, and keeps what it stores until it has ended.
  Result<ExitStatus> end(ChildProcess& program, int signal);

  // By name; may be altered.
  std::map<std::string, os::File>& kept() { return kept_; }
  [[nodiscard]] std::vector<std::string> names() const;

  struct Report {
    std::string text;
    os::File file{};
  };
  Result<Report> receive(Duration patience);

 private:
  DescriptorKeeper(os::File socket, std::string path)
      : socket_(std::move(socket)), path_(std::move(path)) {}
  void take(Report report, std::vector<std::string>& let_go);

  os::File socket_;
  std::string path_;
  std::map<std::string, os::File> kept_;
};

// A tims-router that is run by such a keeper. Its settings: "key=value".
class KeptRouter {
 public:
  KeptRouter(const std::string& folder, std::vector<std::string> settings);

  Result<void> start();  // until it is ready
  // As `systemctl restart` with tims-router.service; SIGKILL: as after a crash.
  Result<void> restart(int signal);
  Result<void> stop();

  [[nodiscard]] const std::string& socket_path() const { return socket_path_; }
  [[nodiscard]] ChildProcess& process() { return *process_; }
  [[nodiscard]] DescriptorKeeper& keeper() { return *keeper_; }
  [[nodiscard]] std::string output() const;  // of all runs

 private:
  std::string folder_;
  std::string socket_path_;
  std::vector<std::string> settings_;
  std::optional<DescriptorKeeper> keeper_;
  std::optional<ChildProcess> process_;
  std::string former_output_;
};

}  // namespace tims::test
