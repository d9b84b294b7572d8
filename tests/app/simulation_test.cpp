// A person at the simulation, without a window: what comes in which order.
//
// Nothing is timed: what should come is waited for, however long it takes.
#include "app/simulation.h"

#include <atomic>
#include <chrono>
#include <fstream>
#include <random>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/trace.h"
#include "tests/core/scratch.h"

namespace maille {
namespace {

MaterialTable soft(double stiffness = 1.0, std::optional<double> yield_strain = {}) {
  Material m;
  m.name = "soft";
  m.value_low = 0;
  m.value_high = 10;
  m.compress = glm::dvec3(0.6);
  m.stretch = glm::dvec3(1.5);
  m.shear = glm::dvec3(0.2);
  m.stiffness = stiffness;
  m.yield_strain = yield_strain;
  return std::move(MaterialTable::create({m})).value();
}

std::unique_ptr<Document> document_of(Size3 size, int threads = 2,
                                      std::optional<std::int64_t> lattice_memory = {},
                                      double tolerance_voxels = 0.01) {
  Scene scene;
  scene.relaxation.tolerance_voxels = tolerance_voxels;
  scene.materials = soft();
  DocumentOptions options;
  options.command = "window";
  options.purpose = {.pictures = true, .window = true, .picks = true};
  options.threads = threads;
  options.lattice_memory_bytes = lattice_memory;
  const Volume volume =
      Volume::of(size, VoxelType::uint8, axis_aligned(glm::dvec3(1)),
                 std::vector<std::uint8_t>(static_cast<std::size_t>(voxel_count(size)), 5));
  auto document = Document::open(std::move(scene), {volume, 0.0, std::nullopt}, options);
  EXPECT_TRUE(document.ok());
  return *std::move(document);
}

// Long enough for any machine; only what is wrong takes as long.
template <class F>
bool comes_true(F&& f) {
  for (int i = 0; i < 200000; ++i) {
    if (f()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

bool view_comes(Simulation& simulation) {
  return comes_true([&] { return simulation.take_view().has_value(); });
}

bool comes_to_rest(Simulation& simulation) {
  return comes_true([&] {
    static_cast<void>(simulation.take_view());
    const SimulationStatus s = simulation.status();
    return !s.relaxing && (s.converged || s.no_nearer);
  });
}

// Clay keeps a part of a pull when its pin is removed, at once or after the springs have come to
// rest, and undo takes it back.
TEST(Simulation, ClayStaysWhereItWasPulledHoweverLongItWasHeld) {
  std::vector<glm::dvec3> stays;
  for (const bool waits : {true, false}) {
    const auto document = document_of({30, 31, 32});
    {
      Simulation simulation(*document, [] {});
      simulation.set_materials(soft(1.0, 0.05));
      simulation.grab({15, 15, 15}, 3);
      simulation.drag_to({4, 1, 0});
      simulation.let_go();
      if (waits) {
        ASSERT_TRUE(comes_to_rest(simulation));
      }
      simulation.release_pins();
      ASSERT_TRUE(comes_true([&] { return simulation.status().pins == 0; }));
      ASSERT_TRUE(comes_to_rest(simulation));
      stays.push_back(document->lattice().displacement_voxels({15, 15, 15}));
      EXPECT_FALSE(document->deformer().kept().at_rest());
      EXPECT_GT(document->deformer().kept().displacement_voxels({15, 15, 15}).x, 1.0);
      simulation.undo();
      ASSERT_TRUE(comes_true([&] { return simulation.status().pins == 1; }));
    }
    EXPECT_TRUE(document->deformer().kept().at_rest());
  }
  EXPECT_GT(stays[0].x, 1.0);
  EXPECT_LT(glm::length(stays[0] - stays[1]), 0.1);
}

TEST(Simulation, AHeldHandleComesToEquilibriumAndThenNothingMoves) {
  const auto document = document_of({40, 40, 40});
  {
    std::atomic<int> woken{0};
    Simulation simulation(*document, [&] { ++woken; });
    simulation.grab({20, 20, 20}, 3);
    simulation.drag_to({4, 0, 0});
    ASSERT_TRUE(view_comes(simulation));
    ASSERT_TRUE(comes_to_rest(simulation));
    SimulationStatus s = simulation.status();
    EXPECT_TRUE(s.converged);
    EXPECT_GT(s.iterations, 0);
    EXPECT_LE(s.residual_voxels, 0.01);
    EXPECT_LT(s.residual_rms_voxels, s.residual_voxels);
    EXPECT_GT(s.free_elements, 0);
    EXPECT_FALSE(s.region_limited);

    // Let go, the handle stays pinned: an equilibrium still.
    simulation.let_go();
    ASSERT_TRUE(comes_true([&] { return simulation.status().pins == 1; }));
    ASSERT_TRUE(comes_to_rest(simulation));
    EXPECT_EQ(simulation.status().iterations, s.iterations);

    // Undone and redone it is the same one, and nobody looks for another.
    simulation.undo();
    ASSERT_TRUE(comes_true([&] { return simulation.status().pins == 0; }));
    simulation.redo();
    ASSERT_TRUE(comes_true([&] { return simulation.status().pins == 1; }));
    ASSERT_TRUE(comes_to_rest(simulation));
    EXPECT_EQ(simulation.status().iterations, 0);

    // Without its pin it springs back.
    simulation.release_pins();
    ASSERT_TRUE(comes_true([&] { return simulation.status().pins == 0; }));
    ASSERT_TRUE(comes_true([&] { return simulation.status().iterations > 0; }));
    ASSERT_TRUE(comes_to_rest(simulation));
  }
  EXPECT_LT(glm::length(document->lattice().displacement_voxels({20, 20, 20})), 0.05);
}

std::int64_t count_spans(const std::string& name) {
  const test::Scratch folder;
  EXPECT_TRUE(trace::write(folder / "trace.json").ok());
  const auto json = nlohmann::json::parse(std::ifstream(folder / "trace.json"));
  std::int64_t count = 0;
  for (const auto& event : json.is_array() ? json : json["traceEvents"]) {
    count += event["name"] == name;
  }
  return count;
}

// Of a volume so large that springs for it take much longer than a drag.
TEST(Simulation, ADragDoesNotWaitForARelaxationThatIsOnItsWay) {
  constexpr int kDrags = 6;
  const auto document = document_of({128, 128, 128});
  trace::start();
  const auto set_up_before = count_spans("spring energy");
  const auto begun_before = count_spans("relaxation set-up");
  {
    Simulation simulation(*document, [] {});
    simulation.grab({64, 64, 64}, 4);
    for (int n = 1; n <= kDrags; ++n) {
      simulation.drag_to({10.0 + n, 0, 0});
      ASSERT_TRUE(view_comes(simulation));
      // Once it is at work the next drag comes.
      ASSERT_TRUE(comes_true([&] { return simulation.status().relaxing; }));
    }
    simulation.drag_to({5, 0, 0});
    ASSERT_TRUE(view_comes(simulation));
  }
  // A set-up ends with the energy of the springs. Were each drag to wait for the one before it, or
  // the end for the last, there would be as many.
  EXPECT_LT(count_spans("spring energy") - set_up_before, kDrags);
  EXPECT_LE(count_spans("relaxation set-up") - begun_before, kDrags + 1);
}

// A wish that is refused and changes nothing: when it is, all before it have been done.
bool all_is_done(Simulation& simulation) {
  simulation.redo();
  return comes_true([&] { return simulation.status().refused == "nothing to redo"; });
}

TEST(Simulation, AGrabTakesWhatIsShownAndNothingBeyond) {
  const auto document = document_of({64, 64, 64}, 2, {}, 1e-9);
  std::optional<ViewUpdate> shown;
  {
    std::atomic<int> woken{0};
    Simulation simulation(*document, [&] { ++woken; });
    simulation.grab({32, 32, 32}, 3);
    simulation.drag_to({6, 2, 0});
    ASSERT_TRUE(view_comes(simulation));
    simulation.let_go();
    ASSERT_TRUE(comes_true([&] { return simulation.status().pins == 1; }));
    ASSERT_TRUE(view_comes(simulation)) << "a state that has been relaxed";
    // One more comes; nobody takes it, and relaxation goes on beyond it.
    const int before = woken;
    ASSERT_TRUE(comes_true([&] { return woken > before; }));
    const auto there = simulation.status().iterations;
    ASSERT_TRUE(comes_true([&] {
      const auto s = simulation.status();
      return s.iterations >= there + 2 || !s.relaxing;
    }));
    simulation.pause_or_resume_relaxation();
    ASSERT_TRUE(comes_true([&] { return simulation.status().paused; }));
    simulation.grab({20, 32, 32}, 3);
    simulation.let_go();
    ASSERT_TRUE(all_is_done(simulation));
    shown = simulation.take_view();
    ASSERT_TRUE(shown.has_value());
  }
  const Resampler now(document->volume(), document->lattice(), document->cuts(),
                      ResampleMethod::linear, 0.0);
  for (int x = 25; x < 50; ++x) {
    EXPECT_EQ(shown->resampler->rest_position(glm::dvec3(x, 33.0, 31.0)),
              now.rest_position(glm::dvec3(x, 33.0, 31.0)));
  }
}

TEST(Simulation, WhatMemoryAllowsIsRelaxedAndTheRestSaid) {
  const auto document = document_of({64, 64, 64}, 2, std::int64_t{4} << 20);
  Simulation simulation(*document, [] {});
  simulation.grab({32, 32, 32}, 3);
  simulation.drag_to({3, 0, 0});
  ASSERT_TRUE(comes_to_rest(simulation));
  const SimulationStatus s = simulation.status();
  EXPECT_TRUE(s.region_limited);
  EXPECT_EQ(s.volume_elements, 64 * 64 * 64);
  EXPECT_LT(s.free_elements, 62 * 62 * 62);
  EXPECT_GT(s.free_elements, 1000);
}

// In every order, made for the thread sanitizer; the end is the same equilibrium as without the way
// there.
TEST(Simulation, AnySessionEndsAtTheEquilibriumOfItsLastState) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    const auto document = document_of({36, 34, 33});
    {
      Simulation simulation(*document, [] {});
      bool paused = false;
      for (int n = 0; n < 60; ++n) {
        switch (below(11)) {
          case 0: simulation.let_go(); break;
          case 1: simulation.cancel(); break;
          case 2: simulation.release_pins(); break;
          case 3: simulation.undo(); break;
          case 4: simulation.redo(); break;
          case 5: simulation.set_materials(soft(1.0 + below(3))); break;
          case 6:
            simulation.pause_or_resume_relaxation();
            paused = !paused;
            break;
          case 7: static_cast<void>(simulation.take_view()); break;
          case 8:
            simulation.grab({8 + below(20), 8 + below(18), 8 + below(17)}, 2);
            [[fallthrough]];
          default: simulation.drag_to({below(7) - 3.0, below(7) - 3.0, below(7) - 3.0});
        }
        if (below(3) == 0) std::this_thread::sleep_for(std::chrono::milliseconds(below(8)));
      }
      simulation.let_go();
      for (int n = 0; n < 60; ++n) simulation.undo();
      simulation.grab({18, 17, 16}, 2);
      simulation.drag_to({3, 0, 1});
      simulation.let_go();
      if (paused) simulation.pause_or_resume_relaxation();
      ASSERT_TRUE(all_is_done(simulation));
      ASSERT_TRUE(comes_to_rest(simulation));
    }
    Deformer alone(document->volume(), soft(), {});
    WorkerPool pool(1);
    ASSERT_TRUE(alone.begin_stroke({18, 17, 16}, 2).ok());
    ASSERT_TRUE(alone.drag_to({3, 0, 1}, pool).ok());
    alone.end_stroke();
    Relaxation relaxation = alone.relax(pool, {});
    while (!relaxation.progress().finished()) relaxation.iterate();
    alone.adopt(relaxation.lattice());
    double furthest = 0.0;
    for (int z = 0; z < 33; ++z) {
      for (int y = 0; y < 34; ++y) {
        for (int x = 0; x < 36; ++x) {
          furthest =
              std::max(furthest, glm::length(alone.lattice().displacement_voxels({x, y, z}) -
                                             document->lattice().displacement_voxels({x, y, z})));
        }
      }
    }
    EXPECT_LT(furthest, 0.1);
  }
}

}  // namespace
}  // namespace maille
