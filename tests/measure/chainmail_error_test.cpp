#include "measure/chainmail_error.h"

#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "measure/chainmail_error_page.h"
#include "tests/core/scratch.h"
#include "tests/measure/xml.h"

namespace maille {
namespace {

ChainMailErrorOptions small() {
  ChainMailErrorOptions options;
  options.runs = 1;
  options.reference_runs = 1;
  options.edge = 48;
  options.head_edge = 128;  // smaller ones have no nose to pull
  options.relaxed_within_voxels = 0.05;
  return options;
}

const ChainMailError::Order& order_of(const ChainMailError::Scene& scene, const std::string& name) {
  for (const auto& order : scene.orders) {
    if (order.name == name) return order;
  }
  throw std::out_of_range(name);
}

TEST(ChainMailError, TheProductIsExactAndTheOthersAreWhereTheyShouldBe) {
  const auto report = measure_chainmail_error(small());
  ASSERT_TRUE(report.ok());
  ASSERT_EQ((*report).scenes.size(), 6u);
  for (const auto& scene : (*report).scenes) {
    SCOPED_TRACE(scene.name);
    ASSERT_EQ(scene.orders.size(), 5u);  // the product with 1 and 2 threads, and three references
    EXPECT_EQ(scene.moved_voxels, scene.asked_voxels) << "the scenes are made not to be held";
    EXPECT_GT(scene.affected_elements, 50);
    for (const auto& order : scene.orders) {
      SCOPED_TRACE(order.name);
      EXPECT_GT(order.timing.median_seconds, 0.0);
      EXPECT_LE(order.elements_moved, scene.affected_elements);
      EXPECT_GE(order.max_to_exact_voxels, order.rms_to_exact_voxels);
      EXPECT_GE(order.max_to_relaxed_voxels, order.rms_to_relaxed_voxels);
      if (order.name != "exact" && order.name != "dijkstra") continue;
      EXPECT_EQ(order.violated_links, 0);
      EXPECT_EQ(order.max_to_exact_voxels, 0.0);
    }
  }
  const auto& one_material = (*report).scenes[0];
  EXPECT_EQ(order_of(one_material, "heap").max_to_exact_voxels, 0.0);
  EXPECT_EQ(order_of(one_material, "fifo").max_to_exact_voxels, 0.0);
  const auto& random_voxels = (*report).scenes[2];
  EXPECT_GT(order_of(random_voxels, "heap").violated_links, 0);
  EXPECT_GT(order_of(random_voxels, "fifo").worst_violation_voxels, 0.1);

  const auto& second_grab = (*report).scenes[4];
  EXPECT_EQ(second_grab.name, "second_grab");
  EXPECT_GT(order_of(second_grab, "heap").violated_links, 100);
  EXPECT_GT(order_of(second_grab, "heap").max_to_exact_voxels, 0.1);

  const MeasurePage page = page_of(*report);
  EXPECT_EQ(test::xml_fault(page.svg), "");
  const auto json = nlohmann::json::parse(page.json);
  EXPECT_EQ(json["stage"], "chainmail");
  ASSERT_EQ(json["scenes"].size(), 6u);
  for (const auto& scene : json["scenes"]) {
    EXPECT_EQ(scene["relaxed"]["converged"], true);
    EXPECT_LE(scene["relaxed"]["residual_voxels"], 0.05);
    EXPECT_GT(scene["relaxed"]["iterations"], 0);
    for (const auto& order : scene["orders"]) {
      EXPECT_NEAR(order["violated_share"],
                  double{order["violated_links"]} / double{scene["affected_links"]}, 1e-12);
    }
  }
  EXPECT_EQ(std::count(page.csv.begin(), page.csv.end(), '\n'), 1 + 6 * 5);
  const test::Scratch folder;
  ASSERT_TRUE(prepare_folder(folder / "new/one").ok());
  ASSERT_TRUE(write_page(page, folder / "new/one", "name").ok());
  EXPECT_EQ(test::bytes_of(folder / "new/one/name.svg"), page.svg);
  EXPECT_EQ(test::bytes_of(folder / "new/one/name.csv"), page.csv);
  EXPECT_EQ(test::bytes_of(folder / "new/one/name.json"), page.json);
  EXPECT_EQ(folder.names(), std::set<std::string>{"new"});
}

TEST(Page, AFolderThatCannotBeIsRefusedBeforeAnyWork) {
  const test::Scratch folder;
  folder.write("file", "x");
  const auto refused = prepare_folder(folder / "file/below");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::file_system);
  EXPECT_FALSE(prepare_folder(folder / "file").ok());
  EXPECT_FALSE(prepare_folder("/proc/maille").ok());
}

}  // namespace
}  // namespace maille
