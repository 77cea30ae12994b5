#pragma once

#include <fuse_flow/recordings/image.h>

#include <string>
#include <vector>

namespace fuse_flow::drawing {

/** \brief A line of a chart. */
struct Series {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
};

struct ChartText {
  std::string title;
  std::string x;
  std::string y;
};

/** \brief Lines with a marker at each value; both axes from 0. Needs a display: see requireDisplay(). */
io::ColorImage drawLines(const ChartText& text, const std::vector<Series>& series);

/** \brief Groups of bars beside each other, one colour for each name; y from 0. \param values of each name in each group */
io::ColorImage drawBars(const ChartText& text, const std::vector<std::string>& groups,
                        const std::vector<std::string>& names, const std::vector<std::vector<double>>& values);

}  // namespace fuse_flow::drawing
