
#include "io_fixture.h"
#include "recordings/files/file_io.h"
#include "room.h"

#include <fuse_flow/recordings/input_files.h>
#include <fuse_flow/recordings/recording.h>

namespace {

using namespace io_test;

class InputFiles : public IoTest {
 protected:
  testing::AssertionResult isInput(io::InputFiles& inputs, const std::string& output) const {
    return refuses<io::OptionError>([&] { inputs.refuseToReplace("--report", output); },
                                    {"--report", output, "is an input"});
  }
};

TEST_F(InputFiles, AFileIsOneByEveryNameThatItHas) {
  const std::string file = write("a/one.txt", "");
  fs::create_symlink(file, path("soft"));
  fs::create_hard_link(file, path("hard"));
  fs::create_directory_symlink(path("a"), path("b"));
  io::InputFiles inputs({file});
  for (const char* name : {"a/one.txt", "a/../a/one.txt", "soft", "hard", "b/one.txt"})
    EXPECT_TRUE(isInput(inputs, path(name))) << name;
  write("a/two.txt", "");
  for (const char* name : {"a/two.txt", "a/one.txt.json", "no/one.txt"})
    EXPECT_NO_THROW(inputs.refuseToReplace("-o", path(name))) << name;
}

TEST_F(InputFiles, AllOfAFolderIsInputWhateverItsNameAndAlsoWhatIsNotThereYet) {
  write("in/deep/notes", "");
  io::InputFiles inputs({path("in")});
  for (const char* name : {"in/deep/notes", "in/new.json", "in/deep/new.ply", "in/none/new.ply"})
    EXPECT_TRUE(isInput(inputs, path(name))) << name;
  EXPECT_NO_THROW(inputs.refuseToReplace("-o", path("inside.ply")));
  EXPECT_NO_THROW(inputs.refuseToReplace("-o", path("new.ply")));
}

TEST_F(InputFiles, WhatAFolderLinksToIsInputToo) {
  const std::string image = write("elsewhere/000000.png", "");
  fs::create_directory(path("depth"));
  fs::create_symlink(image, path("depth/000000.png"));
  fs::create_directory_symlink(path("depth"), path("depth/loop"));
  io::InputFiles inputs({path("depth")});
  EXPECT_TRUE(isInput(inputs, image));
}

TEST_F(InputFiles, ADeviceAndWhatIsNotThereAreNone) {
  io::InputFiles inputs({path("no"), "", "/dev/null"});
  EXPECT_NO_THROW(inputs.refuseToReplace("-o", "/dev/null"));
  EXPECT_NO_THROW(inputs.refuseToReplace("-o", path("no")));
}

}  // namespace
