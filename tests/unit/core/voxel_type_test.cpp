#include "octavo/core/voxel_type.h"

#include <gtest/gtest.h>

#include <string>

namespace octavo {
namespace {

constexpr VoxelType kTypes[] = {VoxelType::int8,   VoxelType::uint8, VoxelType::int16,
                                VoxelType::uint16, VoxelType::int32, VoxelType::uint32,
                                VoxelType::float32};

TEST(VoxelType, NamesLeadBack) {
  for (const VoxelType type : kTypes) {
    const std::string name(voxel_type_name(type));
    EXPECT_EQ(parse_voxel_type(name), type) << name;
    const std::string bits = name.substr(name.find_first_of("123456789"));
    EXPECT_EQ(parse_voxel_type(name.substr(0, 1) + bits), type) << name;
  }
  for (const char* name : {"", "int", "i64", "Int8", "int8 ", "unknown"}) {
    EXPECT_FALSE(parse_voxel_type(name)) << name;
  }
  EXPECT_EQ(voxel_type_name(VoxelType{0}), "unknown");
  EXPECT_EQ(voxel_type_name(VoxelType{8}), "unknown");
}

TEST(VoxelType, IsTheTypeOfItsNumbers) {
  for (const VoxelType type : kTypes) {
    EXPECT_TRUE(is_valid(type));
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      EXPECT_EQ(voxel_type_of<T>(), type);
      EXPECT_EQ(bytes_per_voxel(type), static_cast<std::int64_t>(sizeof(T)));
      EXPECT_EQ(is_integer(type), std::is_integral_v<T>);
    });
  }
}

TEST(VoxelType, ARangeIsThatOfTheIntegers) {
  EXPECT_EQ(value_range(VoxelType::int8), (ValueRange{-128, 127}));
  EXPECT_EQ(value_range(VoxelType::uint8), (ValueRange{0, 255}));
  EXPECT_EQ(value_range(VoxelType::int16), (ValueRange{-32768, 32767}));
  EXPECT_EQ(value_range(VoxelType::uint16), (ValueRange{0, 65535}));
  EXPECT_EQ(value_range(VoxelType::int32), (ValueRange{-2147483648, 2147483647}));
  EXPECT_EQ(value_range(VoxelType::uint32), (ValueRange{0, 4294967295}));
  EXPECT_THROW(value_range(VoxelType::float32), Error);
}

TEST(VoxelType, AByteOfAFileMayNameNone) {
  for (const int value : {0, 8, 255}) {
    const auto type = static_cast<VoxelType>(value);
    EXPECT_FALSE(is_valid(type)) << value;
    EXPECT_THROW(with_voxel_type(type, [](auto) {}), Error) << value;
  }
}

}  // namespace
}  // namespace octavo
