# Run by octavo_embed with -D symbol, -D source and -D output.
file(READ ${source} digits HEX)
string(LENGTH ${digits} length)
math(EXPR size "${length} / 2")
string(REGEX REPLACE "(................................................)" "\\1\n" digits ${digits})
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," numbers ${digits})
file(WRITE ${output} "// Made of a file by octavo_embed.
namespace octavo {
extern const unsigned char ${symbol}[] = {
${numbers}};
extern const unsigned long ${symbol}_size = ${size};
}  // namespace octavo
")
