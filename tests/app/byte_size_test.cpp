#include "app/byte_size.h"

#include <gtest/gtest.h>

namespace maille {
namespace {

TEST(ByteSize, ReadsWholeNumbersAndPowersOf1024) {
  EXPECT_EQ(parse_byte_size("1"), 1);
  EXPECT_EQ(parse_byte_size("123456"), 123456);
  EXPECT_EQ(parse_byte_size("64K"), 65536);
  EXPECT_EQ(parse_byte_size("512m"), std::int64_t{512} << 20);
  EXPECT_EQ(parse_byte_size("2G"), std::int64_t{2} << 30);
  EXPECT_EQ(parse_byte_size("3T"), std::int64_t{3} << 40);
}

TEST(ByteSize, RefusesEverythingElse) {
  for (const auto* const text : {"", "0", "-1", "1.5G", "G", "1GB", "1 G", "2X", "0x10",
                                 "99999999999999999999", "9000000000T"}) {
    EXPECT_FALSE(parse_byte_size(text)) << text;
  }
}

TEST(ByteSize, SpeaksInTheLargestUnitThatFits) {
  EXPECT_EQ(text_of_bytes(17), "17 bytes");
  EXPECT_EQ(text_of_bytes(1536), "1.5 KiB");
  EXPECT_EQ(text_of_bytes(std::int64_t{1} << 30), "1.0 GiB");
  EXPECT_EQ(text_of_bytes(std::int64_t{5} << 50), "5120.0 TiB");
}

}  // namespace
}  // namespace maille
