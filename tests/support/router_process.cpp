#include "tests/support/router_process.h"

#include <csignal>

namespace tims::test {

namespace {

// The endpoint at the end of "... listening tcp 127.0.0.1:40312".
std::string last_field(const std::string& line) { return line.substr(line.rfind(' ') + 1); }

}  // namespace

RouterProcess::RouterProcess(std::vector<std::string> settings) : settings_(std::move(settings)) {}

Result<void> RouterProcess::start() {
  // A restarted router uses the same port, so that clients find it.
  const std::string tcp = tcp_.empty() ? "127.0.0.1:0" : tcp_;
  std::vector<std::string> command{TIMS_ROUTER_PROGRAM};
  for (const std::string& setting :
       {"unix.path=" + socket_path(), "tcp.listen=" + tcp, std::string("http.listen=off"),
        lifesign_interval(std::chrono::seconds(5))})
    command.insert(command.end(), {"--set", setting});
  bool with_http = false;
  for (const std::string& setting : settings_) {
    command.insert(command.end(), {"--set", setting});
    with_http |= setting.starts_with("http.listen=127");
  }
  auto started = ChildProcess::start(std::move(command));
  if (!started) return started.error();
  process_.emplace(std::move(*started));
  auto unix_line = process_->wait_for_line("listening unix");
  if (!unix_line) return unix_line.error();
  auto tcp_line = process_->wait_for_line("listening tcp");
  if (!tcp_line) return tcp_line.error();
  tcp_ = last_field(*tcp_line);
  if (!with_http) return {};
  auto http_line = process_->wait_for_line("listening http");
  if (!http_line) return http_line.error();
  http_ = last_field(*http_line);
  return {};
}

void RouterProcess::kill() { (void)process_->stop(SIGKILL); }

Result<ExitStatus> RouterProcess::stop() { return process_->stop(SIGTERM); }

}  // namespace tims::test
