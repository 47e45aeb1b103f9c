#include "octavo/core/metadata.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "octavo/core/error.h"
#include "octavo/core/json_reader.h"

namespace octavo {
namespace {

/// All that this program knows, and members that it does not.
const std::string kFull =
    R"({"chosen":{"channel":{"count":3,"index":1,"name":"green"},"time":{"count":2,"index":0}},)"
    R"("dicom":{"KVP":120.0,"Modality":"CT"},)"
    R"("identity":{"attributes":{"PatientName":"A"},"dropped":{"private":7},"kept":true},)"
    R"("lossy_source":true,"place_known":false,)"
    R"("prepared":{"dropped_duplicates":2,"gaps":{"made_plane_count":3,)"
    R"("made_planes":[[1,2],[5,5]],)"
    R"("method":"linear","on_gap":"fill","slices":9,"step_mm":1.5},"ignored_number_gaps":1,)"
    R"("isotropic":{"made_plane_count":4,"method":"cubic"},"tilt":{"angle_degrees":18.5}},)"
    R"("segments":[{"number":1},{"number":4}],"source":{"files":3,"format":"DICOM"},)"
    R"("source_max_error":2.5,"spacing_known":true,"spacing_source":"file","unit":"HU",)"
    R"("later":{"x":[1,{"y":1.50}]},"made_by":{"operation":"condense","flat":20.0},)"
    R"("coding":{"preset":"fast","max_error":2,"nan":-1000,"inf":3.5},)"
    R"("repaired":{"missing_planes":[4,7],"fill":-1024},)"
    R"("labels":{"1":{"name":"left","color":"#ff8000"},"-2":{"name":"\u00b5"},)"
    R"("7":{"color":"#000001"}}})";

Metadata metadata(const std::string& text) { return Metadata::read(text); }

TEST(Metadata, ReadsEveryFact) {
  const Metadata read = metadata(kFull);
  ASSERT_TRUE(read.is_readable()) << read.defect();
  const MetadataFacts& facts = read.facts();
  EXPECT_EQ(facts.chosen->channel->name, "green");
  EXPECT_EQ(facts.chosen->time->count, 2);
  EXPECT_EQ(facts.dicom->json_of("KVP"), "120.0");
  EXPECT_EQ(facts.identity->attributes->at("PatientName"), "A");
  EXPECT_EQ(facts.identity->dropped.at("private"), 7);
  EXPECT_TRUE(read.was_source_lossy());
  EXPECT_EQ(facts.place_known, false);
  EXPECT_EQ(facts.prepared->dropped_duplicates, 2);
  EXPECT_EQ(facts.prepared->gaps->made_planes, (std::vector<PlaneRun>{{1, 2}, {5, 5}}));
  EXPECT_EQ(facts.prepared->gaps->step_mm, 1.5);
  EXPECT_EQ(facts.prepared->isotropic->method, "cubic");
  EXPECT_EQ(facts.prepared->tilt->angle_degrees, 18.5);
  EXPECT_EQ(facts.segments.size(), 2U);
  EXPECT_EQ(facts.segments[1].number, 4);
  EXPECT_EQ(facts.source->format, "DICOM");
  EXPECT_EQ(facts.source->file_count, 3);
  EXPECT_EQ(read.source_max_error(), 2.5);
  EXPECT_TRUE(read.is_spacing_known());
  EXPECT_EQ(facts.spacing_source, "file");
  EXPECT_EQ(read.unit(), "HU");
  EXPECT_EQ(facts.made_by->operation(), "condense");
  EXPECT_EQ(facts.made_by->number("flat"), 20);
  EXPECT_EQ(facts.made_by->number("missing"), std::nullopt);
  EXPECT_EQ(facts.coding->nan, -1000);
  EXPECT_EQ(facts.coding->infinity, 3.5);
  EXPECT_EQ(facts.repaired->missing_planes, (PlaneRun{4, 7}));
  EXPECT_EQ(facts.labels.size(), 3U);
  EXPECT_EQ(facts.labels.all().at(1), (LabelName{"left", LabelColor{255, 128, 0}}));
  EXPECT_EQ(facts.labels.text_of(-2), "\u00b5");
  EXPECT_EQ(facts.labels.text_of(7), "7");
  EXPECT_EQ(facts.labels.color_of(7, {}), (LabelColor{0, 0, 1}));
  EXPECT_EQ(facts.labels.color_of(-2, {9, 9, 9}), (LabelColor{9, 9, 9}));
}

TEST(Metadata, OfItsOwnFactsSaysTheSame) {
  const Metadata again = Metadata::of(metadata(kFull).facts());
  EXPECT_TRUE(again.is_readable());
  EXPECT_EQ(Metadata::of(again.facts()).text(), again.text());
  EXPECT_EQ(again.facts().labels, metadata(kFull).facts().labels);
  EXPECT_EQ(Metadata::of({}).text(), "{}");
}

TEST(Metadata, KeepsItsTextByteForByte) {
  for (const std::string& text :
       {kFull, std::string("{ }  \n"), std::string(R"({"x" : 1.50 })"), std::string(),
        std::string("no object"), std::string("[1]"), std::string("{\"a\":\"\xff\"}")}) {
    EXPECT_EQ(metadata(text).text(), text);
    EXPECT_EQ(metadata(text).for_copy(0, true).text().empty(), text.empty());
  }
  EXPECT_EQ(Metadata().text(), "{}");
}

TEST(Metadata, IsUnreadableAtEveryTruncation) {
  for (std::size_t size = 0; size < kFull.size(); ++size) {
    const Metadata cut = metadata(kFull.substr(0, size));
    EXPECT_FALSE(cut.is_readable()) << size;
    EXPECT_FALSE(cut.facts().source.has_value()) << size;
  }
}

TEST(Metadata, SaysNothingWhereItCannotBeRead) {
  const std::string deep = std::string(100000, '[');
  for (const std::string& text :
       {deep, "{\"unit\":\"HU\",\"x\":" + deep + "}", std::string("null"), std::string("[]"),
        R"({"unit":"HU","x":")" + std::string(kMaxJsonStringBytes + 1, 'a') + "\"}",
        std::string(R"({"unit":"HU"} x)"), std::string("{\"unit\":\"\xb5m\"}")}) {
    Metadata read = metadata(text);
    EXPECT_FALSE(read.is_readable());
    EXPECT_EQ(read.unit(), "");
    EXPECT_TRUE(read.is_spacing_known());
    read.set_made_by(MadeBy("threshold"));
    EXPECT_EQ(read.text(), text);
    const Metadata labels = read.for_labels(MadeBy("threshold"));
    EXPECT_TRUE(labels.is_readable()) << labels.defect();
    EXPECT_EQ(labels.facts().made_by->operation(), "threshold");
    EXPECT_EQ(read.for_copy(0, true).text(), text);
    EXPECT_EQ(read.for_copy(0, false).text(), "{}");
    EXPECT_EQ(read.without_identity().text(), "{}");
    EXPECT_EQ(read.for_copy(1, false).source_max_error(), 1);
  }
  EXPECT_EQ(metadata("[1]").for_labels(MadeBy("xor")).text(),
            R"({"made_by":{"operation":"xor"}})");
}

TEST(Metadata, PassesOverFactsOfAnotherForm) {
  const Metadata read = metadata(
      R"({"unit":5,"spacing_known":"no","source":[1],"prepared":{"gaps":{"made_planes":[[1,2],3]},)"
      R"("tilt":7},"identity":{"attributes":[],"dropped":{"a":"b"}},"made_by":{"flat":1},)"
      R"("repaired":{"missing_planes":[1,2,3]},"segments":{"number":1},"source_max_error":1e999,)"
      R"("labels":{"01":{"name":"a"},"x":{"name":"b"},"2":"c","3":{"color":"red"},"4":{}},)"
      R"("a":{}})");
  ASSERT_TRUE(read.is_readable()) << read.defect();
  const MetadataFacts& facts = read.facts();
  EXPECT_EQ(read.unit(), "");
  EXPECT_TRUE(read.is_spacing_known());
  EXPECT_FALSE(facts.source);
  EXPECT_FALSE(facts.prepared->gaps->made_planes);
  EXPECT_FALSE(facts.prepared->tilt);
  EXPECT_FALSE(facts.identity->attributes);
  EXPECT_FALSE(facts.made_by);
  EXPECT_FALSE(facts.repaired->missing_planes);
  EXPECT_TRUE(facts.segments.empty());
  EXPECT_EQ(read.source_max_error(), 0);
  EXPECT_EQ(facts.labels.name_of(1), "");
  EXPECT_EQ(facts.labels.name_of(2), "");
}

TEST(Metadata, TakesTheLastOfTwoMembersOfOneName) {
  const Metadata read = metadata(
      R"({"unit":"HU","source":{"format":"a","files":2},"unit":"Gy","source":{"format":"b"}})");
  EXPECT_EQ(read.unit(), "Gy");
  EXPECT_EQ(read.facts().source->format, "b");
  EXPECT_FALSE(read.facts().source->file_count);
  EXPECT_EQ(metadata(R"({"unit":"HU","unit":null})").unit(), "");
}

TEST(Metadata, PutsWhatIsSetBehindAllOthersAndOnce) {
  // Before, and after an operation was set.
  const std::array<std::array<std::string, 2>, 6> rows = {{
      {"{}", R"({"made_by":{"operation":"o","a":1}})"},
      {R"({"made_by":2})", R"({"made_by":{"operation":"o","a":1}})"},
      {R"({"made_by":[4,5],"b":6,"made_by":7})", R"({"b":6,"made_by":{"operation":"o","a":1}})"},
      {R"({"a":{"made_by":2},"b":"made_by"})",
       R"({"a":{"made_by":2},"b":"made_by","made_by":{"operation":"o","a":1}})"},
      {"{ \"x\" : 18446744073709551615,\t\"y\":1e-9 }",
       R"({"x":18446744073709551615,"y":1e-9,"made_by":{"operation":"o","a":1}})"},
      {R"({"\u00b5\n":"\u0001\""})",
       "{\"\u00b5\\n\":\"\\u0001\\\"\",\"made_by\":{\"operation\":\"o\",\"a\":1}}"},
  }};
  for (const auto& [before, after] : rows) {
    Metadata read = metadata(before);
    read.set_made_by(MadeBy("o").set("a", 1));
    EXPECT_EQ(read.text(), after);
  }
}

TEST(Metadata, KeepsUnknownMembersThroughEveryChange) {
  const std::string unknown = R"({"x":{"y":[1.50,"z"]},"unit":"HU"})";
  Metadata read = metadata(unknown);
  CodingNote coding;
  coding.max_error = 20;
  coding.infinity = 0.5;
  read.set_coding(coding);
  read.set_place_known(false);
  read.set_spacing(true, "user");
  RepairNote repair;
  repair.missing_planes = {3, 4};
  repair.fill = -1024;
  read.set_repaired(repair);
  EXPECT_EQ(read.text(),
            R"({"x":{"y":[1.50,"z"]},"unit":"HU","coding":{"max_error":20,"inf":0.5},)"
            R"("place_known":false,"spacing_known":true,"spacing_source":"user",)"
            R"("repaired":{"missing_planes":[3,4],"fill":-1024}})");
  EXPECT_EQ(read.for_labels(MadeBy("xor")).text(),
            R"({"x":{"y":[1.5,"z"]},"place_known":false,"spacing_known":true,)"
            R"("spacing_source":"user","repaired":{"missing_planes":[3,4],"fill":-1024},)"
            R"("made_by":{"operation":"xor"}})");
}

TEST(Metadata, PutsMembersInOrderWherePlanesWereMade) {
  Metadata read = metadata(
      R"({"unit":"HU","prepared":{"new":1,"gaps":{"slices":3,"made_planes":[[1,1]]}},)"
      R"("b":{"d":1,"c":2},)"
      R"("repaired":{"missing_planes":[1,2],"fill":-1024}})");
  IsotropicNote isotropic;
  isotropic.method = "linear";
  isotropic.slices = 3;
  isotropic.slice_mm = 2;
  Metadata kept = read;
  kept.set_isotropic(isotropic, std::vector<PlaneRun>{{1, 3}}, PlaneRun{1, 9});
  EXPECT_EQ(kept.text(),
            R"({"b":{"c":2,"d":1},"prepared":{"gaps":{"made_planes":[[1,3]],"slices":3},)"
            R"("isotropic":{"method":"linear","slice_mm":2.0,"slices":3},"new":1},)"
            R"("repaired":{"fill":-1024,"missing_planes":[1,9]},"unit":"HU"})");
  read.set_isotropic(isotropic, std::nullopt, std::nullopt);
  EXPECT_EQ(read.text(),
            R"({"b":{"c":2,"d":1},"prepared":{"gaps":{"slices":3},)"
            R"("isotropic":{"method":"linear","slice_mm":2.0,"slices":3},"new":1},"unit":"HU"})");
}

TEST(Metadata, PassesOnToACopyWhatIsStillSo) {
  const std::string identity =
      R"("identity":{"attributes":{"B":"x","A":"y"},"dropped":{"C":2},"kept":true})";
  const Metadata read = metadata("{\"coding\":{\"max_error\":2}," + identity + ",\"unit\":\"HU\"}");
  EXPECT_EQ(read.for_copy(0, false).text(),
            R"({"identity":{"dropped":{"A":1,"B":1,"C":2},"kept":false},"unit":"HU"})");
  EXPECT_EQ(read.for_copy(2, true).text(),
            "{" + identity + R"(,"unit":"HU","source_max_error":2.0})");
  const Metadata twice = metadata(R"({"source_max_error":1.5,"unit":"HU"})");
  EXPECT_EQ(twice.for_copy(2, false).text(), R"({"source_max_error":3.5,"unit":"HU"})");
  EXPECT_EQ(metadata(R"({ "unit":"HU"})").for_copy(0, false).text(), R"({ "unit":"HU"})");
}

TEST(Metadata, LeavesOutOfAnIdentityAllButNamesAndCounts) {
  const auto without = [](const std::string& identity) {
    const Metadata read = metadata("{ \"unit\":\"HU\",\"identity\":" + identity + "}");
    return read.without_identity().text();
  };
  EXPECT_EQ(without(R"("A")"), R"({"unit":"HU"})");
  EXPECT_EQ(without(R"(["A"])"), R"({"unit":"HU"})");
  EXPECT_EQ(without(R"({"attributes":{"B":["A"]}})"),
            R"({"unit":"HU","identity":{"dropped":{"B":1},"kept":false}})");
  EXPECT_EQ(without(R"({"attributes":{"B":"A"},"kept":"A","C":"A","dropped":{"D":"A","E":2}})"),
            R"({"unit":"HU","identity":{"dropped":{"B":1,"D":0,"E":2},"kept":false}})");
  EXPECT_EQ(without(R"({"attributes":{"B":"A"}},"identity":{"dropped":{}})"),
            R"({"unit":"HU","identity":{"dropped":{}}})");
  EXPECT_EQ(without(R"({"dropped":{"B":3},"kept":true})"),
            R"({"unit":"HU","identity":{"dropped":{"B":3},"kept":true}})");
  EXPECT_EQ(metadata(R"({ "unit":"HU"})").without_identity().text(), R"({ "unit":"HU"})");
  EXPECT_TRUE(metadata(R"({"identity":{"attributes":{"B":"A"}}})").keeps_identity());
  EXPECT_FALSE(metadata(R"({"identity":{"attributes":{},"kept":true}})").keeps_identity());
}

TEST(Metadata, SaysWhoCodedTheVoxelsAsLongAsTheseBricksStand) {
  const std::string identity = R"("identity":{"attributes":{"A":"y"},"dropped":{},"kept":true})";
  Metadata coded = metadata("{\"coding\":{\"preset\":\"fast\"}," + identity + "}");
  WriterNote writer;
  writer.name = "octavo";
  writer.revision = 3;
  coded.set_written_by(writer);
  const std::string said = R"("written_by":{"name":"octavo","revision":3}})";
  EXPECT_EQ(coded.text(), "{\"coding\":{\"preset\":\"fast\"}," + identity + "," + said);
  EXPECT_EQ(coded.facts().written_by->revision, 3);
  EXPECT_EQ(coded.for_copy(0, true).text(), "{" + identity + "}");
  EXPECT_EQ(coded.for_labels(MadeBy("xor")).text(), R"({"made_by":{"operation":"xor"}})");
  EXPECT_EQ(coded.without_identity().text(),
            R"({"coding":{"preset":"fast"},"identity":{"dropped":{"A":1},"kept":false},)" + said);
  writer.revision = 4;
  coded.set_written_by(writer);
  EXPECT_EQ(coded.facts().written_by->revision, 4);
}

TEST(Metadata, HoldsAsManyLabelNamesAsAreTaken) {
  LabelNames names;
  const std::string longest(LabelNames::kMaxNameBytes, '"');
  for (std::size_t i = 0; i < LabelNames::kMaxLabels; ++i) {
    names.set(static_cast<std::int64_t>(i), {longest + "x", LabelColor{1, 2, 3}});
  }
  EXPECT_THROW(names.set(-1, {"one more", {}}), Error);
  names.set(5, {"anew", {}});
  Metadata named;
  named.set_labels(names);
  EXPECT_TRUE(named.is_readable()) << named.defect();
  EXPECT_EQ(named.facts().labels, names);
  EXPECT_LT(named.text().size(), std::size_t{20} << 20);
  named.drop_labels();
  EXPECT_EQ(named.text(), "{}");
}

TEST(MadeBy, WritesSettingsInTheirOrder) {
  MadeBy made_by("threshold");
  made_by.set("units", "real").set("count", std::uint64_t{3}).set("flat", 20.0);
  const std::vector<JsonObject> ranges = {
      JsonObject().set("label", 1).set("low", 226.0).set("high", HUGE_VAL)};
  made_by.set("ranges", ranges).set("in_place", true);
  Metadata metadata;
  metadata.set_made_by(made_by);
  EXPECT_EQ(metadata.text(),
            R"({"made_by":{"operation":"threshold","units":"real","count":3,"flat":20.0,)"
            R"("ranges":[{"label":1,"low":226.0,"high":null}],"in_place":true}})");
}

}  // namespace
}  // namespace octavo
