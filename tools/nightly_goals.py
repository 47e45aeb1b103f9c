"""The goals that tools/nightly runs, and how."""

import dataclasses


@dataclasses.dataclass
class Step:
    """One command. What it prints as "goal NAME: ..." is the figure of the goal NAME."""
    name: str
    command: list             # {build}, {seconds} and {share} are filled in
    target: str = ""          # built before
    environment: dict = dataclasses.field(default_factory=dict)
    seconds: float = 0        # a limit of its own; 0: that of its loops, and room around them

    def limit(self, loop_seconds):
        return self.seconds or 20 * loop_seconds + 600


@dataclasses.dataclass
class Goal:
    name: str
    what: str
    steps: list


def gtest(folder, name, pattern="*", **options):
    """A gtest program of tests/`folder`."""
    return Step(f"{name} {pattern}".removesuffix(" *"),
                ["{build}/tests/" + f"{folder}/test_{name}", f"--gtest_filter={pattern}"],
                target=f"test_{name}", **options)


def program_faults(cases, **options):
    """Test cases of tests/fault/program_faults.py."""
    return Step(f"program_faults {cases}",
                ["python3", "tests/fault/program_faults.py", "{build}/octavo", "-v", cases],
                target="octavo", **options)


def fuzz(*targets):
    """Fuzz targets, each for the seconds that a loop of cases may take."""
    return Step(f"fuzz {' '.join(targets)}", ["tools/fuzz", "{seconds}", *targets])


GOALS = [
    Goal("A1", "fuzz: every section of a file under ASan and UBSan",
         [fuzz("open", "header", "directory", "slab_trailer", "index", "pieces", "journal")]),
    Goal("A2", "fuzz: brick decoders, portable and vectorized, and every stream of theirs",
         [fuzz("brick", "simd", "grey_streams", "exact_streams", "label_streams")]),
    Goal("A3", "fuzz: the whole reader, verify, partial reads and reading around damage",
         [fuzz("reader", "salvage")]),
    Goal("A4", "fuzz: metadata are read within their limits, changed and written again",
         [fuzz("metadata")]),
    Goal("A5", "fuzz: volumes are built twice with the same bytes, and read back",
         [fuzz("round_trip")]),
    Goal("A7", "fuzz: plans and parts of builds in parts",
         [fuzz("plan", "part")]),
    Goal("A8", "fuzz: meshes of strangers, STL, PLY and OBJ",
         [fuzz("mesh")]),
    Goal("A6", "no byte that was never set is read or written, under valgrind",
         [Step("uninitialized", ["tools/uninitialized", "{build}"], target="octavo")]),
    Goal("B1", "every flipped bit of golden files and a million of a CT are found; no wrong voxel",
         [gtest("fault", "golden_damage", "*FlippedBit*"),
          gtest("fault", "damage_coded", "*FlippedBit*:*PartialRead*"),
          gtest("fault", "scan_damage", "*FlippedBit*")]),
    Goal("B2", "every shortened golden file is rejected",
         [gtest("fault", "golden_damage", "*EveryLength*"),
          gtest("fault", "damage_coded", "*Truncation*"),
          gtest("fault", "scan_damage", "*Shortened*")]),
    Goal("B3", "every other sort of damage is found",
         [gtest("fault", "golden_damage", "*EverySort*"),
          gtest("fault", "damage_coded", "*Swapped*:*Another*:*Coarse*:*Appended*")]),
    Goal("B4", "verify names the damaged brick and its bit; all other bricks are salvaged",
         [gtest("fault", "golden_damage", "*Named*:*Names*"), gtest("fault", "salvage"),
          gtest("fault", "repair_bits")]),
    Goal("B5", "checksums cost at most 3 % of decoding and 0.2 % of the file",
         [gtest("fault", "checksum_share"),
          Step("phantom", ["{build}/octavo", "phantom", "--size", "256", "--noise", "12", "-f",
                           "-o", "build-nightly/small.8vo"], target="octavo"),
          Step("fast phantom", ["{build}/octavo", "build", "build-nightly/small.8vo", "--preset",
                                "fast", "-f", "-o", "build-nightly/fast.8vo"]),
          Step("bench_checksums", ["{build}/bench/checksums/bench_checksums", "--rounds", "40",
                                   "build-nightly/small.8vo", "build-nightly/fast.8vo"],
               target="bench_checksums")]),
    Goal("B6", "servers that lie, stall, break off and redirect; secrets of URLs are never seen",
         [Step("http", ["python3", "tests/cli/http_test.py", "{build}/octavo", "-v"],
               target="octavo")]),
    Goal("C1", "hostile headers: open ends within 100 ms, memory within 64 MiB + 2 x file",
         [gtest("fault", "hostile_header")]),
    Goal("C2", "builds of 512^3 to 2048^3 voxels stay within the memory they are given",
         [Step("bounded_memory", ["python3", "tests/fault/bounded_memory.py", "{build}/octavo"],
               target="octavo", seconds=4 * 3600)]),
    Goal("C3", "memory that runs out at any allocation: an error, no leak, the old file",
         [gtest("fault", "allocation")]),
    Goal("D1", "kill -9, SIGTERM and SIGINT at random moments: the old file or a new one",
         [program_faults("Kills", seconds=4 * 3600)]),
    Goal("D2", "power cuts at every change, by a model of the disk: the old file or the new one",
         [gtest("fault", "power_cut")]),
    Goal("D3", "full disks: exit 5, the old file intact, nothing left",
         [gtest("fault", "storage_fault", "*Fu*:*Limit*"),
          program_faults("Disks")]),
    Goal("D4", "system calls that fail, stop short or are interrupted",
         [gtest("fault", "system_calls"), gtest("fault", "storage_fault", "*Failing*:*Scratch*")]),
    Goal("D5", "odd targets: folders, pipes, devices, links, long names and line ends",
         [Step("target_faults", ["python3", "tests/fault/target_faults.py", "{build}/octavo", "-v"],
               target="octavo")]),
    Goal("D8", "parts and joins that are killed or meet a failing disk, and are made again alike",
         [gtest("fault", "part_processes", "*Killed*"), gtest("fault", "part_faults")]),
    Goal("E1", "the same bytes for any threads, instruction set, compiler and optimization",
         [Step("same_bytes", ["tools/same_bytes", "{build}"], target="file_hashes")]),
    Goal("E2", "no data race under ThreadSanitizer in the tests of everything threaded",
         [Step("race_free", ["tools/race_free"])]),
    Goal("E3", "readers at once on one handle, and processes on a file that is replaced",
         [gtest("property", "property_concurrent_readers")]),
    Goal("E4", "any parts in any order, by any instruction set, make the file of a build",
         [gtest("property", "property_partition"), gtest("property", "property_shared_groups"),
          gtest("fault", "part_processes", "*InstructionSet*")]),
    Goal("F1", "no voxel of 10^10 is further away than the max error",
         [gtest("property", "property_error_bounds"),
          gtest("property", "property_lossy_volumes")]),
    Goal("F2", "lossless round trips of every type; any box at any level is the crop of the whole",
         [gtest("property", "property_round_trip"), gtest("unit/builder", "builder")]),
    Goal("G1", "sources cut to 1000 lengths and flipped gzip bits: exit 7, never a file",
         [gtest("fault", "damaged_source", "*CutSource*:*Gzip*")]),
    Goal("G2", "10,000 mutated DICOM files: voxels or an error, the program never crashes",
         [gtest("fault", "damaged_source", "*Mutated*"), gtest("unit/io", "io_isolation")]),
    Goal("G3", "geometry is that of ITK; what is no even, upright stack is rejected",
         [gtest("unit/io", "io_shared_data"),
          gtest("unit/io", "io_source", "*Geometry*:*Slices*"),
          Step("awkward", ["python3", "tests/cli/awkward_test.py", "{build}/octavo",
                           "docs/sources.md"], target="octavo")]),
    Goal("G4", "headers that point out of their folder, at devices or pipes are rejected",
         [gtest("unit/io", "io_source", "*SourcePath*")]),
    Goal("Q1", "tests of core, codec and file reach 98 % of their lines, 90 % of branches",
         [Step("coverage", ["tools/coverage"], seconds=3 * 3600)]),
    Goal("Q4", "the release program is hardened",
         [Step("hardened", ["python3", "tests/house/hardened_program.py", "{build}/octavo"],
               target="octavo")]),
    Goal("Q2", "header, directory, index and trailer are parsed by at most 800 lines of code",
         [Step("check_parser", ["tools/check_parser.py"])]),
    Goal("Q3", "cppcheck and clang-tidy find nothing in any source file",
         [Step("lint", ["tools/lint"])]),
]
