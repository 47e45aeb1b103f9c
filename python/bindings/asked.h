// What Python asks of a task, as the members of a dictionary, and the pictures that it gets.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octavo/core/option_words.h"
#include "octavo/render/picture.h"
#include "octavo/render/window.h"
#include "octavo/tasks/asked_labels.h"
#include "work.h"

namespace octavo::python {

/// The member `name`. Throws nb::cast_error where it is of another type
template <class T>
T asked_for(const nanobind::dict& asked, const char* name) {
  return nanobind::cast<T>(asked[name]);
}

/// Says which words an option takes. Throws Error{invalid_argument}
[[noreturn]] void reject_word(const nanobind::handle& given, const char* name,
                              std::span<const char* const> words);

/// What a word means that is given for the option `name`.
/// Throws Error{invalid_argument} for what is none of those that T has
template <class T>
T value_of_given(const nanobind::handle& given, const char* name) {
  std::vector<const char*> words;
  for (const auto& [word, meaning] : option_words(T())) {
    if (given.equal(nanobind::str(word))) return meaning;
    words.push_back(word);
  }
  reject_word(given, name, words);
}
/// What that of the member `name` means, and of one that may be None.
template <class T>
T asked_word(const nanobind::dict& asked, const char* name) {
  return value_of_given<T>(nanobind::object(asked[name]), name);
}
template <class T>
std::optional<T> asked_word_if(const nanobind::dict& asked, const char* name) {
  return asked[name].is_none() ? std::nullopt : std::optional(asked_word<T>(asked, name));
}

/// The members "labels", by number, and "names".
inline AskedLabels asked_labels(const nanobind::dict& asked) {
  return {asked_for<std::vector<std::int64_t>>(asked, "labels"),
          asked_for<std::vector<std::string>>(asked, "names")};
}

/// Files of (name, file), behind the one that a task is about.
std::vector<NamedFile> named_files(const OpenFile& file, const std::string& name,
                                   const nanobind::list& others);

/// A color of a name or of "#rrggbb". Throws Error{invalid_argument} for other text
Color color_of(const std::string& name);
std::optional<Color> color_of(const std::optional<std::string>& name);

/// The member "window": (low, high) in real values, or None.
std::optional<Window> window_of(const nanobind::dict& asked);

/// All that is written on a picture of any kind, or nothing.
template <class Options>
void set_captions(bool has_text, Options& options) {
  options.has_scale_bar = has_text;
  options.has_sides = has_text;
  options.has_legend = has_text;
}

/// Pictures as arrays of pixels [y, x, 3].
nanobind::object pixels_of(Picture picture);
nanobind::list pixels_of_all(std::vector<Picture>& pictures);

}  // namespace octavo::python
