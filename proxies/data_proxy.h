// Proxies of components that produce data: asked for, or as a stream.
#pragma once

#include "proxies/codec/codec.h"
#include "proxies/proxy.h"
#include "proxies/stream.h"

namespace rack {

template <Struct DataType>
class DataProxy : public Proxy {
 public:
  using Data = DataType;
  using Proxy::Proxy;

  // The data of that time, as near as there is; 0: the newest.
  Result<void> get_data(Data& data, TimeStamp time = 0) {
    static constexpr i8 kAnswers[] = {tims::type::kData};
    return read(ask(tims::type::kGetData, GetDataRequest{time}, kAnswers, data_timeout()), data);
  }
  Result<Data> get_data(TimeStamp time = 0) {
    return filled([&](Data& data) { return get_data(data, time); });
  }

  // The next that will be produced: `timeout` should be longer than the component's period.
  Result<void> get_next_data(Data& data, tims::Duration timeout) {
    static constexpr i8 kAnswers[] = {tims::type::kData};
    return read(ask(tims::type::kGetNextData, kAnswers, timeout), data);
  }
  Result<Data> get_next_data(tims::Duration timeout) {
    return filled([&](Data& data) { return get_next_data(data, timeout); });
  }
  Result<Data> get_next_data() { return get_next_data(data_timeout()); }

  // A message of the stream that get_cont_data() has asked for: see stream.h.
  Result<void> decode_stream(const tims::PeekGuard& message, Data& data) const {
    return decode_data({message.header(), message.body()}, component(), data);
  }

 private:
  template <typename Fill>
  static Result<Data> filled(Fill fill) {
    Data data{};
    if (const auto good = fill(data); !good) return good.error();
    return data;
  }
};

}  // namespace rack
