// Tasks in text form (specification, section 9.24).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct PlannerType {
  enum : i8 {
    kCommand = 21,     // PlannerCommand; also the reply to kGetCommand
    kGetCommand = 22,  // answered by kCommand
  };
};

struct PlannerString {
  i32 stringLen = 0;
  Text<80> text = {};

  // A text that is too long is truncated.
  static PlannerString of(std::string_view text) {
    PlannerString string;
    (void)string.text.assign(text);
    string.stringLen = static_cast<i32>(string.text.view().size());
    return string;
  }
};

struct PlannerData {
  TimeStamp recordingTime = 0;
  i32 state = 0;
  Count messageNum = {};
  Sequence<PlannerString, 50> messages = {};

  static constexpr std::size_t kWholeSize = 12 + 50 * 84;  // C programs send all entries
};

struct PlannerCommand {
  Count commandNum = {};
  Sequence<PlannerString, 50> commands = {};

  static constexpr std::size_t kWholeSize = 4 + 50 * 84;
};

class PlannerProxy : public DataProxy<PlannerData, tims::class_id::kPlanner> {
 public:
  using DataProxy::DataProxy;

  Result<void> send_command(const PlannerCommand& commands) {
    return command(PlannerType::kCommand, commands);
  }
  Result<PlannerCommand> get_command() {
    return query<PlannerCommand>(PlannerType::kGetCommand, PlannerType::kCommand);
  }
};

}  // namespace rack
