// DICOM slices in compressed transfer syntaxes, made by GDCM.
#pragma once

#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gdcmSequenceOfFragments.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "support/dicom_samples.h"
#include "support/source_files.h"

namespace octavo::testing {

/// The picture of a file in a transfer syntax.
inline std::string coded_picture_of(const std::string& path,
                                    gdcm::TransferSyntax::TSType syntax) {
  gdcm::ImageReader reader;
  reader.SetFileName(path.c_str());
  EXPECT_TRUE(reader.Read());
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(syntax);
  change.SetInput(reader.GetImage());
  EXPECT_TRUE(change.Change());
  const gdcm::SequenceOfFragments* all =
      change.GetOutput().GetDataElement().GetSequenceOfFragments();
  const gdcm::ByteValue* first = all->GetFragment(0).GetByteValue();
  return {first->GetPointer(), first->GetLength()};
}

/// The bytes of `sample` as a slice of 32 x 32 voxels in a transfer syntax.
inline std::string coded_slice(const TempFolder& folder, DicomSample sample,
                               gdcm::TransferSyntax::TSType syntax) {
  sample.rows = 32;
  sample.columns = 32;
  std::vector<std::int16_t> voxels(1024);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = static_cast<std::int16_t>(i * i % 997);
  }
  sample.voxels = bytes_of(voxels);
  write_dicom(folder.file("plain.dcm"), sample);
  gdcm::ImageReader reader;
  reader.SetFileName(folder.file("plain.dcm").c_str());
  EXPECT_TRUE(reader.Read());
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(syntax);
  change.SetInput(reader.GetImage());
  EXPECT_TRUE(change.Change());
  gdcm::ImageWriter writer;
  writer.SetFile(reader.GetFile());
  writer.SetImage(change.GetOutput());
  writer.SetFileName(folder.file("coded.dcm").c_str());
  EXPECT_TRUE(writer.Write());
  return read_file(folder.file("coded.dcm"));
}

}  // namespace octavo::testing
