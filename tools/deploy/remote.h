// One host over OpenSSH's ssh, as its user has configured it: a connection that is kept (a control
// master), and commands over it. Nothing here waits.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "os/file.h"
#include "tools/cli/service.h"

namespace timsctl::deploy {

extern const std::string_view kOnHost;  // on_host.sh

// A text as one word of a POSIX shell, whatever it contains.
std::string in_shell_quotes(std::string_view text);

class Remote {
 public:
  // `socket`: path for the socket of the connection, in a folder of this user alone.
  Remote(std::string ssh, std::string socket) : ssh_(std::move(ssh)), socket_(std::move(socket)) {}
  // Ends the connection and what runs over it; the job of a deployment goes on.
  ~Remote() { disconnect(); }
  Remote(Remote&&) noexcept = default;
  Remote& operator=(Remote&&) = delete;

  // Throw Failure: ssh cannot be executed.
  void connect();
  void run(const std::vector<std::string>& words, std::string_view input);
  void end_command();
  void disconnect();

  // Readable when there is something to take.
  [[nodiscard]] std::vector<int> descriptors() const;

  enum class Event { kNone, kConnected, kLost, kEnded };
  // kLost: the connection has ended or was not made, errors() says why. kEnded: the command has,
  // with status(), output() and errors().
  Event take();
  [[nodiscard]] int status() const { return status_; }
  [[nodiscard]] const std::string& output() const { return output_; }  // also while it runs
  [[nodiscard]] const std::string& errors() const { return errors_; }

 private:
  struct Stream {
    tims::os::File file{};
    void read_into(std::string& text, std::size_t bytes_max);
  };
  static Stream stream_of(tims::os::Pipe& pipe);

  std::string ssh_;
  std::string socket_;
  Child master_{};
  tims::os::File hold_{};  // stdin of the master: when it closes, the connection ends
  Stream master_out_{};
  Stream master_err_{};
  std::string greeting_{};
  std::string master_errors_{};
  bool connected_ = false;
  Child command_{};
  Stream out_{};
  Stream err_{};
  std::string output_{};
  std::string errors_{};
  int status_ = 0;
};

}  // namespace timsctl::deploy
