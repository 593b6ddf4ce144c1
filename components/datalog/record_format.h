// The files of a recording, as the original has them (specification, section 11): the list of what
// is recorded, and what becomes of a message. Pure.
#pragma once

#include <charconv>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rack/codec/codec.h"
#include "rack/codec/schema.h"
#include "rack/proxies/datalog.h"
#include "tims/message.h"
#include "tims/result.h"

namespace rack::datalog {

// Numbers of a message as a line of text, separated by blanks.
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
      number(reflect::field_of<sequence_of_count<T, I>()>(value).size());
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

// What is written for one message.
struct Record {
  std::string line{};         // of the .dat file
  std::string_view suffix{};  // of a file of its own, ".2d"; empty: none
  std::string file{};
  std::string_view raw_suffix{};  // of another one
  std::string raw{};
};

struct RecordedClass {
  std::uint32_t class_id;
  std::string_view title;    // in its files: "Scan2d"
  std::string_view name;     // of its files: "scan2d"
  std::int32_t instances;    // in the built-in list: from 0 on
  std::size_t body_max;      // bytes
  std::string_view columns;  // the second line of its files
  // file_number: of the file of its own, if there is one. Of a class that was made known: null.
  tims::Result<Record> (*record)(const tims::MessageView& message, std::uint32_t file_number,
                                 bool binary_io);
  const Schema* data = nullptr;
};
tims::Result<Record> record(const RecordedClass& recorded, const tims::MessageView& message,
                            std::uint32_t file_number, bool binary_io);

// In the order of the built-in list. Behind those of the original come the data of all classes that
// were made known (add_class() of the catalogue) before this is called: all their fields, one
// instance.
std::span<const RecordedClass> recorded_classes();
const RecordedClass* recorded_class(std::uint32_t class_id);  // nullptr: is not recorded

// The first two lines of a file.
std::string heading(const RecordedClass& recorded, tims::Address module,
                    const tims::AddressWidths& widths = {});

// What is to be recorded, as a list in a file: lines of an address in hexadecimal, a blank, a file
// name; an empty line, or the end, ends it. Nothing is recorded until SET_LOG says so. kMalformed
// says in which line.
tims::Result<std::vector<DatalogLogInfo>> read_list(std::string_view text,
                                                    const tims::AddressWidths& widths = {});

// Path and name without what follows its last dot: files of single messages are called so.
std::string base_of(const std::string& path);

}  // namespace rack::datalog
