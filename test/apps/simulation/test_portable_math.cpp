#include "simulation/pi.h"
#include "simulation/portable_math.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

namespace portable = fuse_flow::simulation::portable;
constexpr double half_turn = fuse_flow::simulation::kPi;

TEST(PortableMath, KnowsTheAnglesThatEveryoneKnows) {
  EXPECT_NEAR(portable::sin(half_turn / 6), 0.5, 1e-16);
  EXPECT_NEAR(portable::cos(half_turn / 3), 0.5, 2e-16);
  EXPECT_NEAR(portable::tan(half_turn / 4), 1, 2e-16);
  EXPECT_EQ(portable::cos(0.0), 1);
  EXPECT_EQ(portable::sin(0.0), 0);
  EXPECT_EQ(portable::exp(0.0), 1);
  EXPECT_NEAR(portable::exp(1.0), 2.718281828459045, 1e-15);
  EXPECT_NEAR(portable::acos(0.5), half_turn / 3, 4e-16);
  EXPECT_NEAR(portable::acos(-1.0), half_turn, 4e-16);
  EXPECT_EQ(portable::acos(1.0), 0);
  EXPECT_NEAR(portable::atan2(1.0, -1.0), 0.75 * half_turn, 4e-16);
  EXPECT_NEAR(portable::atan2(-1.0, -1.0), -0.75 * half_turn, 4e-16);
  EXPECT_NEAR(portable::atan2(-2.0, 0.0), -0.5 * half_turn, 4e-16);
  EXPECT_NEAR(portable::hypot(3.0f, 4.0f), 5, 1e-6f);
}

TEST(PortableMath, AgreesWithTheCLibrary) {
  for (int k = -20000; k <= 20000; ++k) {
    const double x = 0.0173 * k;
    ASSERT_NEAR(portable::sin(x), std::sin(x), 1e-15) << x;
    ASSERT_NEAR(portable::cos(x), std::cos(x), 1e-15) << x;
    ASSERT_NEAR(portable::exp(0.1 * x), std::exp(0.1 * x), 1e-15 * std::exp(0.1 * x)) << x;
    const double c = k / 20000.0;
    ASSERT_NEAR(portable::acos(c), std::acos(c), 2e-15) << c;
    ASSERT_NEAR(portable::atan2(c, std::cos(x)), std::atan2(c, std::cos(x)), 2e-15) << c << ' ' << x;
  }
  EXPECT_EQ(portable::exp(-1000.0), 0);
}

TEST(PortableMath, TurnsAsEigenDoes) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  for (double angle = -7; angle < 7; angle += 0.3)
    EXPECT_TRUE(portable::turn(angle, axis)
                    .toRotationMatrix()
                    .isApprox(Eigen::AngleAxisd(angle, axis).toRotationMatrix(), 1e-14));
}

}  // namespace
