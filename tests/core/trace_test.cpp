#include "core/trace.h"

#include <cctype>
#include <thread>

#include <gtest/gtest.h>

#include "tests/core/scratch.h"

namespace maille {
namespace {

// Just enough JSON to say whether a text is one value and nothing else.
class JsonChecker {
 public:
  explicit JsonChecker(std::string_view text) : rest_(text) {}
  bool is_one_value() { return value() && (skip_space(), rest_.empty()); }

 private:
  bool value() {
    skip_space();
    if (rest_.empty()) return false;
    if (rest_[0] == '{')
      return sequence('{', '}', [this] { return string() && take(':') && value(); });
    if (rest_[0] == '[') return sequence('[', ']', [this] { return value(); });
    if (rest_[0] == '"') return string();
    std::size_t length = 0;
    while (length < rest_.size() &&
           (std::isalnum(static_cast<unsigned char>(rest_[length])) ||
            std::string_view("+-.").find(rest_[length]) != std::string_view::npos)) {
      ++length;
    }
    rest_.remove_prefix(length);
    return length > 0;
  }
  template <class F>
  bool sequence(char open, char close, F&& item) {
    if (!take(open)) return false;
    if (take(close)) return true;
    while (item()) {
      if (take(close)) return true;
      if (!take(',')) return false;
    }
    return false;
  }
  bool string() {
    if (!take('"')) return false;
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      if (rest_[i] == '\\') {
        ++i;
      } else if (rest_[i] == '"') {
        rest_.remove_prefix(i + 1);
        return true;
      } else if (static_cast<unsigned char>(rest_[i]) < 0x20) {
        return false;
      }
    }
    return false;
  }
  bool take(char c) {
    skip_space();
    if (rest_.empty() || rest_[0] != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void skip_space() {
    while (!rest_.empty() && std::isspace(static_cast<unsigned char>(rest_[0]))) {
      rest_.remove_prefix(1);
    }
  }

  std::string_view rest_;
};

TEST(JsonCheckerOfTheTest, TellsJsonFromWhatIsNone) {
  EXPECT_TRUE(JsonChecker(R"({"a": [1, -2.5e3, "x\"y", {}], "b": null})").is_one_value());
  for (const char* bad : {"", "{", "[1,]", R"({"a" 1})", R"(["a)", "[1] 2", "[1 2]"}) {
    EXPECT_FALSE(JsonChecker(bad).is_one_value()) << bad;
  }
}

// One test, because the recorder is one for the process and never stops.
TEST(Trace, RecordsOnceStartedAndWritesJson) {
  const test::Scratch folder;
  { const trace::Span unseen("before the start"); }
  trace::add_span("a track", "before the start too", 1, 2);
  EXPECT_FALSE(trace::running());
  ASSERT_TRUE(trace::write(folder / "empty.json").ok());
  EXPECT_TRUE(JsonChecker(test::bytes_of(folder / "empty.json")).is_one_value());

  trace::start();
  EXPECT_TRUE(trace::running());
  { const trace::Span span("outer"); }
  std::jthread([] {
    trace::name_this_thread("the \"other\" \\ thread\n");
    const trace::Span span("on another thread");
  }).join();
  trace::add_span("gpu queue", "ray cast", 5'000'000, 7'500'000);
  ASSERT_TRUE(trace::write(folder / "trace.json").ok());

  const auto json = test::bytes_of(folder / "trace.json");
  EXPECT_TRUE(JsonChecker(json).is_one_value()) << json;
  for (const char* expected :
       {R"("name":"outer")", R"("name":"on another thread")", R"(the \"other\" \\ thread)",
        R"("name":"ray cast","ts":5000.000000,"dur":2500.000000)", R"("name":"gpu queue")"}) {
    EXPECT_NE(json.find(expected), std::string::npos) << expected << "\n" << json;
  }
  EXPECT_EQ(json.find("before the start"), std::string::npos);
}

TEST(Trace, AnUnwritablePathIsAFileSystemError) {
  const test::Scratch folder;
  const auto written = trace::write(folder / "nowhere" / "trace.json");
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().kind, ErrorKind::file_system);
}

}  // namespace
}  // namespace maille
