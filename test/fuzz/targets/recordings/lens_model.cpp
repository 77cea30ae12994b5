#include "../../fuzz_target.h"

#include "recordings/calibrations/lens_models.h"

#include <fuse_flow/recordings/error.h>

#include <sstream>

/** \brief A lens of another model than ours, as calibrations name it: a line with the model, and its coefficients. One that is not taken as it is, is fitted by
 *  samples of its whole image, which takes a thousand times as long as another input: seeds of calibrations have none. */
FUSE_FLOW_FUZZ_TARGET(lens_model, 4 << 20, 64, 3) {
  using namespace fuse_flow;
  std::istringstream text{std::string(input)};
  std::string model;
  std::getline(text, model);
  std::vector<double> coefficients;
  for (double k = 0; coefficients.size() < 16 && text >> k;) coefficients.push_back(k);
  const Intrinsics K{64, 48, 40, 40, 31.5f, 23.5f, {}};
  fuse_flow_fuzz::accepts<io::InputError>([&] {
    std::vector<std::string> warnings;
    io::withDistortion("camera", K, model, coefficients, warnings);
  });
}
