#include "wire/local_protocol.h"

#include <algorithm>
#include <concepts>
#include <cstring>
#include <tuple>
#include <type_traits>
#include <utility>

// A record: u16 kind, u16 zero, u32 request, then its fields without gaps. Numbers are in native
// byte order, a bool is a byte 0 or 1, a text or a list is a u16 count and its elements. The
// encoding is unique: a decoded record encodes to the same bytes again.
namespace tims::wire {
namespace {

// The fields of every record, in the order of encoding.
template <typename Owner>
struct TextField {
  std::string Owner::*member;
  std::size_t max;
};
template <typename Owner>
TextField(std::string Owner::*, std::size_t) -> TextField<Owner>;  // clang-16 cannot deduce it
template <typename T>
constexpr std::tuple<> none() {
  static_assert(std::is_empty_v<T>, "a record whose fields are not listed below");
  return {};
}
template <typename T>
inline constexpr auto kFields = none<T>();
template <>
inline constexpr auto kFields<AddressWidths> =
    std::tuple(&AddressWidths::system, &AddressWidths::class_id, &AddressWidths::instance,
               &AddressWidths::local);
template <>
inline constexpr auto kFields<MailboxPlace> =
    std::tuple(&MailboxPlace::segment, &MailboxPlace::offset);
template <>
inline constexpr auto kFields<Hello> = std::tuple(
    &Hello::version_min, &Hello::version_max, &Hello::writer, TextField{&Hello::name, kNameMax});
template <>
inline constexpr auto kFields<Welcome> =
    std::tuple(&Welcome::version, &Welcome::writer, &Welcome::router, &Welcome::epoch,
               &Welcome::message_max, &Welcome::widths);
template <>
inline constexpr auto kFields<Refused> = std::tuple(TextField{&Refused::text, kTextMax});
template <>
inline constexpr auto kFields<OfferSegment> = std::tuple(&OfferSegment::segment);
template <>
inline constexpr auto kFields<OpenEntry> =
    std::tuple(&OpenEntry::address, &OpenEntry::place, &OpenEntry::has_waker);
template <>
inline constexpr auto kFields<Open> = std::tuple(&Open::entries);
template <>
inline constexpr auto kFields<OpenedEntry> =
    std::tuple(&OpenedEntry::address, &OpenedEntry::status);
template <>
inline constexpr auto kFields<Opened> =
    std::tuple(&Opened::entries, TextField{&Opened::text, kTextMax});
template <>
inline constexpr auto kFields<Close> = std::tuple(&Close::addresses);
template <>
inline constexpr auto kFields<Lookup> = std::tuple(&Lookup::addresses);
template <>
inline constexpr auto kFields<Found> =
    std::tuple(&Found::address, &Found::local, &Found::place, &Found::has_waker);
template <>
inline constexpr auto kFields<Uplink> = std::tuple(&Uplink::place);
template <>
inline constexpr auto kFields<Moved> = std::tuple(&Moved::address);

class Writer {
 public:
  explicit Writer(std::vector<std::byte>& out) : out_(out) {}

  template <std::unsigned_integral T>
  void put(T number) {
    const std::size_t at = out_.size();
    out_.resize(at + sizeof number);
    std::memcpy(out_.data() + at, &number, sizeof number);
  }
  void put(bool yes) { put(static_cast<std::uint8_t>(yes ? 1 : 0)); }
  void put(Address address) { put(address.raw()); }
  void put(OpenStatus status) { put(static_cast<std::uint32_t>(status)); }
  template <typename T>
  void put(const std::vector<T>& list) {
    const std::size_t count = std::min(list.size(), kBatchMax);
    put(static_cast<std::uint16_t>(count));
    for (std::size_t i = 0; i < count; ++i) put(list[i]);
  }
  template <typename T>
    requires std::is_class_v<T>
  void put(const T& fields) {
    std::apply([&](auto... field) { (put_field(fields, field), ...); }, kFields<T>);
  }

 private:
  template <typename T, typename Field>
  void put_field(const T& owner, Field T::*field) {
    put(owner.*field);
  }
  template <typename T>
  void put_field(const T& owner, TextField<T> text) {
    const std::string_view whole = owner.*text.member;
    const std::string_view kept = whole.substr(0, text.max);
    put(static_cast<std::uint16_t>(kept.size()));
    const auto bytes = std::as_bytes(std::span(kept));
    out_.insert(out_.end(), bytes.begin(), bytes.end());
  }

  std::vector<std::byte>& out_;
};

// After the first problem nothing more is read, and later values keep their defaults.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <std::unsigned_integral T>
  void get(T& number) {
    if (bytes_.size() < sizeof number) return fail("a record that ends too early");
    std::memcpy(&number, bytes_.data(), sizeof number);
    bytes_ = bytes_.subspan(sizeof number);
  }
  void get(bool& yes) {
    std::uint8_t byte = 0;
    get(byte);
    if (byte > 1) return fail("a yes or no that is neither");
    yes = byte == 1;
  }
  void get(Address& address) {
    std::uint32_t raw = 0;
    get(raw);
    address = Address(raw);
  }
  void get(OpenStatus& status) {
    std::uint32_t number = 0;
    get(number);
    if (number > static_cast<std::uint32_t>(OpenStatus::kNotTried)) return fail("unknown status");
    status = static_cast<OpenStatus>(number);
  }
  void get(AddressWidths& widths) {
    get<AddressWidths>(widths);
    if (!widths.valid()) fail("address fields that are not 32 bits");
  }
  // Memory is allocated only for elements that have arrived: the count itself is not trusted.
  template <typename T>
  void get(std::vector<T>& list) {
    std::uint16_t count = 0;
    get(count);
    if (count > kBatchMax) return fail("a list that is too long");
    for (std::size_t i = 0; i < count && problem_.empty(); ++i) get(list.emplace_back());
  }
  template <typename T>
    requires std::is_class_v<T>
  void get(T& fields) {
    std::apply([&](auto... field) { (get_field(fields, field), ...); }, kFields<T>);
  }

  void expect_end() {
    if (!bytes_.empty()) fail("bytes behind the record");
  }
  void fail(std::string_view problem) {
    bytes_ = {};
    if (problem_.empty()) problem_ = problem;
  }
  [[nodiscard]] std::string_view problem() const { return problem_; }

 private:
  template <typename T, typename Field>
  void get_field(T& owner, Field T::*field) {
    get(owner.*field);
  }
  template <typename T>
  void get_field(T& owner, TextField<T> text) {
    std::uint16_t size = 0;
    get(size);
    if (size > text.max) return fail("a text that is too long");
    if (size > bytes_.size()) return fail("a record that ends too early");
    (owner.*text.member).assign(reinterpret_cast<const char*>(bytes_.data()), size);
    bytes_ = bytes_.subspan(size);
  }

  std::span<const std::byte> bytes_;
  std::string_view problem_;
};

// The kind is the index in Record, counted from 1: append new records to the list.
template <std::size_t... kIndex>
bool get_record(Reader& reader, std::size_t index, Record& record,
                std::index_sequence<kIndex...> /*all*/) {
  return ((index == kIndex && (reader.get(record.emplace<kIndex>()), true)) || ...);
}

}  // namespace

void encode(const Packet& packet, std::vector<std::byte>& out) {
  Writer writer(out);
  writer.put(static_cast<std::uint16_t>(packet.record.index() + 1));
  writer.put(std::uint16_t{0});
  writer.put(packet.request);
  std::visit([&writer](const auto& record) { writer.put(record); }, packet.record);
}

Decoded decode(std::span<const std::byte> bytes) {
  Reader reader(bytes);
  std::uint16_t kind = 0;
  std::uint16_t zero = 0;
  Packet packet;
  reader.get(kind);
  reader.get(zero);
  reader.get(packet.request);
  if (zero != 0) reader.fail("a record from another version");
  constexpr auto kAll = std::make_index_sequence<std::variant_size_v<Record>>();
  const std::size_t index = std::size_t{kind} - 1;
  if (!get_record(reader, index, packet.record, kAll)) reader.fail("unknown kind of record");
  reader.expect_end();
  if (!reader.problem().empty()) return {std::nullopt, reader.problem()};
  return {std::move(packet), {}};
}

}  // namespace tims::wire
