#include "rack/codec/codec.h"

#include <string>

namespace rack::codec {

namespace {

// The reader of the message is usually not able to correct the sender.
constexpr std::string_view kAdvice =
    "; its sender is broken, or has another version of this message";

std::string name(FieldName field_name) {
  return std::string(field_name.type).append(".").append(field_name.field);
}

tims::Error malformed(std::string text) {
  return {tims::Errc::kMalformed, std::move(text.append(kAdvice))};
}

std::string bytes(std::size_t count) { return std::to_string(count) + " bytes"; }

}  // namespace

tims::Error too_short(std::string_view type, std::size_t needed, std::size_t there) {
  return malformed(std::string(type) + " has at least " + bytes(needed) + ", not " + bytes(there));
}

tims::Error surplus(std::string_view type, std::size_t expected, std::size_t there) {
  return malformed(std::string(type) + " is " + bytes(expected) + " long by its own counts, not " +
                   bytes(there));
}

tims::Error bad_count(FieldName field_name, std::int64_t count, std::size_t max) {
  return malformed(name(field_name) + " is " + std::to_string(count) + ", allowed are 0 to " +
                   std::to_string(max));
}

tims::Error elements_missing(FieldName field_name, std::size_t needed, std::size_t there) {
  return malformed(name(field_name) + " needs " + bytes(needed) + ", only " + bytes(there) +
                   " follow");
}

tims::Error too_many(FieldName field_name, std::size_t count, std::size_t max) {
  return {tims::Errc::kInvalidArgument, name(field_name) + " has " + std::to_string(count) +
                                            " elements, allowed are " + std::to_string(max) +
                                            ": send fewer"};
}

tims::Error wrong_tail(FieldName field_name, std::size_t count, std::int64_t stated) {
  return {tims::Errc::kInvalidArgument, name(field_name) + " has " + std::to_string(count) +
                                            " elements, but the other fields give " +
                                            std::to_string(stated) + ": correct one of them"};
}

tims::Error buffer_too_small(std::string_view type, std::size_t needed, std::size_t there) {
  return {tims::Errc::kBufferTooSmall,
          std::string(type) + " needs " + bytes(needed) + ", the buffer has " + bytes(there)};
}

}  // namespace rack::codec
