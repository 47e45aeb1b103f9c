#include "octavo/io/source/value_unit.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(ValueUnit, FilesHoldTheCodeAndPeopleReadTheUnit) {
  const struct {
    const char* written;
    const char* code;
    const char* shown;
  } cases[] = {{"HU", "[hnsf'U]", "HU"},     {"1/cm", "cm-1", "cm-1"}, {"MG/ML", "mg/mL", "mg/mL"},
               {"bqml", "Bq/mL", "Bq/mL"},   {"ppm", "[ppm]", "ppm"},  {"percent", "%", "%"},
               {"SUV", "{SUV}", "SUV"},      {"mT", "mT", "mT"},       {"", "", ""}};
  for (const auto& c : cases) {
    EXPECT_EQ(unit_code(c.written), c.code);
    EXPECT_EQ(shown_unit(c.code), c.shown);
  }
  // Other texts, which metadata may hold, are shown as they are.
  for (const char* text : {"HU", "{}", "{", "furlong"}) EXPECT_EQ(shown_unit(text), text);
}

TEST(ValueUnit, OnlyKnownUnitsOfStrangersAreKept) {
  for (const char* unit : {"mg/ml", "MG/ML", "od", "HU", "%"}) {
    EXPECT_EQ(known_value_unit(unit), unit);
  }
  EXPECT_EQ(known_value_unit("Hounsfield Units"), "HU");
  for (const char* text : {"", "John Smith", "[hnsf'U]", "{suv}"}) {
    EXPECT_EQ(known_value_unit(text), "") << text;
  }
}

}  // namespace
}  // namespace octavo
