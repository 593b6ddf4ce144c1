// Numbers of a message as a line of text, separated by blanks (specification, section 11). Pure.
#pragma once

#include <charconv>
#include <string>
#include <string_view>

#include "rack/codec/codec.h"

namespace rack::datalog {

class RecordLine {
 public:
  // A struct field by field, each sequence element by element; its Count is a number of its own.
  template <typename T>
  void add(const T& value) {
    if constexpr (WrappedNumber<T>) {
      number(value.raw());
    } else if constexpr (Number<T>) {
      number(value);
    } else if constexpr (kIsArray<T> || kIsVariable<T>) {
      for (const auto& element : value) add(element);
    } else {
      reflect::all_fields(value, [&](const auto& field, auto index) {
        add_field<index>(value, field);
        return true;
      });
    }
  }
  // Ends a line; more may follow.
  void end() { text_ += '\n'; }

  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  template <std::size_t I, typename T, typename Field>
  void add_field(const T& value, const Field& field) {
    if constexpr (kIsCount<Field>) {
      number(boost::pfr::get<sequence_of_count<T, I>()>(value).size());
    } else {
      add(field);
    }
  }

  template <typename T>
  void number(T value) {
    char digits[400];
    std::to_chars_result result{};
    if constexpr (std::is_floating_point_v<T>) {
      constexpr int kDecimals =
          sizeof(T) == sizeof(double) ? 16 : 6;  // doubles are places on Earth
      result =
          std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed, kDecimals);
    } else if constexpr (sizeof(T) == 1) {
      result = std::to_chars(digits, digits + sizeof digits, static_cast<int>(value));
    } else {
      result = std::to_chars(digits, digits + sizeof digits, value);
    }
    if (!text_.empty() && text_.back() != '\n') text_ += ' ';
    text_.append(digits, result.ptr);
  }

  std::string text_;
};

}  // namespace rack::datalog
