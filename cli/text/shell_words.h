// Words of lines that a shell takes.
#pragma once

#include <string>

namespace octavo::cli {

/// A word as a shell reads it: quoted where it has letters that mean something to one.
std::string shell_word(const std::string& word);

/// A path as a shell and a program read it: never as an option.
std::string shell_path(const std::string& path);

/// Words as one word of a shell, which reads them again.
std::string quoted_words(const std::string& words);

}  // namespace octavo::cli
