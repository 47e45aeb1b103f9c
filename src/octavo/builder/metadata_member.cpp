#include "octavo/builder/metadata_member.h"

#include <cstddef>
#include <nlohmann/json.hpp>

namespace octavo {

namespace {

using nlohmann::json;

std::string text_of(const std::string& string) {
  return json(string).dump(-1, ' ', false, json::error_handler_t::replace);
}

// Writes the values it gets, but for the members `name` of the outermost object. No tree is
// made of them: one of arrays and objects allocates when it is destroyed, and ends the program
// where there is no memory left.
class Rewriter : public json::json_sax_t {
 public:
  explicit Rewriter(const std::string& name) : name_(name) {}

  bool is_object() const { return !text_.empty() && text_.front() == '{'; }
  const std::string& text() const { return text_; }

  bool null() override { return value("null"); }
  bool boolean(bool value_of) override { return value(value_of ? "true" : "false"); }
  bool number_integer(number_integer_t number) override { return value(std::to_string(number)); }
  bool number_unsigned(number_unsigned_t number) override {
    return value(std::to_string(number));
  }
  bool number_float(number_float_t, const string_t& written) override { return value(written); }
  bool string(string_t& string) override { return value(text_of(string)); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open('{'); }
  bool end_object() override { return close('}'); }
  bool start_array(std::size_t) override { return open('['); }
  bool end_array() override { return close(']'); }

  bool key(string_t& key) override {
    if (dropping_ > 0) return true;
    if (depth_ == 1 && key == name_) {
      dropping_ = depth_ + 1;
      return true;
    }
    separate();
    text_ += text_of(key) + ":";
    needs_comma_ = false;
    return true;
  }

  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }

 private:
  void separate() {
    if (needs_comma_) text_ += ',';
    needs_comma_ = true;
  }

  // A value inside, or behind the last one, of what is dropped.
  bool take_dropped() {
    if (dropping_ == 0) return false;
    if (depth_ + 1 == dropping_) dropping_ = 0;
    return true;
  }

  bool value(const std::string& text) {
    if (take_dropped()) return true;
    separate();
    text_ += text;
    return true;
  }

  bool open(char bracket) {
    if (dropping_ == 0) {
      separate();
      text_ += bracket;
      needs_comma_ = false;
    }
    ++depth_;
    return true;
  }

  bool close(char bracket) {
    --depth_;
    if (take_dropped()) return true;
    text_ += bracket;
    needs_comma_ = true;
    return true;
  }

  const std::string& name_;
  std::string text_;
  bool needs_comma_ = false;
  int depth_ = 0;
  int dropping_ = 0;  // one more than the depth of the member that is dropped; 0: none is
};

}  // namespace

std::string with_member(const std::string& metadata, const std::string& name,
                        const std::string& value) {
  Rewriter rewriter(name);
  if (!json::sax_parse(metadata, &rewriter) || !rewriter.is_object()) return metadata;
  std::string text = rewriter.text();
  text.pop_back();
  return text + (text.size() > 1 ? "," : "") + text_of(name) + ":" + value + "}";
}

}  // namespace octavo
