#include <array>
#include <string>

#include "fuzz/seeds/seed_folder.h"

namespace octavo::fuzz {

namespace {

/// All members there are, and one that no program knows.
constexpr const char* kMetadata[] = {
    R"({"source":{"files":["a","b"],"format":"DICOM","size":9},"unit":"HU","lossy_source":true})",
    R"({"spacing_known":false,"spacing_source":"assumed","place_known":true,)"
    R"("later":[1,{"y":1.50}]})",
    R"({"chosen":{"channel":{"count":3,"index":1,"name":"green"},"time":{"count":2,"index":0}}})",
    R"({"dicom":{"KVP":120.0,"Modality":"CT"},"segment":{"number":2},"segments":[{"number":1}]})",
    R"({"identity":{"attributes":{"PatientName":"A"},"dropped":{"private":7},"kept":true}})",
    R"({"prepared":{"dropped_duplicates":2,"gaps":{"left_out_mm":0.5,"made_plane_count":3,)"
    R"("made_planes":[[1,2],[5,5]],"method":"linear","on_gap":"fill","slices":9,"step_mm":1.5}}})",
    R"({"prepared":{"ignored_number_gaps":1,"isotropic":{"left_out_mm":0,"made_plane_count":4,)"
    R"("method":"cubic","slice_mm":5,"slices":3,"step_mm":1},"tilt":{"angle_degrees":18.5,)"
    R"("method":"linear","outside":-1024,"slice_size":[512,600]}}})",
    R"({"labels":{"1":{"name":"left","color":"#ff8000"},"-2":{"name":"\u00b5"},"7":{}}})",
    R"({"made_by":{"operation":"condense","flat":20.0},"source_max_error":2.5e0})",
    R"({"coding":{"access":"boxes","keep_details":1,)"
    R"("detail_errors":{"max":9,"psnr_db":41.5,"rms":0.25}}})",
    R"({"coding":{"preset":"fast","max_error":2,"nan":-1000,"inf":3.5},)"
    R"("repaired":{"missing_planes":[4,7],"fill":-1024}})"};

}  // namespace

void save_metadata(SeedFolder& seeds) {
  const auto save_text = [&](const std::string& text) {
    seeds.save("metadata", Bytes(text.begin(), text.end()));
  };
  for (const char* text : kMetadata) save_text(text);
  // 2^n times a part less a few, between a beginning and an end: see fuzz_metadata.cpp.
  const auto save_repeated = [&](std::array<std::size_t, 2> times, const std::string& begin,
                                 const std::string& part, const std::string& end) {
    const auto& [power, fewer] = times;
    const std::string head = {static_cast<char>(power), static_cast<char>(fewer),
                              static_cast<char>(begin.size())};
    save_text(head + begin + static_cast<char>(part.size()) + part + end);
  };
  for (const auto fewer : std::to_array<std::size_t>({0, 1, 2, 3})) {
    save_repeated({16, fewer}, "{\"x\":[", "1,", "1]}");
    save_repeated({16, fewer}, "{\"x\":\"", "a", "a\"}");
    save_repeated({4, fewer}, "{\"x\":", "[", std::string(16 - fewer, ']') + "}");
  }
  save_repeated({17, 0}, "{\"x\":", "[", "");
  save_repeated({14, 0}, "{\"labels\":{", "\"1\":{\"name\":\"a\"},", "\"2\":{}}}");
}

}  // namespace octavo::fuzz
