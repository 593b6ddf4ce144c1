#include "proxies/stream.h"

#include <string>

namespace rack {

Result<void> check_data(const tims::Header& header, tims::Address producer) {
  using tims::Errc;
  using tims::Error;
  if (header.src != producer) {
    return Error(Errc::kInvalidArgument, "a message of " + header.src.to_string() +
                                             " in the stream of " + producer.to_string() +
                                             ": open a data mailbox for each producer");
  }
  if (header.type == tims::type::kError) {
    return Error(Errc::kAnsweredError, producer.to_string() +
                                           " ended its stream (off, or failed): subscribe again "
                                           "when it is on");
  }
  if (header.type != tims::type::kData) {
    return Error(Errc::kInvalidArgument, "type " + std::to_string(header.type) + " of " +
                                             producer.to_string() + " is no data: throw it away");
  }
  return {};
}

}  // namespace rack
