#include "app/relaxation_text.h"

#include <limits>

#include <gtest/gtest.h>

namespace maille {
namespace {

using Lines = std::vector<std::string>;

SimulationStatus relaxing() {
  SimulationStatus s;
  s.relaxing = true;
  s.free_elements = 1000;
  s.volume_elements = 8000;
  s.residual_voxels = 0.1234;
  s.residual_rms_voxels = 0.02345;
  s.iterations = 7;
  return s;
}

TEST(RelaxationText, NothingWhereNothingHasRelaxed) { EXPECT_EQ(relaxation_text({}), Lines{}); }

TEST(RelaxationText, SaysHowFarItStillIs) {
  SimulationStatus s = relaxing();
  EXPECT_EQ(relaxation_text(s),
            Lines{"relaxation: 0.12 voxels from equilibrium (RMS 0.023 voxels), step 7"});
  s.residual_voxels = 12.3;
  s.residual_rms_voxels = 1.23;
  s.paused = true;
  EXPECT_EQ(relaxation_text(s),
            Lines{"relaxation (paused): 12 voxels from equilibrium (RMS 1.2 voxels), step 7"});
  s.paused = false;
  s.residual_voxels = s.residual_rms_voxels = std::numeric_limits<double>::infinity();
  EXPECT_EQ(relaxation_text(s), Lines{"relaxation: first step"});
  s.free_elements = 0;
  EXPECT_EQ(relaxation_text(s), Lines{"relaxation: being set up"});
}

TEST(RelaxationText, SaysHowItEnded) {
  SimulationStatus s = relaxing();
  s.relaxing = false;
  s.converged = true;
  s.residual_voxels = 0.00876;
  EXPECT_EQ(relaxation_text(s), Lines{"relaxation: at equilibrium, within 0.0088 voxels"});
  s.residual_voxels = 0.0;
  EXPECT_EQ(relaxation_text(s), Lines{"relaxation: at equilibrium"});
  s.converged = false;
  s.no_nearer = true;
  s.residual_voxels = 0.05;
  EXPECT_EQ(relaxation_text(s),
            Lines{"relaxation: comes no nearer to equilibrium, about 0.050 voxels from it"});
}

TEST(RelaxationText, SaysWhatMemoryDoesNotAllow) {
  SimulationStatus s = relaxing();
  s.region_limited = true;
  const auto lines = relaxation_text(s);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[1], "relaxing 1000 of 8000 elements: memory (--lattice-memory)");
}

}  // namespace
}  // namespace maille
