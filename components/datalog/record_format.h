// The files of a recording in the format of the original (specification, section 11): the list of
// recorded components, and the text of a message. Pure.
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

// Formats the numbers of a message as a line of text, separated by blanks.
class RecordLine {
 public:
  // A struct field by field, each sequence element by element; its Count is a separate number.
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
  // Ends the line; more lines may follow.
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
          sizeof(T) == sizeof(double) ? 16 : 6;  // doubles are geographic coordinates
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

// The output for one message.
struct Record {
  std::string line{};         // of the .dat file
  std::string_view suffix{};  // of a separate file, ".2d"; empty: none
  std::string file{};
  std::string_view raw_suffix{};  // of another separate file
  std::string raw{};
};

struct RecordedClass {
  std::uint32_t class_id;
  std::string_view title;    // in the heading of its files: "Scan2d"
  std::string_view name;     // in the names of its files: "scan2d"
  std::int32_t instances;    // number of instances in the built-in list, from 0 on
  std::size_t body_max;      // bytes
  std::string_view columns;  // the second line of its files
  // file_number: of the separate file, if there is one. nullptr for classes from add_class().
  tims::Result<Record> (*record)(const tims::MessageView& message, std::uint32_t file_number,
                                 bool binary_io);
  const Schema* data = nullptr;
};
tims::Result<Record> record(const RecordedClass& recorded, const tims::MessageView& message,
                            std::uint32_t file_number, bool binary_io);

// In the order of the built-in list. After those of the original follow all classes that were added
// (add_class() of the catalogue) before this call: with all their fields and one instance.
std::span<const RecordedClass> recorded_classes();
const RecordedClass* recorded_class(std::uint32_t class_id);  // nullptr: not recorded

// The first two lines of a file.
std::string heading(const RecordedClass& recorded, tims::Address module,
                    const tims::AddressWidths& widths = {});

// The entry of a component in the list, with the usual name of its file. kInvalidArgument: data of
// this class are not recorded.
tims::Result<DatalogLogInfo> log_info(tims::Address module, const tims::AddressWidths& widths = {});

// The entries of components that are given by name: "Thermometer(0/0), Ladar(0/1)".
tims::Result<std::vector<DatalogLogInfo>> modules_of(std::string_view text,
                                                     const tims::AddressWidths& widths = {});

// Applies a list of another length: its entries change or extend the list. An entry without a file
// name keeps the present or the usual one. On an error the list is unchanged.
tims::Result<void> change_list(DatalogData& list, const DatalogData& wanted,
                               const tims::AddressWidths& widths = {});

// Reads the list of recorded components from a file: lines of an address (in hexadecimal, or a name
// such as "Ladar(0/0)"), a blank, a file name; an empty line or the end of the file ends it.
// Recording is disabled until SET_LOG. The error kMalformed names the line.
tims::Result<std::vector<DatalogLogInfo>> read_list(std::string_view text,
                                                    const tims::AddressWidths& widths = {});

// The path without its extension: the prefix of files of single messages.
std::string base_of(const std::string& path);

}  // namespace rack::datalog
