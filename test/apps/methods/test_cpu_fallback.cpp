#include "methods/cpu_fallback.h"

#include <fuse_flow/device_error.h>

#include <gtest/gtest.h>

#include <memory>
#include <new>
#include <string>
#include <vector>

namespace {

using fuse_flow::DeviceError;
using fuse_flow::io::CpuFallback;
using fuse_flow::io::Method;

/** \brief Writes a cloud of so many points; the number of the frame that fails is counted from 0. */
class Counting : public Method {
 public:
  Counting(std::size_t points, int fails_at, int& alive) : points_(points), fails_at_(fails_at), alive_(alive) {
    ++alive_;
  }
  ~Counting() override { --alive_; }
  void fuse(const fuse_flow::RigFrame&, Cloud& output) override {
    if (frames_++ == fails_at_) throw DeviceError("fuse_flow::gpu: lost");
    output.resize(points_);
    statistics_.fused_points = points_;
    with_normals_.resize(points_);
  }

 private:
  std::size_t points_;
  int fails_at_, frames_{0};
  int& alive_;
};

class CpuFallbackTest : public testing::Test {
 protected:
  CpuFallback fallback(int gpu_fails_at) {
    return CpuFallback([=] { return std::make_unique<Counting>(1, gpu_fails_at, gpus_); },
                       [this] {
                         EXPECT_EQ(gpus_, 0) << "the GPU's memory is given back first";
                         return std::make_unique<Counting>(2, -1, cpus_);
                       },
                       [this](const std::string& message) { said_.push_back(message); });
  }

  int gpus_{0}, cpus_{0};
  std::vector<std::string> said_;
  fuse_flow::RigFrame frame_;
  Method::Cloud cloud_;
};

TEST_F(CpuFallbackTest, ThereIsNoCpuWhereTheGpuWorks) {
  CpuFallback method = fallback(-1);
  for (int k = 0; k < 3; ++k) {
    method.fuse(frame_, cloud_);
    EXPECT_EQ(cloud_.size(), 1u);
  }
  EXPECT_EQ(cpus_, 0);
  EXPECT_TRUE(said_.empty());
}

TEST_F(CpuFallbackTest, TheFrameThatFailsIsFusedByTheCpuAsAreThoseAfterIt) {
  CpuFallback method = fallback(2);
  for (int k = 0; k < 5; ++k) {
    method.fuse(frame_, cloud_);
    const std::size_t expected = k < 2 ? 1 : 2;
    EXPECT_EQ(cloud_.size(), expected) << k;
    EXPECT_EQ(method.statistics().fused_points, expected) << k;
    EXPECT_EQ(method.withNormals().size(), expected) << k;
  }
  ASSERT_EQ(said_.size(), 1u);
  EXPECT_NE(said_[0].find("fuse_flow::gpu: lost"), std::string::npos) << said_[0];
  EXPECT_NE(said_[0].find("--device gpu"), std::string::npos) << said_[0];
}

TEST_F(CpuFallbackTest, AGpuThatCannotEvenBeginIsReplaced) {
  CpuFallback method([]() -> std::unique_ptr<Method> { throw DeviceError("fuse_flow::gpu: out of GPU memory"); },
                     [this] { return std::make_unique<Counting>(2, -1, cpus_); },
                     [this](const std::string& message) { said_.push_back(message); });
  method.fuse(frame_, cloud_);
  EXPECT_EQ(cloud_.size(), 2u);
  EXPECT_EQ(said_.size(), 1u);
}

TEST_F(CpuFallbackTest, WhereThereIsNoMemoryForTheCpuEitherTheNextFrameTriesAgain) {
  bool there_is_memory = false;
  CpuFallback method([this] { return std::make_unique<Counting>(1, 0, gpus_); },
                     [&]() -> std::unique_ptr<Method> {
                       if (!there_is_memory) throw std::bad_alloc();
                       return std::make_unique<Counting>(2, -1, cpus_);
                     },
                     [this](const std::string& message) { said_.push_back(message); });
  EXPECT_THROW(method.fuse(frame_, cloud_), std::bad_alloc);
  EXPECT_THROW(method.fuse(frame_, cloud_), std::bad_alloc);
  EXPECT_EQ(method.statistics().fused_points, 0u);
  EXPECT_TRUE(method.withNormals().empty());
  there_is_memory = true;
  method.fuse(frame_, cloud_);
  EXPECT_EQ(cloud_.size(), 2u);
  EXPECT_EQ(said_.size(), 1u);
}

TEST_F(CpuFallbackTest, WhatIsWrongWithTheFrameIsNotAskedTwice) {
  struct Refusing : Method {
    void fuse(const fuse_flow::RigFrame&, Cloud&) override { throw pcl::BadArgumentException("the frame"); }
  };
  CpuFallback method([] { return std::make_unique<Refusing>(); },
                     [this] { return std::make_unique<Counting>(2, -1, cpus_); },
                     [this](const std::string& message) { said_.push_back(message); });
  EXPECT_THROW(method.fuse(frame_, cloud_), pcl::BadArgumentException);
  EXPECT_EQ(cpus_, 0);
  EXPECT_TRUE(said_.empty());
}

}  // namespace
