#include "octavo/builder/float_planes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "octavo/core/error.h"
#include "octavo/planes/memory_source.h"
#include "support/hints.h"
#include "support/sought_planes.h"

namespace octavo {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// 8 x 4 x planes voxels, each from its number.
struct Floats {
  VolumeDescription description;
  std::vector<float> voxels;

  explicit Floats(std::int64_t planes, const std::function<float(std::size_t)>& voxel) {
    description.type = VoxelType::float32;
    description.size = {8, 4, planes};
    for (std::size_t i = 0; i < static_cast<std::size_t>(32 * planes); ++i) {
      voxels.push_back(voxel(i));
    }
  }
  std::unique_ptr<PlaneSource> source() const {
    return make_memory_source(description, std::as_bytes(std::span(voxels)));
  }
};

// What a run over all planes gives: the codes or, without a max error, the voxels; or the error.
struct Outcome {
  SampleCoding coding;
  std::int64_t codec_error = 0;
  std::vector<std::int32_t> codes;
  std::vector<float> voxels;
  std::string error;
};

Outcome run(const Floats& floats, const FloatSettings& settings) {
  Outcome outcome;
  NoProgress progress;
  const auto source = floats.source();
  try {
    FloatPlanes planes(*source, settings, progress);
    outcome.coding = planes.coding();
    outcome.codec_error = planes.codec_error();
    EXPECT_EQ(outcome.coding.is_exact, settings.max_error == 0);
    std::vector<std::int32_t> plane(32);
    for (std::int64_t z = 0; z < floats.description.size.z; ++z) {
      planes.read_plane(std::as_writable_bytes(std::span(plane)));
      for (const std::int32_t number : plane) {
        if (planes.description().type == VoxelType::int32) outcome.codes.push_back(number);
        else outcome.voxels.push_back(std::bit_cast<float>(number));
      }
    }
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    outcome.error = testing::with_hints(error);
  }
  return outcome;
}

void expect_bits_back(const Floats& floats, const Outcome& outcome) {
  ASSERT_EQ(outcome.voxels.size(), floats.voxels.size()) << outcome.error;
  for (std::size_t i = 0; i < floats.voxels.size(); ++i) {
    ASSERT_EQ(std::bit_cast<std::uint32_t>(outcome.voxels[i]),
              std::bit_cast<std::uint32_t>(floats.voxels[i]));
  }
}

void expect_words(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words) {
    EXPECT_NE(text.find(word), std::string::npos) << word << ": " << text;
  }
}

float tenth(std::size_t i) { return static_cast<float>(static_cast<double>(i % 97) * 0.1); }

// The max error that a error proposes.
double proposed(const std::string& error) {
  const std::string mark = "[max_error=";
  const std::size_t at = error.find(mark);
  EXPECT_NE(at, std::string::npos) << error;
  return at == std::string::npos ? 0 : std::stod(error.substr(at + mark.size()));
}

TEST(FloatPlanes, PlanesAreTheSameFromAnywhere) {
  const Floats floats(9, [](std::size_t i) { return i < 64 ? 0 : tenth(i * i); });
  for (const double max_error : {0.0, 0.05}) {
    NoProgress progress;
    const auto source = floats.source();
    FloatPlanes planes(*source, {max_error, {}, 2}, progress);
    EXPECT_TRUE(planes.can_seek());
    testing::expect_same_from_anywhere(planes);
  }
}

TEST(FloatPlanes, PlanesThatAreReadAgainDecideTheSame) {
  const auto grainy = [](std::size_t i) {
    return static_cast<float>(std::sin(static_cast<double>(i * i)) * 100);
  };
  const auto few = [](std::size_t i) { return i % 32 < 9 ? 0.1f : static_cast<float>(i % 5); };
  const auto lone = [](std::size_t i) { return i % 64 == 7 ? -1e6f : i < 96 ? 0 : tenth(i); };
  const auto holes = [](std::size_t i) { return i % 17 == 3 ? kNan : tenth(i); };
  for (const std::function<float(std::size_t)>& voxel :
       std::vector<std::function<float(std::size_t)>>{tenth, grainy, few, lone, holes}) {
    const Floats floats(70, voxel);
    for (const double max_error : {0.0, 0.05}) {
      FloatSettings settings{max_error, {.nan = 4.5f}, 40};
      NoProgress progress;
      const auto source = floats.source();
      FloatPlanes kept(*source, settings, progress);
      settings.keeps_planes = false;
      const auto other_source = floats.source();
      FloatPlanes again(*other_source, settings, progress);
      EXPECT_EQ(again.choice(), kept.choice());
      std::vector<std::byte> plane(32 * 4);
      std::vector<std::byte> same(32 * 4);
      for (std::int64_t z = 0; z < floats.description.size.z; ++z) {
        kept.read_plane(plane);
        again.read_plane(same);
        ASSERT_EQ(same, plane) << z;
      }
      EXPECT_EQ(again.clipped(), kept.clipped());
    }
  }
}

TEST(FloatPlanes, WhatHasNoCodeIsCountedUpToTheEndThatWasSought) {
  const Floats floats(9, [](std::size_t i) { return i % 32 == 5 && i > 96 ? kNan : tenth(i); });
  NoProgress progress;
  const auto source = floats.source();
  FloatPlanes planes(*source, {0.05, {}, 2}, progress);
  planes.seek(4, 7);
  std::vector<std::byte> plane(128);
  try {
    planes.read_plane(plane);
    FAIL() << "NaN was taken";
  } catch (const Error& error) {
    expect_words(error.what(), {"3 NaN", "x,y,z = 5,0,4", "in planes 4 to 6"});
  }
}

TEST(FloatPlanes, MultiplesComeBackBitByBit) {
  const Floats floats(9, tenth);
  const Outcome outcome = run(floats, {.first_planes = 4});
  EXPECT_EQ(outcome.coding.scale, 0.1);
  expect_bits_back(floats, outcome);
}

TEST(FloatPlanes, ConstantPlanesDoNotHideTheScaleOfThoseBehindThem) {
  const Floats floats(40, [](std::size_t i) { return i < 32 * 30 ? 0.0f : tenth(i); });
  const Outcome outcome = run(floats, {.first_planes = 2});
  EXPECT_EQ(outcome.coding.scale, 0.1);
  expect_bits_back(floats, outcome);
}

TEST(FloatPlanes, ALaterPlaneThatBreaksTheScaleComesBackAsWell) {
  Floats floats(9, tenth);
  floats.voxels[7 * 32 + 2 * 8 + 5] = 0.123f;
  floats.voxels[7 * 32 + 3] = -0.0f;
  floats.voxels[8 * 32 + 3] = kNan;
  const Outcome outcome = run(floats, {.first_planes = 4});
  EXPECT_EQ(outcome.coding.scale, 0.1);
  expect_bits_back(floats, outcome);
}

TEST(FloatPlanes, MinusZeroIsZeroWithinAnError) {
  Floats floats(3, [](std::size_t i) { return static_cast<float>(i); });
  floats.voxels[40] = -0.0f;
  const Outcome within = run(floats, {.max_error = 0.5, .first_planes = 3});
  ASSERT_EQ(within.error, "");
  EXPECT_EQ(within.coding.voxel_of(within.codes[40]), 0);
  EXPECT_EQ(within.codec_error, 0);
}

TEST(FloatPlanes, NoiseComesInStepsThatDivideIt) {
  std::mt19937 random(5);
  for (const float deviation : {8.0f, 3e-20f, 7e30f}) {
    std::normal_distribution<float> noise(0, deviation);
    const Floats floats(200, [&](std::size_t) { return noise(random); });
    const Outcome outcome = run(floats, {.first_planes = 8});
    const double steps = static_cast<double>(deviation) / outcome.coding.scale;
    EXPECT_GE(steps, 6);
    EXPECT_LE(steps, 20);
    int exponent = 0;
    EXPECT_EQ(std::frexp(outcome.coding.scale, &exponent), 0.5);
    EXPECT_EQ(outcome.coding.offset, 0);
    expect_bits_back(floats, outcome);
  }
}

TEST(FloatPlanes, TheLowestBitOfNoiseIsNoStep) {
  std::mt19937 random(5);
  std::normal_distribution<float> noise(1200, 12);
  const Floats floats(60, [&](std::size_t) { return noise(random); });
  // All lie on multiples of 2^-13, as every float of their size.
  EXPECT_EQ(run(floats, {.first_planes = 60}).coding.scale, 1);
  const Floats whole(60, [&](std::size_t) { return std::round(256 * noise(random)) / 256; });
  EXPECT_EQ(run(whole, {.first_planes = 60}).coding.scale, 1.0 / 256);
}

TEST(FloatPlanes, ValuesFarAwayHaveNoSayInTheStep) {
  std::mt19937 random(5);
  std::normal_distribution<float> noise(300, 8);
  for (const float fill : {-1e10f, 9.96921e36f, -3.4028235e38f}) {
    const auto far = [&](std::size_t i) { return i % 3 == 0 || i == 7 ? fill : noise(random); };
    const Floats noisy(60, far);
    const Outcome outcome = run(noisy, {.first_planes = 8});
    EXPECT_GE(8 / outcome.coding.scale, 6) << fill;
    EXPECT_LE(8 / outcome.coding.scale, 20) << fill;
    expect_bits_back(noisy, outcome);
    const Floats multiples(60, [&](std::size_t i) { return i % 3 == 0 ? fill : tenth(i); });
    EXPECT_EQ(run(multiples, {.first_planes = 8}).coding.scale, 0.1) << fill;
  }
}

const float kFills[] = {0, -1, -1024, 1e20f, -std::numeric_limits<float>::max(), kNan};

TEST(FloatPlanes, FillsHaveNoSayInTheStepOfNoise) {
  for (const auto& [mean, deviation] : {std::pair{1000.0f, 1.0f}, {0.02f, 0.001f}, {0.0f, 30.0f}}) {
    for (const float fill : kFills) {
      for (const double share : {0.01, 0.35, 0.9, 0.999}) {
        std::mt19937 random(5);
        std::normal_distribution<float> noise(mean, deviation);
        std::uniform_real_distribution<double> uniform(0, 1);
        const Floats floats(2000, [&](std::size_t) {
          return uniform(random) < share ? fill : noise(random);
        });
        const double scale = run(floats, {.first_planes = 2000}).coding.scale;
        EXPECT_GE(static_cast<double>(deviation) / scale, 4) << fill << " at " << share;
        EXPECT_LE(static_cast<double>(deviation) / scale, 64) << fill << " at " << share;
      }
    }
  }
}

TEST(FloatPlanes, FillsHaveNoSayInTheNumberThatOthersAreMultiplesOf) {
  for (const double offset : {0.0, 7.77}) {
    for (const float fill : kFills) {
      for (const double share : {0.01, 0.35, 0.9}) {
        std::mt19937 random(3);
        std::normal_distribution<double> noise(1000, 20);
        std::uniform_real_distribution<double> uniform(0, 1);
        const Floats floats(2000, [&](std::size_t) {
          const double value = std::round(noise(random)) * 0.1 + offset;
          return uniform(random) < share ? fill : static_cast<float>(value);
        });
        const Outcome outcome = run(floats, {.first_planes = 2000});
        EXPECT_NEAR(outcome.coding.scale, 0.1, 1e-6) << fill << " at " << share;
        expect_bits_back(floats, outcome);
      }
    }
  }
}

TEST(FloatPlanes, BrightSpotsAreNotFarAway) {
  // A background of 1 and few values up to 500 times as large.
  const Floats floats(60, [](std::size_t i) {
    return i % 100 == 0 ? 500.0f + static_cast<float>(i) / 7 : 1.0f + static_cast<float>(i) / 9001;
  });
  EXPECT_LE(700 / run(floats, {.first_planes = 60}).coding.scale, 0x1p21);
}

TEST(FloatPlanes, StepsSuitVolumesWithoutNoiseOrNumbers) {
  const auto coding_of = [](const std::function<float(std::size_t)>& voxel) {
    return run(Floats(4, voxel), {.first_planes = 4}).coding;
  };
  EXPECT_TRUE(is_valid(coding_of([](std::size_t) { return kNan; })));
  EXPECT_TRUE(is_valid(coding_of([](std::size_t i) { return i % 2 == 0 ? kNan : kInfinity; })));
  EXPECT_TRUE(is_valid(coding_of([](std::size_t) { return 0.3f; })));
  const auto denormal = [](std::size_t i) { return std::bit_cast<float>(static_cast<int>(i * i)); };
  EXPECT_GE(coding_of(denormal).scale, 0x1p-149);
}

TEST(FloatPlanes, WhatIsNoNumberIsCountedOverTheWholeScan) {
  Floats floats(12, tenth);
  floats.voxels[3 * 32 + 9] = kNan;
  floats.voxels[11 * 32] = kNan;
  floats.voxels[5 * 32] = -kInfinity;
  const Outcome all = run(floats, {.max_error = 0.5, .first_planes = 12});
  expect_words(all.error,
               {"2 NaN and 1 infinite", "x,y,z = 1,1,3", "[repair.nan]", "[repair.infinity]"});
  EXPECT_EQ(run(floats, {.max_error = 0.5, .first_planes = 1}).error, all.error);
  const Outcome some =
      run(floats, {.max_error = 0.5, .repair = {.nan = 0.0f, .infinity = {}}});
  expect_words(some.error, {"1 infinite", "0,0,5", "[repair.infinity]"});
  EXPECT_EQ(some.error.find("NaN"), std::string::npos) << some.error;
}

TEST(FloatPlanes, WhatIsNoNumberIsReplacedAsAsked) {
  Floats floats(2, tenth);
  floats.voxels[1] = kNan;
  floats.voxels[2] = kInfinity;
  floats.voxels[33] = -kInfinity;
  const FloatRepair repair{.nan = 0.3f, .infinity = 9.6f};
  const Outcome outcome = run(floats, {.repair = repair});
  floats.voxels[1] = 0.3f;
  floats.voxels[2] = 9.6f;
  floats.voxels[33] = -9.6f;
  expect_bits_back(floats, outcome);
}

TEST(FloatPlanes, ARepairedSourceGivesTheSameVoxels) {
  Floats floats(1, tenth);
  floats.voxels[3] = kNan;
  const auto source = floats.source();
  const auto repaired = make_repaired_source(*source, {.nan = -2.0f, .infinity = {}});
  std::vector<float> plane(32);
  repaired->read_plane(std::as_writable_bytes(std::span(plane)));
  floats.voxels[3] = -2;
  EXPECT_EQ(plane, floats.voxels);
}

// The bound must hold for every code that the codec may turn a code into.
TEST(FloatPlanes, NoCodeWithinTheCodecsErrorLeavesTheBound) {
  std::mt19937 random(11);
  const auto any_bits = [&](float low, float high) {
    float v;
    do v = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    while (!(std::abs(v) >= low && std::abs(v) <= high));
    return v;
  };
  struct Case {
    double max_error;
    float low;
    float high;
  };
  const Case cases[] = {{0.5, 0, 1000},      {0.5, 1e5f, 1.2e6f},   {1, 1e6f, 3e7f},
                        {0.37, 1e3f, 1e6f},  {1e-3, 1e-30f, 1},     {1e-42, 0, 1e-36f},
                        {1e30, 0, 3e37f},    {3e38, 1e30f, 3.4e38f}, {0.0077, 4000, 30'000}};
  for (const Case& c : cases) {
    Floats floats(6, [&](std::size_t) { return any_bits(c.low, c.high); });
    const Outcome outcome = run(floats, {.max_error = c.max_error, .first_planes = 6});
    ASSERT_EQ(outcome.error, "") << c.max_error;
    for (std::size_t i = 0; i < floats.voxels.size(); ++i) {
      for (std::int64_t d = -outcome.codec_error; d <= outcome.codec_error; ++d) {
        const double back = outcome.coding.voxel_of(outcome.codes[i] + d);
        ASSERT_LE(std::abs(back - static_cast<double>(floats.voxels[i])), c.max_error)
            << floats.voxels[i] << " + " << d << " codes";
      }
    }
  }
}

TEST(FloatPlanes, TheRoomierErrorHoldsForValuesThatNoFirstPlaneAnnounced) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 10);
  Floats floats(6, [&](std::size_t) { return noise(random); });
  FloatSettings settings{.max_error = 0.9, .first_planes = 2};
  floats.voxels[170] = 3e7f;
  floats.voxels[171] = 1e6f + 0.0625f;
  NoProgress progress;
  const auto source = floats.source();
  settings.max_error = FloatPlanes(*source, settings, progress).roomier_error();
  EXPECT_EQ(settings.max_error, 0.5);
  const Outcome outcome = run(floats, settings);
  ASSERT_EQ(outcome.error, "");
  for (std::size_t i = 0; i < floats.voxels.size(); ++i) {
    for (std::int64_t d = -outcome.codec_error; d <= outcome.codec_error; ++d) {
      const double back = outcome.coding.voxel_of(outcome.codes[i] + d);
      ASSERT_LE(std::abs(back - static_cast<double>(floats.voxels[i])), settings.max_error);
    }
  }
}

TEST(FloatPlanes, ProposalsAreInRealUnits) {
  Floats floats(9, tenth);
  floats.voxels[250] = 1e12f;
  const FloatSettings settings{.max_error = 0.01, .first_planes = 4};
  const double stored = proposed(run(floats, settings).error);
  floats.description.rescale.slope = -20;
  const double real = proposed(run(floats, settings).error);
  EXPECT_NEAR(real, 20 * stored, 2 * stored);
}

TEST(FloatPlanes, ScaledIntegersKeepTheirScaleWithinAnError) {
  const Floats floats(9, tenth);
  const Outcome outcome = run(floats, {.max_error = 0.55, .first_planes = 4});
  EXPECT_EQ(outcome.coding.scale, 0.1);
  EXPECT_EQ(outcome.codec_error, 5);
}

TEST(FloatPlanes, FewValuesComeBitByBitWhereThatTakesFewerBytes) {
  const auto square_root = [](std::size_t i) {
    return std::sqrt(static_cast<float>(i * 2654435761u >> 7 & 15));
  };
  const FloatSettings fine = {.max_error = 1e-4, .first_planes = 64};
  const auto two_values = [](std::size_t i) {
    return (i * 2654435761u >> 9 & 1) == 1 ? 0.37f : 0.0f;
  };
  for (const std::function<float(std::size_t)>& voxel :
       {std::function<float(std::size_t)>(square_root),
        std::function<float(std::size_t)>(two_values)}) {
    const Floats floats(80, voxel);
    NoProgress progress;
    const auto source = floats.source();
    const FloatPlanes planes(*source, fine, progress);
    EXPECT_EQ(planes.max_error(), 0);
    EXPECT_TRUE(planes.coding().is_exact);
    EXPECT_EQ(planes.description().type, VoxelType::float32);
    EXPECT_EQ(planes.codec_error(), 0);
    const FloatPlanes others(*source, fine, planes.choice(), progress);
    EXPECT_EQ(others.max_error(), 0);
    EXPECT_EQ(others.description().type, VoxelType::float32);
  }
  // What takes fewer bytes when it is rounded, is
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0, 1);
  const Floats noisy(80, [&](std::size_t) { return noise(random); });
  NoProgress progress;
  const auto source = noisy.source();
  EXPECT_EQ(FloatPlanes(*source, fine, progress).max_error(), 1e-4);
}

TEST(FloatPlanes, NothingButNumbersIsTakenWhereAMaxErrorWasAskedFor) {
  Floats floats(80, [](std::size_t i) { return (i * 2654435761u >> 9 & 1) == 1 ? 0.37f : 0.0f; });
  floats.voxels[70 * 32 + 9] = kNan;
  NoProgress progress;
  const auto source = floats.source();
  FloatPlanes planes(*source, {.max_error = 1e-4, .first_planes = 64}, progress);
  EXPECT_EQ(planes.max_error(), 0);
  std::vector<std::int32_t> plane(32);
  const auto read_all = [&] {
    for (int z = 0; z < 80; ++z) planes.read_plane(std::as_writable_bytes(std::span(plane)));
  };
  EXPECT_THROW(read_all(), Error);
}

TEST(FloatPlanes, ValuesTooLargeForTheErrorAreRejectedWithOneThatWorks) {
  Floats floats(2, tenth);
  floats.voxels[50] = 1e12f;
  floats.voxels[51] = 0.777f;
  const Outcome rejected = run(floats, {.max_error = 0.01});
  expect_words(rejected.error, {"plane 1", "9.99999996e+11", "too large"});
  EXPECT_EQ(run(floats, {.max_error = proposed(rejected.error)}).error, "");
}

TEST(FloatPlanes, WhatIsProposedWorksForTheVoxelsBehindTheRejectedOneToo) {
  for (const float first : {1e12f, 0.7771f}) {
    Floats floats(9, tenth);
    floats.voxels[6 * 32 + 1] = first;
    floats.voxels[6 * 32 + 7] = 1e13f;
    floats.voxels[8 * 32 + 5] = -1e15f;
    const FloatSettings settings{.max_error = 0.01, .first_planes = 4};
    const Outcome rejected = run(floats, settings);
    expect_words(rejected.error, {"plane 6", "x,y = 1,0"});
    const double enough = proposed(rejected.error);
    EXPECT_EQ(run(floats, {.max_error = enough, .first_planes = 4}).error, "") << enough;
  }
}

}  // namespace
}  // namespace octavo
