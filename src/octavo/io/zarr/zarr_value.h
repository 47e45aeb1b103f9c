// The JSON of zarr hierarchies, from strangers: a value that is taken apart where it is asked for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace octavo {

/// A value of a file, or one that is not there. What is of another form than asked for is not
/// there either.
class ZarrValue {
 public:
  ZarrValue() = default;
  /// json  a whole text
  /// path  of its file, for messages
  /// Throws Error{source_rejected} naming the file for what is no JSON, as each of these does
  ZarrValue(std::string json, std::string path);

  bool is_there() const { return !json_.empty(); }
  bool is_null() const { return json_ == "null"; }
  const std::string& json() const { return json_; }
  const std::string& path() const { return path_; }

  /// A member of an object.
  ZarrValue at(std::string_view name) const;
  /// The names of an object's members.
  std::vector<std::string> names() const;
  /// The values of a list.
  std::vector<ZarrValue> items() const;
  std::optional<std::string> text() const;
  std::optional<std::int64_t> whole() const;
  std::optional<double> number() const;
  std::optional<bool> boolean() const;
  /// A list of whole numbers; nothing where one of them is none.
  std::optional<std::vector<std::int64_t>> wholes() const;
  std::optional<std::vector<double>> numbers() const;

  /// Throws Error{source_rejected} that names the file.
  [[noreturn]] void reject(const std::string& why) const;

 private:
  std::string json_;
  std::string path_;
};

}  // namespace octavo
