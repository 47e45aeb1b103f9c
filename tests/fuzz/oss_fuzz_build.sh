#!/usr/bin/env bash
# Builds the fuzz targets as OSS-Fuzz asks for them: TARGET, TARGET_seed_corpus.zip and TARGET.dict.
#
# usage: CXX=clang++ CXXFLAGS=... LIB_FUZZING_ENGINE=-fsanitize=fuzzer OUT=DIR tests/fuzz/oss_fuzz_build.sh
#
# Sanitizers and instrumentation are those of CXXFLAGS. Only targets that need no library of the
# system are built: an engine may bring its own standard library. WORK, if set, keeps the build.
set -euo pipefail
cd "$(dirname "$0")/../.."
: "${CXX:?}" "${OUT:?}" "${LIB_FUZZING_ENGINE:?}"
work=${WORK:-$(mktemp -d)}
[ -n "${WORK:-}" ] || trap 'rm -rf "$work"' EXIT
mkdir -p "$OUT"

cmake -S . -B "$work/octavo" -G Ninja -DCMAKE_BUILD_TYPE= -DCMAKE_C_COMPILER="${CC:-clang}" \
  -DCMAKE_CXX_COMPILER="$CXX" -DCMAKE_CXX_FLAGS="${CXXFLAGS:-}" -DOCTAVO_BUILD_FUZZ=ON \
  -DOCTAVO_FUZZING_ENGINE="$LIB_FUZZING_ENGINE"
cmake --build "$work/octavo" --target fuzz_programs

for program in "$work"/octavo/tests/fuzz/fuzz_*; do
  [ -f "$program" ] && [ -x "$program" ] || continue
  name=$(basename "$program")
  target=${name#fuzz_}
  case $target in
    brick | *_streams) words=brick ;;
    metadata) words=metadata ;;
    plan | part) words=$target ;;
    *) words=file ;;
  esac
  cp "$program" "$OUT/$name"
  cp "tests/fuzz/dictionaries/$words.dict" "$OUT/$name.dict"
  python3 -c 'import shutil, sys; shutil.make_archive(sys.argv[1], "zip", sys.argv[2])' \
    "$OUT/${name}_seed_corpus" "tests/fuzz/corpus/$target"
done
