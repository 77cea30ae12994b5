#pragma once

#include "gpu_stages.h"

#include <cmath>
#include <cstdio>

namespace bench {

/** \brief A frame of the room in float metres, all of it larger or smaller. */
struct ScaledRoom {
  fuse_flow::gpu::PinnedBuffer<float> depth;
  fuse_flow::RigFrame frame;
  std::size_t pixels;

  ScaledRoom(const Room& room, double scale, bool scattered = false) : pixels(room.pixels()) {
    std::vector<char> images(room.bytes());
    frame = room.render(images.data(), 0);
    depth.resize(room.pixels());
    const auto* millimetres = reinterpret_cast<const std::uint16_t*>(images.data());
    for (std::size_t k = 0; k < room.pixels(); ++k) {
      // Scattered: no two pixels that are neighbours in the image are so in space.
      const double metres = scattered ? 1.5 + 0.01 * static_cast<double>(k * 7919 % 397) : 0.001 * millimetres[k];
      depth.data()[k] = static_cast<float>(scale * metres);
    }
    for (std::size_t i = 0; i < frame.views.size(); ++i) {
      frame.cameras[i].T_world_camera.translation() *= scale;
      const auto& K = frame.cameras[i].intrinsics;
      frame.views[i] = fuse_flow::DepthView();
      frame.views[i].depth32 = {depth.data() + i * room.pixelsOfCamera(), K.width, K.height};
    }
  }
};

/** \brief How often a frame whose stages were measured outgrew the table of coarse cells: that stage then comes again. */
inline std::size_t growthsOf(Gpu& fusion) {
  std::size_t times = 0;
  for (const auto& stage : fusion.stageTimes().stages()) times += std::string(stage.name) == "points, cells" ? 1 : 0;
  return times > 0 ? times - 1 : 0;
}

/** \brief Slots of the table of coarse cells: as many as a first frame is given, and four times as many for each time that it
 *  outgrew them. */
inline std::size_t tableSlots(std::size_t pixels, std::size_t growths) {
  fuse_flow::gpu::Execution run;
  fuse_flow::gpu::CellTable table;
  fuse_flow::gpu::DeviceBuffer<std::uint32_t> counters;
  counters.resize(2);
  table.start(run, pixels / 64, counters.data(), counters.data() + 1);
  run.wait();
  return table.capacity() << 2 * growths;
}

/** \brief Of a first frame. */
inline std::size_t growthsOf(const fuse_flow::RigFrame& frame, const fuse_flow::FuseFlowParameters& parameters) {
  Gpu fusion;
  fusion.setParameters(parameters);
  fusion.stageTimes().enabled = true;
  fusion.fusePinned(frame);
  return growthsOf(fusion);
}

/** \brief The table as full as a frame can make it: the smallest coarse cells with which it does not outgrow it more often than
 *  asked for. That is not a table without an empty slot: a search gives up after CellTableView::kMaxProbes of them. How long the
 *  longest search is depends on which points come first, so the cells are those that held eight times.
 *  \param cell_size one that is large enough, metres  \param too_small one that is not */
inline fuse_flow::FuseFlowParameters fillingTheTable(const fuse_flow::RigFrame& frame,
                                                     fuse_flow::FuseFlowParameters parameters, std::size_t growths,
                                                     float cell_size, float too_small) {
  const float children = parameters.aggregation.min_cell_size / parameters.aggregation.cell_size;
  const auto fits = [&](float size, int tries) {
    parameters.aggregation.cell_size = size;
    parameters.aggregation.min_cell_size = children * size;
    while (tries > 0 && growthsOf(frame, parameters) <= growths) --tries;
    return tries == 0;
  };
  for (int k = 0; k < 12; ++k) {
    const float middle = std::sqrt(cell_size * too_small);
    (fits(middle, 1) ? cell_size : too_small) = middle;
  }
  while (!fits(cell_size, 8)) cell_size *= 1.005f;
  return parameters;
}

/** \brief Float depth without colour: times relative to those of the ordinary frame. */
inline void runUnusual(const Size& size, const fuse_flow::FuseFlowParameters& usual, bool quick) {
  using fuse_flow::FuseFlowParameters;
  const Room room(size.cameras, size.width, size.height);
  const ScaledRoom ordinary(room, 1), tiny(room, 0.1 / 6), vast(room, 1000.0 / 6), scattered(room, 1, true),
      empty(room, 0);
  ScaledRoom with_multipath(room, 1);
  for (fuse_flow::Camera& camera : with_multipath.frame.cameras) camera.multipath.modulation_frequency = 200e6f;
  const ScaledRoom small(Room(1, size.width / 2, size.height / 2), 1);

  FuseFlowParameters of_tiny = usual, of_vast = usual, of_scattered = usual, of_one_cell = usual;
  const auto scaleRange = [](FuseFlowParameters& parameters, float scale) {
    parameters.preprocessing.min_range *= scale;
    parameters.preprocessing.max_range *= scale;
  };
  scaleRange(of_tiny, 0.1f / 6);
  scaleRange(of_vast, 1000.0f / 6);
  of_vast.max_noise = of_scattered.max_noise = 0;  // which would drop what is meant to be a load
  of_scattered.use_measurement_confidence = false;
  of_scattered.aggregation.cell_size = of_scattered.aggregation.min_cell_size = 0.004f;
  of_one_cell.aggregation.cell_size = 10.0f;
  const FuseFlowParameters full = fillingTheTable(ordinary.frame, usual, growthsOf(ordinary.frame, usual),
                                                  usual.aggregation.cell_size, usual.aggregation.cell_size / 4);
  const std::size_t of_small_cells = growthsOf(scattered.frame, of_scattered);
  const FuseFlowParameters scattered_and_full =
      fillingTheTable(scattered.frame, of_scattered, of_small_cells > 0 ? of_small_cells - 1 : 0, 0.1f, 0.004f);
  struct Case {
    const char* name;
    std::vector<const ScaledRoom*> rooms;
    const FuseFlowParameters* parameters;
  };
  const Case cases[] = {
      {"ordinary", {&ordinary}, &usual},
      {"corrected for multipath interference", {&with_multipath}, &usual},
      {"0.1 m across", {&tiny}, &of_tiny},
      {"1 km across", {&vast}, &of_vast},
      {"every pixel a coarse cell of its own", {&scattered}, &of_scattered},
      {"ordinary, the hash table as full as it gets", {&ordinary}, &full},
      {"scattered pixels, the hash table as full as it gets", {&scattered}, &scattered_and_full},
      {"one coarse cell a room", {&ordinary}, &of_one_cell},
      {"nothing measured", {&empty}, &usual},
      {"large and small in turn", {&ordinary, &small}, &usual},
  };
  std::printf(
      "| frame | cell size | points | coarse cells | slots | load | first frame | device time | of the ordinary | "
      "latency | "
      "of the ordinary |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  double usual_device = 0, usual_latency = 0;
  for (const Case& unusual : cases) {
    const fuse_flow::gpu::OwnStream stream;
    Gpu fusion;
    fusion.setStream(stream.get());
    fusion.setParameters(*unusual.parameters);
    fuse_flow::gpu::Execution().wait();
    fusion.stageTimes().enabled = true;
    const Clock::time_point begin = Clock::now();
    const std::size_t points = fusion.fusePinned(unusual.rooms[0]->frame).size;
    const double first = since(begin);
    const std::size_t cells = fusion.getStatistics().coarse_cells;
    const std::size_t slots = tableSlots(unusual.rooms[0]->pixels, growthsOf(fusion));
    const std::size_t bytes = fusion.getDeviceBytes();
    std::vector<double> device, latency;
    for (int k = 0; k < (quick ? 16 : 64); ++k) {
      const std::size_t turn = static_cast<std::size_t>(k) % unusual.rooms.size();
      fusion.stageTimes().enabled = k % 4 > 1;  // which costs latency
      const Clock::time_point start = Clock::now();
      fusion.fusePinned(unusual.rooms[turn]->frame);
      if (turn > 0 || k < 8) continue;
      if (fusion.stageTimes().enabled) {
        device.push_back(deviceTime(fusion.stageTimes().stages()));
      } else {
        latency.push_back(since(start));
      }
    }
    if (usual_device == 0) {
      usual_device = median(device);
      usual_latency = median(latency);
    }
    std::printf("| %s | %.1f mm | %zu | %zu | %zu | %.3f%s | %.1f ms | %.3f ms | %.2f | %.3f ms | %.2f |\n",
                unusual.name, 1e3 * static_cast<double>(unusual.parameters->aggregation.cell_size), points, cells,
                slots, static_cast<double>(cells) / static_cast<double>(slots),
                fusion.getDeviceBytes() == bytes ? "" : " (outgrown by a later frame)", first, median(device),
                median(device) / usual_device, median(latency), median(latency) / usual_latency);
    std::fflush(stdout);
  }
}

}  // namespace bench
