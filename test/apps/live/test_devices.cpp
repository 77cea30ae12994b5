#include "../recordings/io_fixture.h"
#include "live/device_kinds.h"
#include "live/devices.h"

#include <algorithm>

namespace {

using io_test::refuses;
using namespace fuse_flow;

std::vector<io::DeviceKind> kindsOfDevices() {
  return {io::openni2Kind(), io::realSenseKind(), io::k4aKind(), io::orbbecKind()};
}

/** \brief Whether devices of this kind have numbers, as "#1". */
bool numbered(const io::DeviceKind& kind) { return kind.scheme == "openni2" || kind.scheme == "orbbec"; }

TEST(Devices, ANameWithASchemeIsADevice) {
  for (const char* name : {"openni2:#1", "openni2:", "realsense:", "realsense:012345", "k4a:0", "k4a:000123456712",
                           "orbbec:", "orbbec:#2", "orbbec:CL8M3430035"})
    EXPECT_TRUE(io::isDevice(name)) << name;
}

TEST(Devices, SchemesThatCannotBeOpenedAreDevicesToo) {
  for (const char* name : {"femto:1", "gemini:1", "zed:0", "kinect:", "freenect2:1"})
    EXPECT_TRUE(io::isDevice(name)) << name;
}

TEST(Devices, FilesAreNoDevices) {
  for (const char* name : {"", ":", "recording", "left.mkv", "/tmp/k4a", "realsense", "RealSense:1", "C:/left.mkv",
                           "./realsense:1", "bag:left"})
    EXPECT_FALSE(io::isDevice(name)) << name;
}

TEST(Devices, AnotherNameIsRefusedWithTheRightForms) {
  EXPECT_TRUE(refuses([] { io::openDevice("left.mkv"); },
                      {"left.mkv: is no device", "openni2:#1", "realsense:SERIAL", "k4a:0", "orbbec:SERIAL"}));
  EXPECT_TRUE(refuses([] { io::openDevice(""); }, {"is no device"}));
}

TEST(Devices, AKindThatIsNeverOpenedSaysWhichIsInstead) {
  EXPECT_TRUE(refuses([] { io::openDevice("femto:1"); }, {"femto:1: ", "orbbec:", "K4A wrapper", "realsense:SERIAL"}));
  EXPECT_TRUE(refuses([] { io::openDevice("astra:1"); }, {"astra:1: ", "openni2:", "orbbec:"}));
  EXPECT_TRUE(refuses([] { io::openDevice("zed:0"); }, {"zed:0: ", "record it"}));
}

TEST(Devices, AKindWithoutItsLibrarySaysWhichAndThatItMustBeBuiltAgain) {
  bool any = false;
  for (const io::DeviceKind& kind : kindsOfDevices()) {
    EXPECT_EQ(kind.open == nullptr, !kind.missing.empty()) << kind.scheme;
    EXPECT_EQ(kind.open == nullptr, kind.list == nullptr) << kind.scheme;
    if (kind.open) continue;
    any = true;
    EXPECT_TRUE(refuses([&] { io::openDevice(kind.scheme + ":0123"); },
                        {kind.scheme + ":0123: cannot be opened", "built without", kind.missing, "build it again"}));
  }
  if (!any) GTEST_SKIP() << "all libraries are there";
}

TEST(Devices, ADeviceThatIsNotThereSaysWhichAre) {
  bool any = false;
  for (const io::DeviceKind& kind : kindsOfDevices()) {
    if (!kind.open) continue;
    any = true;
    std::vector<io::ConnectedDevice> connected;
    try {
      connected = kind.list();
    } catch (const io::InputError&) {  // OpenNI 2 without drivers
      EXPECT_TRUE(refuses([&] { kind.open(""); }, {kind.scheme + ": "}));
      continue;
    }
    const std::string name = kind.scheme + ":no-such-device";
    if (connected.empty()) {
      for (const std::string id : {"", "no-such-device", numbered(kind) ? "#999" : "999"})
        EXPECT_TRUE(refuses([&] { io::openDevice(kind.scheme + ":" + id); },
                            {kind.scheme + (id.empty() ? "" : ":" + id) + ": no " + kind.called + " is connected"}));
    } else {
      EXPECT_TRUE(refuses([&] { io::openDevice(name); }, {name + ": is not connected", connected[0].name}));
    }
  }
  if (!any) GTEST_SKIP() << "no library is there";
}

TEST(Devices, TheMessageNamesTheConnectedDevicesOfTheKind) {
  EXPECT_TRUE(refuses(
      [] {
        io::failNotConnected("k4a:3", io::k4aKind(), {{"k4a:11", "Azure Kinect"}, {"k4a:22", "Azure Kinect"}});
      },
      {"k4a:3: is not connected", "k4a:11 (Azure Kinect), k4a:22 (Azure Kinect)"}));
}

TEST(Devices, NumbersBeginAt1) {
  bool any = false;
  for (const io::DeviceKind& kind : {io::openni2Kind(), io::orbbecKind()}) {
    if (!kind.open) continue;
    try {
      kind.list();
    } catch (const io::InputError&) {  // OpenNI 2 without drivers
      continue;
    }
    any = true;
    const std::string scheme = kind.scheme + ":";
    for (const char* id : {"#0", "#", "#one", "#-1"})
      EXPECT_TRUE(refuses([&] { kind.open(id); }, {scheme + id + ": must be " + scheme + "#1"})) << id;
  }
  if (!any) GTEST_SKIP() << "no library is there, or its drivers are not";
}

TEST(Devices, TheNameOfACameraIsThatOfItsDeviceInLettersAndDigits) {
  EXPECT_EQ(io::cameraNameOf("openni2:#1"), "openni2_1");
  EXPECT_EQ(io::cameraNameOf("openni2:2bc5/0401@1/5"), "openni2_2bc5_0401_1_5");
  EXPECT_EQ(io::cameraNameOf("realsense:012345"), "realsense_012345");
  EXPECT_EQ(io::cameraNameOf("orbbec:CL8M3430035"), "orbbec_CL8M3430035");
}

TEST(Devices, EachConnectedDeviceIsALine) {
  const std::vector<std::string> lines = io::listDevices();
  for (const char* kind : {"openni2", "realsense", "k4a", "orbbec"})  // each is there, or it is said why not
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.rfind(kind, 0) == 0;
    })) << kind;
  for (const std::string& line : lines) {
    EXPECT_EQ(line.find('\n'), std::string::npos);
    EXPECT_NE(line.find(':'), std::string::npos) << line;
  }
}

TEST(Devices, UpToThreeDigitsAreANumberAndMoreASerialNumber) {
  EXPECT_EQ(io::deviceIndex("0"), 0u);
  EXPECT_EQ(io::deviceIndex("12"), 12u);
  EXPECT_EQ(io::deviceIndex("999"), 999u);
  for (const char* serial : {"", "0123", "000123456712", "-1", "+1", "1x", " 1", "#1"})
    EXPECT_FALSE(io::deviceIndex(serial)) << serial;
}

}  // namespace
