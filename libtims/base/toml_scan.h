// The bytes of every statement, key and value of a valid TOML text. Part of toml_edit; the meaning
// of a text is found by toml.h. Pure.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace tims::base {

struct Span {
  std::size_t begin = 0;
  std::size_t end = 0;

  bool operator==(const Span&) const = default;
};

struct ScannedNode {
  enum class Form : std::uint8_t {
    kValue,
    kArray,        // [1, 2]
    kInlineTable,  // { a = 1 }
    kTable,        // [a], or of a dotted key
    kTables,       // [[a]]
  };

  Form form = Form::kValue;
  std::string key{};             // empty: an element
  bool is_element = false;       // of a list
  ScannedNode* owner = nullptr;  // null: the document. Of a dotted table: the table of its keys
  Span value{};                  // of values, arrays and inline tables
  Span entry{};                  // of a key of an inline table: from the key to the value's end
  std::vector<Span> entries{};   // of an inline table
  // Whole lines: of a key its line; of a table its header and its own keys.
  std::vector<Span> statements{};
  std::size_t body_end = 0;           // of a table: behind its last own line
  bool is_explicit = false;           // has a header, or is an element of [[a]], or the document
  std::vector<std::string> dotted{};  // of a table made by a dotted key: the keys from its owner
  std::vector<std::unique_ptr<ScannedNode>> children{};

  [[nodiscard]] bool is_plain() const { return form == Form::kValue; }
  [[nodiscard]] bool is_list() const { return form == Form::kArray || form == Form::kTables; }
  [[nodiscard]] bool is_dotted() const { return !dotted.empty(); }
  [[nodiscard]] ScannedNode* child(const std::variant<std::string, std::size_t>& step);
  [[nodiscard]] std::size_t place() const;
  [[nodiscard]] const ScannedNode& owner_of_entry() const;
  [[nodiscard]] const ScannedNode& next_of(const ScannedNode& element) const;
  [[nodiscard]] std::vector<Span> all_statements() const;
  [[nodiscard]] std::vector<Span> all_entries() const;
  [[nodiscard]] std::size_t first_statement() const;
  [[nodiscard]] std::size_t last_statement() const;  // behind it
};

struct ScannedToml {
  std::unique_ptr<ScannedNode> root;
  std::vector<Span> statements;  // in the order of the text
  std::size_t begin = 0;         // behind a byte order mark

  // Whether no other statement is between these two.
  [[nodiscard]] bool is_next(std::size_t end, std::size_t next) const;
};

// Precondition: parse_toml() accepts the text.
ScannedToml scan_toml(std::string_view text);

bool is_bare_key_character(char c);
// Bytes of the key at the beginning, with its quotes; 0: there is none.
std::size_t key_size(std::string_view text);
// Without quotes and escapes.
std::optional<std::string> decoded_key(std::string_view written);

}  // namespace tims::base
