// What GDCM does for the DICOM reader: compressed pictures and the names of elements.
//
// Its dictionary costs more than the start of everything else, so it is part of a shared library
// that is loaded when the first DICOM file asks for it. Where OCTAVO_GDCM_LIBRARY is not defined,
// as in the Python wheel, it is linked in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "octavo/io/dicom/dicom_file.h"

namespace octavo {

/// A compressed picture of one sample per pixel, as the header describes it.
struct CodedPicture {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::int64_t bits_allocated = 0;
  std::int64_t bits_stored = 0;
  std::int64_t high_bit = 0;
  bool is_signed = false;
  std::string transfer_syntax;
  std::vector<std::vector<std::byte>> fragments;
};

/// words  what people or programs chose: names, identifiers, notes; text: dates, codes, numbers
enum class DicomContent { words, text, binary };

class DicomLibrary {
 public:
  /// Decodes into `plane` where that has as many bytes as the picture.
  /// bytes    of the picture, by its header
  /// Returns  false where it cannot be decoded
  virtual bool decode(const CodedPicture& picture, std::span<std::byte> plane,
                      std::size_t& bytes) const = 0;
  /// Empty for tags that the dictionary lacks.
  virtual std::string keyword(DicomTag tag) const = 0;
  /// Binary for tags that the dictionary lacks.
  virtual DicomContent content(DicomTag tag) const = 0;

 protected:
  ~DicomLibrary() = default;
};

/// Loads it where that was not done yet. Threads may call this at once.
/// Throws Error{io} where the shared library is not installed
const DicomLibrary& dicom_library();

}  // namespace octavo
