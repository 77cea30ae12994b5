#include "recordings/files/file_io.h"

#include "io_fixture.h"

#include <sys/stat.h>

namespace {

using namespace io_test;

class FileIo : public IoTest {
 protected:
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
};

TEST_F(FileIo, BytesComeBackAsTheyWereWritten) {
  std::string bytes;
  for (int i = 0; i < 1000; ++i) bytes += static_cast<char>(i);
  io::writeFile(path("a"), bytes);
  EXPECT_EQ(io::readFile(path("a")), bytes);
  io::writeFile(path("a"), "");
  EXPECT_EQ(io::readFile(path("a")), "");
  EXPECT_EQ(files(), 1u);
}

TEST_F(FileIo, WhatCannotBeReadIsNamed) {
  EXPECT_TRUE(refuses([&] { io::readFile(path("no")); }, {path("no"), "not found"}));
  EXPECT_TRUE(refuses([&] { io::readFile(folder_.string()); }, {folder_.string(), "is a folder"}));
}

TEST_F(FileIo, WhatMayNeverGiveAByteIsNotOpened) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  EXPECT_TRUE(refuses([&] { io::readFile(path("pipe")); }, {path("pipe"), "is a pipe", "must be a file"}));
  fs::create_symlink("/dev/zero", folder_ / "link");
  EXPECT_TRUE(refuses([&] { io::readFile(path("link")); }, {path("link"), "is a device", "must be a file"}));
  ASSERT_EQ(mknod(path("socket").c_str(), S_IFSOCK | 0600, 0), 0);
  EXPECT_TRUE(refuses([&] { io::readFile(path("socket")); }, {path("socket"), "is a socket", "must be a file"}));
}

TEST_F(FileIo, WhatAFolderHoldsIsSorted) {
  write("b", "");
  write("a", "");
  write("c/d", "");
  EXPECT_EQ(io::filesIn(folder_.string()), (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_TRUE(io::filesIn(path("no")).empty());
}

TEST_F(FileIo, WhatCannotBeLookedAtIsNotTakenForNothing) {
  fs::create_symlink("loop", folder_ / "loop");  // as a folder without permission, which is none for root
  EXPECT_TRUE(refuses([&] { io::isThere(path("loop")); }, {path("loop"), "cannot be looked at"}));
  EXPECT_TRUE(refuses([&] { io::filesIn(path("loop/a")); }, {path("loop/a"), "cannot be looked at"}));
  EXPECT_TRUE(refuses([&] { io::readFile(path("loop")); }, {path("loop"), "cannot be looked at"}));
  EXPECT_TRUE(refuses([&] { io::filesIn(write("file", "")); }, {path("file"), "must be a folder"}));
  EXPECT_FALSE(io::isThere(path("file/a")));
}

TEST_F(FileIo, WhatCannotBeWrittenIsNamedAndLeavesNothing) {
  EXPECT_TRUE(refuses<io::OutputError>([&] { io::writeFile(path("no/a"), "x"); }, {path("no/a"), "does not exist"}));
  EXPECT_TRUE(refuses<io::OutputError>([&] { io::writeFile(folder_.string(), "x"); }, {folder_.string(), "folder"}));
  EXPECT_TRUE(refuses<io::OutputError>([] { io::writeFile("/dev/full", "x"); }, {"/dev/full", "No space left"}));
  EXPECT_EQ(files(), 0u);
}

TEST_F(FileIo, ANameAsLongAsTheDiskTakesIsWritten) {
  const std::string longest(255, 'n');
  io::writeFile(path(longest), "x");
  EXPECT_EQ(io::readFile(path(longest)), "x");
  EXPECT_EQ(files(), 1u);
  EXPECT_TRUE(refuses<io::OutputError>([&] { io::writeFile(path(longest + "n"), "x"); }, {"cannot be written"}));
  EXPECT_EQ(files(), 1u);
}

TEST_F(FileIo, AFileThatIsTooLargeIsNotRead) {
  const std::string file = write("a", "123456");
  EXPECT_EQ(io::readFile(file, 6), "123456");
  EXPECT_EQ(io::readFileStart(file, 4), "1234");
  EXPECT_EQ(io::readFileStart(file, 40), "123456");
  EXPECT_TRUE(refuses([&] { io::readFile(file, 5); }, {file, "6 bytes", "5 or less"}));
  fs::resize_file(file, std::uintmax_t{1} << 40);  // a tebibyte, none of which is on the disk
  EXPECT_TRUE(refuses([&] { io::readFile(file); }, {file, "1099511627776 bytes"}));
}

TEST_F(FileIo, ALinkStaysALink) {
  write("target", "old");
  fs::create_symlink("target", folder_ / "link");
  io::writeFile(path("link"), "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(io::readFile(path("target")), "new");
}

}  // namespace
