// gdos-log at the test's own router, writing to a temporary folder.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "proxies/gdos_texts.h"
#include "rack/proxies/gdos_log.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {

using testing::HasSubstr;
using testing::Not;

class GdosLogTest : public ModulesTest {
 protected:
  static constexpr std::uint32_t kLog = 0x00010100;  // GDOS(0/1)

  [[nodiscard]] std::filesystem::path folder() const { return temporary_.path() / "log"; }

  ChildProcess& start_log(std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"--directory=" + folder().string(), "--syncTime=10"});
    ChildProcess& log = start("gdos-log", std::move(more));
    const auto ready = log.wait_for_line("Texts are kept in");
    EXPECT_TRUE(ready) << ready.error().message();
    return log;
  }
  // The contents of all files, oldest first.
  [[nodiscard]] std::string kept() const {
    std::string all;
    for (const auto& path : rack::gdos::log_paths(folder())) {
      std::ifstream file(path);
      all.append(std::istreambuf_iterator<char>(file), {});
    }
    return all;
  }
  // Waits until the files contain `part`; a failure shows their contents.
  testing::AssertionResult comes_to_be_kept(const std::string& part) const {
    return eventually([&]() -> std::string {
      const std::string all = kept();
      return all.find(part) == std::string::npos ? "\"" + part + "\" is not in\n" + all : "";
    });
  }
  // Sends a text without arguments from the test's mailbox.
  void send_text(const std::string& text, rack::gdos::Level level = rack::gdos::Level::kWarning) {
    const auto sent =
        work_->send({.dest = text_sink(), .type = static_cast<std::int8_t>(level)}, bytes_of(text));
    EXPECT_TRUE(sent) << sent.error().message();
  }
  Result<ChildProcess> timsctl(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {TIMSCTL_PROGRAM, "-H", "unix:" + router_.socket_path(),
                                         "--timeout", std::to_string(kPatienceMs) + "ms"});
    return ChildProcess::start(std::move(arguments));
  }
  // The output of `timsctl log show`, standard output before standard error.
  std::string shown(std::vector<std::string> options, int code = 0) const {
    options.insert(options.begin(), {"log", "show", "--utc", "-D", folder().string()});
    auto child = timsctl(std::move(options));
    EXPECT_TRUE(child);
    const auto status = child->wait();
    EXPECT_TRUE(status && status->code == code) << child->output();
    return child->standard_output() + child->standard_error();
  }

 private:
  TemporaryFolder temporary_;
};

}  // namespace tims::test
