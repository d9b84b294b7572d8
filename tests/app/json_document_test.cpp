#include "app/json_document.h"

#include <gtest/gtest.h>

namespace maille {
namespace {

std::string refusal(std::string_view text) {
  const auto parsed = parse_json(text);
  return parsed.ok() ? "accepted" : parsed.error().message;
}

TEST(JsonDocument, SyntaxErrorsHaveLineAndColumn) {
  EXPECT_EQ(refusal("{\n  \"a\": 1,\n  \"b\" 2\n}").rfind("line 3, column 7: ", 0), 0u)
      << refusal("{\n  \"a\": 1,\n  \"b\" 2\n}");
  EXPECT_EQ(refusal("").rfind("line 1, column 1: ", 0), 0u) << refusal("");
  EXPECT_EQ(refusal("[1,]").rfind("line 1, column 4: ", 0), 0u) << refusal("[1,]");
  EXPECT_EQ(refusal("NaN").rfind("line 1, column 1: ", 0), 0u) << refusal("NaN");
}

TEST(JsonDocument, AKeyGivenTwiceIsRefusedWithItsPath) {
  EXPECT_EQ(refusal(R"({"a": 1, "a": 2})"), "a: the key is there twice");
  EXPECT_EQ(refusal(R"({"b": [0, {"c": {"d": 1, "e": 2, "d": 3}}]})"),
            "b[1].c.d: the key is there twice");
}

TEST(JsonDocument, NumbersBeyondADoubleAreRefusedWithTheirPath) {
  EXPECT_EQ(refusal(R"({"a": [1, 2, {"b": 1e999}]})"), "a[2].b: expected a finite number");
  EXPECT_EQ(refusal("-1e999"), "expected a finite number");
}

TEST(JsonDocument, DeepNestingIsRefusedAndNotFollowed) {
  const std::string deep(1000000, '[');
  EXPECT_NE(refusal(deep).find("nested more than 64 levels deep"), std::string::npos);
  std::string objects;
  for (int i = 0; i < 100000; ++i) objects += "{\"a\":";
  EXPECT_NE(refusal(objects).find("nested more than 64 levels deep"), std::string::npos);
}

TEST(JsonDocument, HugeArraysAreReadOrRefusedBySize) {
  std::string many = "[0";
  for (int i = 0; i < 1000000; ++i) many += ",0";
  EXPECT_EQ(refusal(many + "]"), "accepted");
  EXPECT_EQ(refusal(std::string(17u << 20, ' ')), "expected at most 16 MiB of JSON");
}

TEST(JsonDocument, TheFirstErrorIsKept) {
  const auto tree = parse_json(R"({"a": "x", "b": -1})");
  ASSERT_TRUE(tree.ok());
  std::optional<Error> error;
  const JsonReader root(*tree, "", error);
  EXPECT_EQ(root.at("a").number(Bounds::at_least(0)), 0.0);
  EXPECT_EQ(root.at("b").number(Bounds::at_least(0)), 0.0);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message, "a: expected a number >= 0, got \"x\"");
}

TEST(JsonDocument, StrangeKeysAndLongValuesAreShownSafely) {
  const auto tree = parse_json("{\"a b\\n\": \"" + std::string(5000, 'y') + "\"}");
  ASSERT_TRUE(tree.ok());
  std::optional<Error> error;
  JsonReader(*tree, "", error).at("a b\n").boolean();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message.rfind("[\"a b\\n\"]: expected true or false, got \"yyy", 0), 0u);
  EXPECT_LT(error->message.size(), 200u);
}

}  // namespace
}  // namespace maille
