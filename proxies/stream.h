// Messages of a data stream, as they arrive in the data mailbox.
#pragma once

#include "proxies/codec/codec.h"
#include "tims/address.h"
#include "tims/message.h"

namespace rack {

// Whether this is data of `producer`, and if not, why:
//   kAnsweredError    the producer went off or failed, and has forgotten its listeners: ask again
//   kInvalidArgument  a message of somebody else, or no data
Result<void> check_data(const tims::Header& header, tims::Address producer);

// check_data(), and the data itself (kMalformed). Allocates nothing when `data` has the room.
template <Struct Data>
Result<void> decode_data(const tims::MessageView& message, tims::Address producer, Data& data) {
  if (auto good = check_data(message.header, producer); !good) return good;
  return decode(message, data);
}

}  // namespace rack
