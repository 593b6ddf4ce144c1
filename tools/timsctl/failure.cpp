#include "tools/timsctl/failure.h"

namespace timsctl {

using tims::Errc;

namespace {

Exit exit_of(Errc code) {
  switch (code) {
    case Errc::kNoRouter:
    case Errc::kClosed:
      return Exit::kNoRouter;
    case Errc::kTimeout:
      return Exit::kTimeout;
    case Errc::kNoMailbox:
      return Exit::kNoSuch;
    case Errc::kRefused:
    case Errc::kAddressInUse:
      return Exit::kDenied;
    case Errc::kVersion:
    case Errc::kBadLayout:
      return Exit::kVersion;
    case Errc::kInvalidArgument:
      return Exit::kUsage;
    default:
      return Exit::kNo;
  }
}

std::string hint_of(Errc code) {
  switch (code) {
    case Errc::kNoRouter:
    case Errc::kClosed:
      return "start one with `tims-router`, or name another with -H; `timsctl doctor` looks closer";
    case Errc::kTimeout:
      return "a longer --timeout, or `timsctl doctor`";
    case Errc::kNoMailbox:
      return "`timsctl mbx list` shows all";
    case Errc::kAddressInUse:
      return "`timsctl mbx show ADDR` names the owner";
    case Errc::kFull:
      return "the receiver does not keep up; `timsctl mbx show ADDR` shows what waits";
    case Errc::kTooBig:
      return "`timsctl mbx show ADDR` shows the largest message it takes";
    case Errc::kVersion:
    case Errc::kBadLayout:
      return "install timsctl and tims-router of the same version";
    default:
      return {};
  }
}

}  // namespace

Failure usage_error(std::string message, std::string hint) {
  return {Exit::kUsage, "usage", std::move(message), std::move(hint)};
}

Failure failure_of(const tims::Error& error, const std::string& where) {
  std::string message = error.message();
  if (!where.empty() && message.find(where) == std::string::npos) message = where + ": " + message;
  return {exit_of(error.code()), std::string(tims::name(error.code())), std::move(message),
          hint_of(error.code())};
}

}  // namespace timsctl
