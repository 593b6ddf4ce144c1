// One module that is recorded: its stream and its file.
#pragma once

#include <string>

#include "components/datalog/record_format.h"
#include "components/files/log_file.h"
#include "rack/proxies/datalog.h"
#include "rack/proxies/proxy.h"
#include "rack/text_log.h"
#include "tims/time.h"

namespace rack::datalog {

class Recorder {
 public:
  // `stream`: where its data shall go.
  Recorder(DatalogLogInfo& info, const RecordedClass& recorded, tims::Mailbox& work,
           tims::Address stream)
      : info_(&info),
        recorded_(&recorded),
        proxy_(work, info.moduleMbx, {.data = std::chrono::seconds(1)}),
        stream_(stream),
        widths_(work.address_widths()) {}

  [[nodiscard]] tims::Address module() const { return proxy_.component(); }
  [[nodiscard]] std::chrono::milliseconds period() const { return period_; }

  Result<void> create(const std::string& path);
  // Turns the module on, and makes it send.
  Result<void> subscribe(tims::Time now);
  void stop() { (void)proxy_.stop_cont_data(stream_); }

  // A message of its stream. What cannot be written is said once, and left out.
  void take(const tims::MessageView& message, tims::Time now, bool binary_io, TextLog& log);
  // Whether nothing has come for long: it may have been started anew, and must be asked again.
  [[nodiscard]] bool is_silent(tims::Time now) const;
  void ask_again(tims::Time now, TextLog& log);

 private:
  Result<void> write(const Record& record);

  DatalogLogInfo* info_;
  const RecordedClass* recorded_;
  Proxy proxy_;
  tims::Address stream_;
  tims::AddressWidths widths_;
  std::string base_;
  LogFile file_;
  std::chrono::milliseconds period_{};
  tims::Time heard_{};
  tims::Time asked_{};
  bool ended_ = false;    // said that it has no data now
  bool failing_ = false;  // the last one was not written
};

}  // namespace rack::datalog
