#include "support/tool_fixture.h"

namespace tool_test {
namespace {

class Picture : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    writeText(folder_ / "cloud.ply",
              "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
              "end_header\n0 0 0\n1 1 1\n");
  }
};

TEST_F(Picture, ACloudThatIsNotThereIsNamed) {
  EXPECT_TRUE(isOneLineError(runProgram(FUSE_FLOW_PICTURE_TOOL, {out("none.ply"), "-o", out("picture.png")}), 1,
                             {out("none.ply"), "not found"}));
}

TEST_F(Picture, AnOptionOutOfRangeIsNamed) {
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--size", "0", "100"},
                                                 {"--from", "nan", "0", "0"},
                                                 {"--zoom", "0"},
                                                 {"--point-size", "1e30"}}) {
    std::vector<std::string> arguments{out("cloud.ply"), "-o", out("picture.png")};
    arguments.insert(arguments.end(), option.begin(), option.end());
    EXPECT_TRUE(isOneLineError(runProgram(FUSE_FLOW_PICTURE_TOOL, arguments), 2, {option[0], option[1]}));
  }
}

TEST_F(Picture, WithoutADisplayItSaysHowToGetOne) {
  EXPECT_TRUE(isOneLineError(
      runProgram("/usr/bin/env", {"-u", "DISPLAY", FUSE_FLOW_PICTURE_TOOL, out("cloud.ply"), "-o", out("picture.png")}),
      1, {"DISPLAY", "xvfb-run"}));
  EXPECT_FALSE(fs::exists(out("picture.png")));
}

}  // namespace
}  // namespace tool_test
